"""What a run's history allows next. A check is silent or raises RunError, one sentence that says what to do.

The rules hold inside the transaction that appends the event, so no two callers can break them together; tools
may call the same checks earlier, to refuse before they compute.

* Frame 1 is the flat sheet. In a sequence run nothing can be folded before it is saved, and it is saved
  without actions; later frames hang on it.
* Only the frame after the base can be saved. A saved frame is replaced by restoring the one before it,
  acting, and saving again: so what is replaced was left on purpose.
* Five attempts (``budget``) are allowed at a frame from one state of the frame before. The fifth may go on until it
  ends. Then actions towards that frame, and saving it unchanged, are refused until one of its attempts is committed
  (paper, section "Bounded exploration"), or the frame before becomes another. A frame may be tried from three states
  (``BUDGETS_PER_FRAME``), whatever becomes of them; from a fourth only while none of its attempts can be committed. So
  a frame is tried ``3 * budget`` times at most, and ``budget`` times more for each commitment to a frame before it.
  Restoring an earlier checkpoint stays possible.
* A technical return costs no attempt. The store takes the caller's word for it, MOST_TECHNICAL_RETURNS times at a frame.
* A commitment to frame t is final: frames up to t cannot be saved, and no frame before t can be restored.
  Frame t itself can: the work goes on from it, and without a way back to it the first wrong attempt at t+1
  could not be given up. Restoring t revisits nothing that was decided, since what t is cannot change.
* An attempt can be committed before the budget is used up.
"""

import math

from folding_schemas.actions import Action, AddVertex, Rotate

from folding_server.errors import RunError
from folding_server.store.exploration import Attempt
from folding_server.store.run_events import Acted, Committed, Opened, Restored, RunEvent, Saved, Undone
from folding_server.store.views import BUDGETS_PER_FRAME, RunView

MAX_NOTES = 10_000
"""The most characters that the notes of a checkpoint may have."""


MOST_TECHNICAL_RETURNS = 50
"""Attempts at a frame that may end by a technical return: a client of ours gives a step up after 10 failures in a row, and a frame
may be tried from three states, which leaves 20 for runs that were resumed."""


def check_event(view: RunView, event: RunEvent) -> None:
    """Raise RunError unless the event may happen to the run now."""
    match event:
        case Acted(action=action):
            check_may_act(view)
            _check_numbers(action)
        case Undone():
            check_may_undo(view)
        case Saved(frame=frame):
            check_may_save(view, frame)
        case Restored(frame=frame, technical=technical):
            check_may_restore(view, frame)
            if technical:
                _check_technical(view)
        case Committed(frame=frame, attempt=number, state=state):
            check_may_commit(view, frame, number, state)
        case Opened():
            raise RunError(f"run {view.run_id} is open; call open_run without run_id to start another")


def check_may_act(view: RunView) -> None:
    """Raise RunError unless an action may be applied to the current state."""
    if not view.base:
        raise RunError("nothing can be folded before frame 1 is saved; call save_checkpoint(1) first")
    if view.next_frame is None:
        raise RunError(f"frame {view.frames} is the last one, so no action can follow it{_way_back(view)}")
    _check_budget(view)


def check_may_undo(view: RunView) -> None:
    """Raise RunError unless there is an action since the base checkpoint."""
    if not view.pending:
        where = f"checkpoint {view.base} itself" if view.base else "the flat sheet"
        raise RunError(f"there is no action to undo: the current state is {where}{_way_back(view)}")


def check_may_save(view: RunView, frame: int) -> None:
    """Raise RunError unless the current state may be saved as this frame."""
    if frame != view.next_frame:
        raise RunError(_why_not_saved(view, frame))
    if frame > 1:
        _check_budget(view)


def check_may_restore(view: RunView, frame: int) -> None:
    """Raise RunError unless the frame's checkpoint exists and is not closed by a commitment."""
    if frame not in view.checkpoints:
        raise RunError(f"frame {frame} has no checkpoint to restore; {_saved_frames(view)}")
    if frame < view.locked_to:
        raise RunError(
            f"frame {frame} cannot be restored: {_locked(view)}; "
            f"restore_checkpoint({view.locked_to}) or a later one is allowed"
        )


def _check_technical(view: RunView) -> None:
    """Raise RunError if an attempt has begun and no more of them at its frame may cost nothing."""
    attempt = view.open_attempt
    if attempt is None:
        return
    ended = sum(not each.counted for each in view.attempts[attempt.frame])
    if ended >= MOST_TECHNICAL_RETURNS:
        raise RunError(
            f"{ended} attempts at frame {attempt.frame} have ended for technical reasons, which is all that cost nothing; "
            "restore without a technical reason, which costs an attempt, or save the frame"
        )


def check_may_commit(view: RunView, frame: int, number: int, state: int | None = None) -> None:
    """Raise RunError unless this attempt at the frame, or this state of it, may be chosen for good."""
    if view.free:
        raise RunError("a free fold has no attempts to commit; use save_checkpoint and restore_checkpoint")
    if frame <= view.locked_to:
        raise RunError(f"no attempt at frame {frame} can be committed: {_locked(view)}; go on from there")
    attempt = find_attempt(view, frame, number)
    find_state(attempt, state)
    if not view.committable(attempt):
        raise RunError(
            f"attempt {number} at frame {frame} grew from frames that a later commitment replaced; "
            f"make a new attempt from the checkpoint of frame {frame - 1}"
        )


def find_attempt(view: RunView, frame: int, number: int) -> Attempt:
    """The numbered attempt at the frame; RunError names those there are."""
    made = view.attempts.get(frame, ())
    if not made:
        tried = ", ".join(map(str, sorted(view.attempts))) or "none"
        raise RunError(f"there is no attempt at frame {frame}; frames with attempts: {tried}")
    if not 1 <= number <= len(made):
        raise RunError(f"there is no attempt {number} at frame {frame}; choose one from 1 to {len(made)}")
    return made[number - 1]


def find_state(attempt: Attempt, state: int | None) -> Attempt:
    """The attempt as it was when it had come to a state of it; RunError names those there are."""
    if state is None:
        return attempt
    if not 1 <= state <= len(attempt.states):
        raise RunError(
            f"there is no state {state} of attempt {attempt.number} at frame {attempt.frame}; "
            f"choose one from 1 to {len(attempt.states)}, or leave it out for the last"
        )
    return attempt.at(state)


def check_same_sequence(view: RunView, fingerprint: str | None) -> None:
    """Raise RunError if the run's sequence is not, or no longer, the one it was opened with."""
    if view.fingerprint != fingerprint:
        raise RunError(
            f"run {view.run_id} cannot be resumed: its sequence {view.sequence!r} has changed since; "
            f"put the old files back or call open_run without run_id to start again"
        )


def check_notes(notes: str | None) -> None:
    """Raise RunError if the notes are too long or are not text that can be stored."""
    if notes is None:
        return
    if len(notes) > MAX_NOTES:
        raise RunError(f"the notes have {len(notes)} characters; shorten them to {MAX_NOTES}")
    if any("\ud800" <= letter <= "\udfff" for letter in notes):
        raise RunError("the notes hold half of a surrogate pair; send plain Unicode text")


def _check_budget(view: RunView) -> None:
    if view.attempts_left != 0:
        return
    frame = view.base + 1
    spent = f"the {view.budget} attempts at frame {frame} are used up"
    if view.used(frame) < (view.budget or 0):
        spent = (
            f"frame {frame} has been tried from {BUDGETS_PER_FRAME} states of frame {view.base}, which is all"
        )
    raise RunError(
        f"{spent}; call list_attempts({frame}), then commit_attempt({frame}, k) with the best of them"
    )


def _check_numbers(action: Action) -> None:
    """Numbers that are not finite have no JSON form, so they could not be read back."""
    match action:
        case AddVertex(position=number) | Rotate(angle=number):
            if not math.isfinite(number):
                raise RunError(f"{number} in {action.action} is not a finite number; give one such as 0.5")


def _why_not_saved(view: RunView, frame: int) -> str:
    coming = f"the next to save is {view.next_frame}" if view.next_frame else "all frames are saved"
    if not view.free and not 1 <= frame <= view.frames:
        return f"there is no frame {frame} in this sequence; its frames are 1 to {view.frames}"
    if frame < 1:
        return f"there is no frame {frame}; frames count from 1 and {coming}"
    if not view.base:
        return f"frame {frame} cannot be saved before frame 1; call save_checkpoint(1) first"
    return f"{_why_not_saved_here(view, frame)}; {coming}"


def _why_not_saved_here(view: RunView, frame: int) -> str:
    if frame <= view.locked_to:
        return f"frame {frame} cannot be saved: {_locked(view)}"
    if frame == 1:
        return "frame 1 is the flat sheet and is saved already"
    if frame <= view.base:
        return (
            f"frame {frame} cannot be saved over checkpoint {view.base}, which the current state grew from; "
            f"restore_checkpoint({frame - 1}) to replace frame {frame}"
        )
    return f"frame {frame} cannot be saved yet: the current state grew from checkpoint {view.base}"


def _locked(view: RunView) -> str:
    return f"frames up to {view.locked_to} are committed for good"


def _saved_frames(view: RunView) -> str:
    if not view.checkpoints:
        return "none is saved yet, call save_checkpoint(1) first"
    last = len(view.checkpoints)
    return f"saved frames: {'1' if last == 1 else f'1 to {last}'}"


def _way_back(view: RunView) -> str:
    """What can be done from the current state to get further back, if anything."""
    earlier = view.base - 1
    if earlier < max(1, view.locked_to):
        return ""
    return f"; restore_checkpoint({earlier}) goes back further"
