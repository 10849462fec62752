"""The geometric solver before the model: what is clear from the photos needs no model to decide it.

It acts where the best of the server's proposals is clearly the best, and saves the frame if the result matches the
photo. Every other frame is the model's, who is told what the solver found.
"""

from folding_prompts import prompt
from folding_schemas.actions import Action
from folding_schemas.results import CheckpointRestored, CheckpointSaved, Comparison, Proposals, RunInfo

from folding_client.interrupts import StepOver, ToolRefused
from folding_client.messages import Message, user
from folding_client.protocol.acting import carry_out
from folding_client.protocol.server_client import ServerClient
from folding_client.record.recorder import Recorder

NAME = "geometric"
"""Who decided a frame that the solver saved."""
COUNT = 3
"""Proposals asked for, and shown to the model."""
ATTEMPTS = 2
"""Attempts at a frame, the model's included, after which the solver leaves the rest of the budget to the model."""
Before = tuple[int, tuple[tuple[Action, ...], ...]]
"""A frame, and the steps that lead to the one before it."""


class HybridSolver:
    """Decides the frames that are clear. It asks once, and tries once, for a frame after the same steps."""

    def __init__(self, server: ServerClient, recorder: Recorder) -> None:
        self._server = server
        self._recorder = recorder
        self._found: dict[Before, tuple[Proposals | None, str]] = {}
        self._tried: set[Before] = set()

    async def look(self, info: RunInfo) -> Message:
        """What there is to tell the model about the next frame. StepOver if the solver has saved it."""
        frame = info.next_frame or info.frames
        if frame == 1:
            await self._save(1, "the flat sheet")
        before = frame, tuple(tuple(step) for step in info.program.steps[: frame - 2])
        proposals, answer = await self._proposals(before)
        if proposals is None or not (proposals.confident and proposals.proposals):
            outcome = prompt("agent/found_unsure")
        elif before in self._tried or info.attempts.get(frame, 0) >= ATTEMPTS:
            outcome = prompt("agent/found_tried")
        else:
            self._tried.add(before)
            outcome = prompt("agent/found_wrong", why=await self._try(frame, proposals.proposals[0].actions))
        self._recorder.event("handed_over", frame=frame, reason=outcome)
        return user(prompt("agent/found", frame=frame, answer=answer, outcome=outcome))

    async def _proposals(self, before: Before) -> tuple[Proposals | None, str]:
        """The server's proposals and its words; None, with the reason, if it has none to make."""
        if before not in self._found:
            result = await self._server.call("propose_actions", {"frame": before[0], "count": COUNT})
            proposals = None if result.is_error else Proposals.model_validate(result.structured)
            self._found[before] = proposals, result.text.replace(result.detail, "").strip()
        return self._found[before]

    async def _try(self, frame: int, actions: list[Action]) -> str:
        """Carry actions out and save the frame if it matches (StepOver); else take them back and say why not."""
        try:
            await carry_out(self._server, actions)
            comparison, _ = await self._server.ask(Comparison, "compare_to_frame", frame=frame)
        except ToolRefused as refusal:
            why = str(refusal)
        else:
            if comparison.verdict == "MATCH":
                await self._save(frame, f"agreement {comparison.agreement:.4f}, a match")
            why = " ".join([f"{comparison.verdict}.", *(f"{each}." for each in comparison.discrepancies)])
        await self._server.ask(CheckpointRestored, "restore_checkpoint", frame=frame - 1)
        return why

    async def _save(self, frame: int, notes: str) -> None:
        saved, _ = await self._server.ask(CheckpointSaved, "save_checkpoint", frame=frame, notes=notes)
        raise StepOver(frame, complete=saved.complete, by=NAME)
