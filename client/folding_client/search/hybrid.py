"""The geometric solver before the model: what is clear from the photos needs no model to decide it.

It acts where the best of the server's proposals is clearly the best, and saves the frame if the result matches the
photo. Every other frame is the model's, who is told what the solver found.
"""

from folding_prompts import prompt
from folding_schemas.results import CheckpointSaved, RunInfo

from folding_client.interrupts import StepOver, ToolRefused
from folding_client.messages import Message, ToolResult, user
from folding_client.protocol.server_client import ServerClient
from folding_client.record.recorder import Recorder
from folding_client.search.frame_search import Calls, FrameSearch, SearchOptions
from folding_client.search.search_file import write_search
from folding_client.search.search_state import FrameStep, Proposed, SearchState

SOLVER = "geometric"
"""Who decided a frame that the solver saved."""
CLEAR = SearchOptions(proposals=3, first_tries=1, attempts=2, tries_clear=True, first_notes="the flat sheet")
"""Three proposals are asked for, and shown to the model; after two attempts at a frame, the model's included, the
solver leaves the rest of the budget to the model."""
_MUST_SUCCEED = frozenset({"save_checkpoint", "restore_checkpoint"})


class HybridSolver:
    """Decides the frames that are clear. It asks once, and tries once, for a frame after the same steps."""

    def __init__(self, server: ServerClient, recorder: Recorder, state: SearchState) -> None:
        self._server = server
        self._recorder = recorder
        self._search = FrameSearch(state, CLEAR)

    async def look(self, info: RunInfo) -> Message:
        """What there is to tell the model about the next frame. StepOver if the solver has saved it."""
        calls = self._search.start(info)
        while calls is not None:
            self._keep()
            calls = self._search.go_on(await self._carry_out(calls))
        self._keep()
        return self._handed_over(FrameStep(info=info))

    async def _carry_out(self, calls: Calls) -> list[ToolResult]:
        """The answers to calls, up to the first that is refused. StepOver if the frame was saved."""
        results: list[ToolResult] = []
        for name, arguments in calls:
            result = await self._server.call(name, arguments)
            results.append(result)
            if result.is_error and name in _MUST_SUCCEED:
                raise ToolRefused(result.text)
            if result.is_error:
                break
            if name == "save_checkpoint":
                saved = CheckpointSaved.model_validate(result.data)
                raise StepOver(saved.frame, complete=saved.complete, by=SOLVER)
        return results

    def _handed_over(self, step: FrameStep) -> Message:
        proposed = self._search.state.proposals_for(step.frame, step.lineage)
        assert proposed is not None, "a frame is given up after the server was asked"
        outcome = self._outcome(proposed)
        self._recorder.event("handed_over", frame=step.frame, reason=outcome)
        return user(prompt("agent/found", frame=step.frame, answer=proposed.summary, outcome=outcome))

    def _outcome(self, proposed: Proposed) -> str:
        """Why the frame is left to the model."""
        step = self._search.state.step
        if not (proposed.confident and proposed.proposals):
            return prompt("agent/found_unsure")
        if step is not None and step.last is not None:
            return prompt("agent/found_wrong", why=step.why)
        return prompt("agent/found_tried")

    def _keep(self) -> None:
        write_search(self._recorder.folder, self._search.state)
