"""After the server died in the middle of a call: was the call carried out? The store of the run knows."""

from dataclasses import dataclass, replace

from folding_schemas.results import ActionResult, AttemptCommitted, CheckpointSaved, RunInfo
from folding_schemas.state import FoldedState

from folding_client.messages import JsonObject, ToolResult

ACTIONS = frozenset({"add_vertex", "fold", "unfold", "rotate", "flip"})


@dataclass(frozen=True)
class Standing:
    """What the last answers said of the run: actions since its checkpoint, the frames saved, those closed."""

    pending: int = 0
    saved: frozenset[int] = frozenset()

    def after(self, tool: str, result: ToolResult) -> "Standing":
        """The standing after one more answered call."""
        data = result.data
        if result.is_error or data is None:
            return self
        if tool in ACTIONS:
            return replace(self, pending=self.pending + 1)
        if tool == "undo":
            return replace(self, pending=max(self.pending - 1, 0))
        if tool in {"open_run", "get_run"}:
            return Standing(len(data["pending"]), frozenset(data["saved"]))
        if tool in {"save_checkpoint", "commit_attempt"}:
            return Standing(0, self.saved | {data["frame"]})
        return replace(self, pending=0) if tool == "restore_checkpoint" else self


def carried_out(
    tool: str, arguments: JsonObject, before: Standing, now: RunInfo, state: JsonObject
) -> ToolResult | None:
    """The answer that the server owed if it had carried the call out, None if the call must be sent (again).

    What only reads, and a restore, can be sent again in any case.
    """
    answer: ActionResult | CheckpointSaved | AttemptCommitted | None = None
    change = len(now.pending) - before.pending
    if (tool in ACTIONS and change == 1) or (tool == "undo" and change == -1):
        answer = _action(tool, now, state)
    elif tool == "save_checkpoint" and _was_saved(arguments["frame"], before, now):
        answer = _saved(arguments["frame"], now)
    elif tool == "commit_attempt" and now.locked_to >= arguments["frame"]:
        answer = AttemptCommitted(
            frame=arguments["frame"],
            attempt=arguments["attempt"],
            locked_to=now.locked_to,
            next_frame=now.next_frame,
            complete=now.complete,
            state=FoldedState.model_validate(state["state"]),
        )
    if answer is None:
        return None
    return ToolResult(
        f"{tool} was carried out; the server was restarted since.", answer.model_dump(mode="json")
    )


def _action(tool: str, now: RunInfo, state: JsonObject) -> ActionResult:
    frame = now.next_frame
    return ActionResult(
        run_id=now.run_id,
        summary=f"{tool} was carried out; the server was restarted since.",
        new_vertices=[],
        new_faces=[],
        moved_faces=[],
        frame=frame,
        attempt=None if frame is None else now.attempts.get(frame),
        state=FoldedState.model_validate(state["state"]),
    )


def _was_saved(frame: int, before: Standing, now: RunInfo) -> bool:
    """The frame holds a checkpoint that the run did not have, or had with other actions, before the call."""
    return frame in now.saved and not now.pending and (before.pending > 0 or frame not in before.saved)


def _saved(frame: int, now: RunInfo) -> CheckpointSaved:
    steps = now.program.steps
    return CheckpointSaved(
        frame=frame,
        actions=list(steps[frame - 2]) if 1 < frame <= len(steps) + 1 else [],
        next_frame=now.next_frame,
        remaining=now.frames - len(now.saved),
        complete=now.complete,
    )
