"""Where a run stands, as data and in a few words."""

from typing import TYPE_CHECKING

from folding_schemas.actions import Actions
from folding_schemas.results import CheckpointState, RunInfo

from folding_server.errors import RunError
from folding_server.simulator import folded_state
from folding_server.simulator.vertices import id_ranges
from folding_server.store.exploration import Checkpoint
from folding_server.store.views import RunView

if TYPE_CHECKING:
    from folding_server.mcp.context import AppContext

UNIT_SQUARE = (1.0, 1.0)
"""The sheet of a run with photos."""


def run_info(run: RunView) -> RunInfo:
    """The run as hosts see it."""
    return RunInfo(
        run_id=run.run_id,
        sequence=run.sequence,
        frames=run.frames,
        front_color=run.front_color,
        back_color=run.back_color,
        saved=sorted(run.checkpoints),
        next_frame=run.next_frame,
        pending=list(run.pending),
        attempts={frame: len(made) for frame, made in run.attempts.items()},
        restores=dict(run.restores),
        budget=run.budget or 0,
        locked_to=run.locked_to,
        complete=run.complete,
        program=run.program(),
        attempts_used={frame: run.used(frame) for frame in run.attempts},
        attempts_left=run.attempts_left,
    )


def checkpoint_at(run: RunView, frame: int) -> Checkpoint:
    """The checkpoint of a frame. RunError, naming the saved frames, if there is none."""
    if frame not in run.checkpoints:
        saved = id_ranges(run.checkpoints) or "none"
        raise RunError(
            f"Frame {frame} has no checkpoint; saved frames: {saved}. Use save_checkpoint to make one."
        )
    return run.checkpoints[frame]


def checkpoint_state(app: "AppContext", run: RunView, frame: int) -> CheckpointState:
    """The state saved for a frame, as hosts see it. RunError, naming the saved frames, if there is none."""
    saved = checkpoint_at(run, frame)
    return CheckpointState(
        frame=frame,
        actions=list(saved.actions),
        notes=saved.notes,
        state=folded_state(app.replays.after(run.sheet, saved.path)),
    )


def check_between(run: RunView, frame: int) -> None:
    """Raise RunError unless the current state grew from the checkpoint of the frame before."""
    if run.base != frame - 1:
        where = f"grew from checkpoint {run.base}" if run.base else "comes before frame 1 is saved"
        way = (
            f"restore_checkpoint({frame - 1})" if frame - 1 in run.checkpoints else f"frame {frame - 1} saved"
        )
        raise RunError(
            f"The current state {where}, so it does not lead to frame {frame}; that needs {way} first."
        )


def known_steps(run: RunView) -> tuple[Actions, ...]:
    """The actions between each two saved photos that led from the unit square to the current state; none if more was done since, or
    the sheet is no such square.
    """
    return () if run.pending or run.sheet != UNIT_SQUARE else run.current_program().steps


def next_step(run: RunView) -> str:
    """What there is to do next, in one sentence."""
    if run.free:
        return "Fold as you like; there are no photos to match."
    if run.complete:
        return f"All {run.frames} frames are saved."
    if not run.base:
        return "Next: save_checkpoint(1), the flat sheet."
    if run.next_frame is None:
        return f"This is the last frame, {run.frames}; earlier ones are missing."
    return f"Next: frame {run.next_frame}."


def attempt_in_words(run: RunView) -> str:
    """Which attempt at which frame the pending actions belong to, or how many are left; empty in a free fold."""
    if run.attempts_left is None:
        return ""
    attempt, frame = run.open_attempt, run.base + 1
    if attempt is None:
        return f"Attempts left at frame {frame}: {run.attempts_left} of {run.budget}."
    number = "" if attempt.number == run.used(frame) else f" (number {attempt.number} in list_attempts)"
    return f"Attempt {run.used(frame)} of {run.budget} at frame {frame}{number}."
