"""The agent's loop: query the model, execute its tool calls, append the results. Limits are checked
in query.
"""

from dataclasses import dataclass

from folding_prompts import prompt
from folding_schemas.results import CheckpointRestored, CheckpointState, RunInfo

from folding_client.agent.context import StepContext
from folding_client.agent.context_compaction import ContextPolicy
from folding_client.agent.opening import StepView, look, opening, step_summary
from folding_client.agent.toolbox import Toolbox
from folding_client.interrupts import (
    AttemptsUsedUp,
    ContextExceeded,
    NothingCalled,
    ReplyCutOff,
    ReplyEmpty,
    StepFailed,
    StepHopeless,
    StepOver,
)
from folding_client.messages import Message, Reply, ToolCall, ToolResult, answered, tool_answer, user
from folding_client.progress import Progress
from folding_client.protocol.server_client import ServerClient
from folding_client.record.recorder import Recorder
from folding_client.roles.role_client import RoleClient
from folding_client.roles.selector import Selector, settle
from folding_client.search.hybrid import HybridSolver

GIVING_UP = frozenset({"restore_checkpoint", "undo"})
"""The tools that may end an attempt without saving what came of it."""
SILENT_REPLIES = 3
"""So many replies in a row without a tool call rewind the context to before them."""
CONTEXTS_EXCEEDED = 2
"""So many conversations in a row that are too long for the model end the run: the third would be no shorter."""


@dataclass(frozen=True)
class AgentSettings:
    """How an agent works: ``failures`` is how often one step may fail in a row before the run stops; ``policy`` says
    what goes out again with every query of a step. A model that ``looks`` is shown state, photos and diagram at once.
    """

    failures: int
    policy: ContextPolicy
    examples: tuple[Message, ...] = ()
    looks: bool = True


class Agent:
    """Reconstructs a sequence frame by frame. Every step starts from a fresh context; with a solver, only the frames
    that it leaves open are steps of the model's.
    """

    simulates = True

    def __init__(
        self,
        role_client: RoleClient,
        server: ServerClient,
        toolbox: Toolbox,
        selector: Selector,
        recorder: Recorder,
        progress: Progress,
        agent_settings: AgentSettings,
        solver: HybridSolver | None = None,
    ) -> None:
        self._role_client = role_client
        self._server = server
        self._toolbox = toolbox
        self._selector = selector
        self._recorder = recorder
        self._progress = progress
        self._settings = agent_settings
        self._solver = solver
        self._history: dict[int, CheckpointState] = {}
        self._failed = 0
        self._too_long = 0

    async def run(self) -> RunInfo:
        """Work until every frame is saved. RunStopped or ToolRefused if something ends the run before."""
        while not (info := await self._server.where()).complete:
            self._recorder.outcome("running", "", len(info.saved), info.frames)
            await self._step(info)
        return info

    async def _step(self, info: RunInfo) -> None:
        """One step, from its opening to whatever ends it."""
        info = await self._at_an_open_frame(info)
        frame = info.next_frame or info.frames
        self._progress.step(frame, info.frames, len(info.saved))
        self._recorder.event("step_started", frame=frame, saved=info.saved)
        try:
            if info.attempts_left == 0:
                raise AttemptsUsedUp(frame)
            await self._converse(info, await self._found(info))
        except StepOver as over:
            self._failed = self._too_long = 0
            self._recorder.event("step_over", frame=over.frame, complete=over.complete, by=over.by)
        except AttemptsUsedUp as spent:
            self._failed = 0
            await self._select(spent.frame)
        except StepFailed as failure:
            await self._start_again(frame, failure)

    async def _at_an_open_frame(self, info: RunInfo) -> RunInfo:
        """The run standing where a frame is left to do: after the last checkpoint of an unfinished chain."""
        if info.next_frame is not None:
            return info
        await self._server.ask(CheckpointRestored, "restore_checkpoint", frame=max(info.saved))
        return await self._server.where()

    async def _found(self, info: RunInfo) -> list[Message]:
        """What the solver has to tell of the next frame, if there is one. StepOver if it has saved the frame."""
        if self._solver is None:
            return []
        self._progress.doing("measuring the photos")
        return [await self._solver.look(info)]

    async def _converse(self, info: RunInfo, found: list[Message]) -> None:
        """Query, execute, append, until an interrupt ends the step; ``found`` is told with the opening."""
        opening = await self._opening(await self._server.where() if found else info)
        context = StepContext([*opening, *found], self._settings.policy)
        silent_from: list[int] = []
        while True:
            reply = await self._query(context)
            start = len(context)
            context.append(answered(reply))
            try:
                await self._execute(reply, context)
                silent_from.clear()
            except NothingCalled:
                silent_from.append(start)
                self._nudge(context, silent_from)

    async def _query(self, context: StepContext) -> Reply:
        messages, new_from = context.to_send()
        reply = await self._role_client.query(messages, list(self._toolbox.offered.values()), new_from)
        if reply.finish_reason == "length":
            message = "the reply ran into its token limit"
            raise ReplyCutOff(message)
        if not reply.tool_calls and not reply.text.strip():
            message = f"the reply is empty (it finished with {reply.finish_reason!r})"
            raise ReplyEmpty(message)
        return reply

    async def _execute(self, reply: Reply, context: StepContext) -> None:
        """Carry out the calls of a reply in order, and append each result as it comes."""
        if not reply.tool_calls:
            raise NothingCalled(reply.text)
        failed: ToolCall | None = None
        for call in reply.tool_calls:
            result = self._skipped(call, failed) or await self._carry_out(call)
            context.append(tool_answer(call, result))
            if result.is_error:
                failed = failed or call
            elif call.name == "save_checkpoint" and result.data:
                saved = result.data
                raise StepOver(saved["frame"], complete=saved["complete"], by=self._role_client.model.name)
            if result.is_error or call.name in GIVING_UP:
                await self._check_budget(call)

    async def _carry_out(self, call: ToolCall) -> ToolResult:
        self._progress.doing(call.name)
        return await self._toolbox.execute(call)

    def _skipped(self, call: ToolCall, failed: ToolCall | None) -> ToolResult | None:
        """A call that would change the paper after an earlier call of the same reply failed is not carried
        out.
        """
        spec = self._toolbox.offered.get(call.name)
        if failed is None or spec is None or spec.read_only:
            return None
        text = (
            f"Not carried out, because {failed.name} before it in the same reply failed; look at its "
            "error first."
        )
        self._recorder.event("skipped", call=call.name, because_of=failed.name)
        return ToolResult(text, is_error=True)

    def _nudge(self, context: StepContext, silent_from: list[int]) -> None:
        """Ask for a tool call; after the third silent reply in a row, go back to before them."""
        if len(silent_from) < SILENT_REPLIES:
            context.append(user(prompt("agent/nudge")))
            return
        context.rewind(silent_from[0])
        silent_from.clear()
        self._recorder.event("rewound", messages=len(context))
        self._count_failure(f"{SILENT_REPLIES} replies in a row called no tool")

    async def _start_again(self, frame: int, failure: StepFailed) -> None:
        """Put the paper back to the step's checkpoint and count the failure."""
        info = await self._server.where()
        if info.pending and frame > 1:
            await self._server.return_to((info.next_frame or 0) - 1)
        self._recorder.event("rolled_back", frame=frame, cause=type(failure).__name__, reason=str(failure))
        self._too_long = self._too_long + 1 if isinstance(failure, ContextExceeded) else 0
        if self._too_long == CONTEXTS_EXCEEDED:
            message = f"{str(failure).capitalize()} twice in a row; start a run with a model of more context, or --tools paper."
            raise StepHopeless(message)
        self._count_failure(str(failure))

    def _count_failure(self, why: str) -> None:
        self._failed += 1
        if self._failed >= self._settings.failures:
            message = (
                f"The step failed {self._failed} times in a row, the last time because {why}; resume to try "
                "again."
            )
            raise StepHopeless(message)

    async def _check_budget(self, call: ToolCall) -> None:
        """After an attempt was given up or a change refused: is there no attempt left from here?"""
        spec = self._toolbox.offered.get(call.name)
        if spec is None or spec.read_only:
            return
        info = await self._server.where()
        if info.attempts_left == 0:
            raise AttemptsUsedUp(info.next_frame or 0)

    async def _select(self, frame: int) -> None:
        """Let the selector choose among the states that the frame's attempts came to, and commit its choice."""
        self._progress.doing("choosing among the attempts")
        await settle(self._server, self._selector, self._recorder, frame)
        self._history.clear()

    async def _opening(self, info: RunInfo) -> list[Message]:
        for frame in info.saved:
            known = self._history.get(frame)
            if known is None or (frame > 1 and tuple(known.actions) != info.program.steps[frame - 2]):
                self._history[frame] = (
                    await self._server.ask(CheckpointState, "get_checkpoint_state", frame=frame)
                )[0]
        tools = list(self._toolbox.offered.values())
        summary = step_summary(info, self._history, self._toolbox.saved_against)
        view = StepView()
        if self._settings.looks and (info.next_frame or 0) > 1:
            view = await look(self._server, info.next_frame or 0)
        return opening(info, tools, summary, view, self._settings.examples)
