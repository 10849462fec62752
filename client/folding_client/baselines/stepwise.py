"""A model that works on each frame by a plan of its own: a generator that says calls and is told their results."""

import json
from collections.abc import Callable, Generator, Sequence

from folding_schemas.results import RunInfo

from folding_client.interrupts import StepHopeless
from folding_client.messages import Message, Reply, ToolCall, ToolResult, ToolSpec, last_results
from folding_client.search.frame_search import Calls

FrameWork = Generator[Calls, list[ToolResult], None]
"""The work on one frame, from its checkpoint before to its save. It begins with the calls it makes first, and is sent the
results of each list of calls, of which those after a refused one are missing or say so.
"""

FrameWorker = Callable[[RunInfo, int], FrameWork]
"""How a model works on a frame after the first, of which the run and the number are given; it begins at the checkpoint before."""


class StepwiseModel:
    """Begins ``worker`` anew whenever a context without a reply begins a step, and says what it calls."""

    def __init__(self, name: str, worker: FrameWorker) -> None:
        self.name = name
        self._worker = worker
        self._work: FrameWork | None = None
        self._replies = 0

    async def query(
        self,
        messages: Sequence[Message],
        tools: Sequence[ToolSpec],  # noqa: ARG002
        *,
        json_mode: bool = False,  # noqa: ARG002
    ) -> Reply:
        """The next calls. StepHopeless if the frame could not be saved."""
        results = last_results(messages)
        try:
            if results is None or self._work is None:
                self._work = _frame_work(self._worker)
                return self._reply(next(self._work))
            return self._reply(self._work.send(results))
        except StopIteration:
            self._work = None
            message = f"The model {self.name} could not save the frame; resume to try again."
            raise StepHopeless(message) from None

    def _reply(self, calls: Calls) -> Reply:
        self._replies += 1
        made = tuple(
            ToolCall(f"{self.name}_{self._replies}_{index}", tool, json.dumps(arguments))
            for index, (tool, arguments) in enumerate(calls, start=1)
        )
        return Reply(tool_calls=made, finish_reason="tool_calls")


def _frame_work(worker: FrameWorker) -> FrameWork:
    """The work on the frame that is next: the flat sheet is saved, at another one what was begun before is given up."""
    (answer,) = yield [("get_run", {})]
    info = RunInfo.model_validate(answer.data)
    frame = info.next_frame or info.frames
    if frame == 1:
        yield [save_call(1, "the flat sheet")]
        return
    if info.pending:
        yield [("restore_checkpoint", {"frame": frame - 1})]
    yield from worker(info, frame)


def compare_call(frame: int) -> tuple[str, dict[str, object]]:
    """A comparison of the current state with the photo of a frame."""
    return "compare_to_frame", {"frame": frame}


def save_call(frame: int, notes: str) -> tuple[str, dict[str, object]]:
    """The save of the current state as a frame."""
    return "save_checkpoint", {"frame": frame, "notes": notes}
