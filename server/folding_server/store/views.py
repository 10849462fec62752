"""What a run's events amount to: ``RunView``, a pure function of the list of its events.

The saved checkpoints of a run are always one chain: frames 1..m without a gap, each grown from the one
before. The current state grew from one of them, the base, by the pending actions.

* Restoring only moves the base. Later checkpoints stay, so looking back costs nothing, and restoring a later
  one again is possible.
* Saving frame t puts a new checkpoint on the base t-1. Checkpoints after t stay only if the new one is
  reached by the same actions as the old one; otherwise they grew from a state that is gone, and go with it.
  So a run can never be complete in a mixture of two solutions.
* An attempt at frame t begins with the first action from checkpoint t-1 and ends at the next restore, save or
  commit, or when an undo comes back to the checkpoint. Saving frame t without any action ("nothing changed") is an
  attempt with no actions. Frame 1 is the flat sheet and has no attempts. In runs opened by rules 1, which numbered
  their attempts so, an undo ends none.
* An attempt counts against the budget of the state that it grew from, unless a technical return ended it.
* An attempt remembers the chain it grew from, and every state that it came to. Committing it makes that chain, with
  one of its states on top, the saved checkpoints, and locks them: ``locked_to`` is the attempt's frame from then on.
* An attempt at a later frame that grew from another chain than the locked one can no longer be chosen. It
  stays in the list.
* A free fold begins with the flat sheet saved as frame 1; its further checkpoints are bookmarks without
  number limit, and it has no attempts.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import reduce
from types import MappingProxyType

from folding_schemas.actions import Actions, Program

from folding_server.store.exploration import Attempt, Checkpoint
from folding_server.store.run_events import (
    IN_COLUMNS,
    Acted,
    Committed,
    Opened,
    Restored,
    RunEvent,
    Saved,
    Undone,
)

BUDGETS_PER_FRAME = 3
"""From how many states of the frame before a frame may be tried: twice, a mistake in an earlier frame can be mended."""


@dataclass(frozen=True, slots=True)
class RunView:
    """Where a run stands after its event ``seq``. Immutable: every change makes a new view.

    ``base`` is the frame whose checkpoint the current state grew from, 0 before frame 1 is saved; ``pending``
    are the actions since. ``attempts`` holds the attempts at each frame, oldest first, ``restores`` how often
    each checkpoint was restored (never reset). Frames up to ``locked_to`` are committed. ``frames`` is 0, and
    ``sequence``, ``fingerprint`` and ``budget`` are None, for a free fold. ``rules`` says how attempts are counted.
    """

    run_id: str
    seq: int
    opened: datetime
    changed: datetime
    sequence: str | None
    frames: int
    sheet: tuple[float, float]
    front_color: str
    back_color: str
    fingerprint: str | None
    budget: int | None
    rules: int = 1
    base: int = 0
    pending: Actions = ()
    checkpoints: Mapping[int, Checkpoint] = field(default_factory=lambda: MappingProxyType({}))
    attempts: Mapping[int, tuple[Attempt, ...]] = field(default_factory=lambda: MappingProxyType({}))
    restores: Mapping[int, int] = field(default_factory=lambda: MappingProxyType({}))
    locked_to: int = 0

    @property
    def free(self) -> bool:
        """Whether this is a free fold: no photos, no attempts, no budget."""
        return self.sequence is None

    @property
    def actions(self) -> Actions:
        """All actions from the flat sheet to the current state."""
        return self.base_path + self.pending

    @property
    def base_path(self) -> Actions:
        """All actions from the flat sheet to the base checkpoint."""
        return self.checkpoints[self.base].path if self.base else ()

    @property
    def next_frame(self) -> int | None:
        """The frame that the current state is on its way to; None from the last frame's checkpoint."""
        return self.base + 1 if self.free or self.base < self.frames else None

    @property
    def complete(self) -> bool:
        """Whether exactly the frames 1..N are saved; a free fold is never complete."""
        return not self.free and len(self.checkpoints) == self.frames

    @property
    def open_attempt(self) -> Attempt | None:
        """The attempt that the pending actions belong to, if one has begun."""
        made = self.attempts.get(self.base + 1, ())
        return made[-1] if made and made[-1].outcome == "open" else None

    @property
    def next_attempt(self) -> int | None:
        """The number of the next action's attempt; None where there are none: free folds, the last frame."""
        if self.free or self.base in (0, self.frames):
            return None
        made = self.attempts.get(self.base + 1, ())
        return len(made) if self.open_attempt else len(made) + 1

    def committable(self, attempt: Attempt) -> bool:
        """Whether the attempt's frame is open and it grew from the locked checkpoints."""
        return attempt.frame > self.locked_to and all(
            mine.path == self.checkpoints[mine.frame].path for mine in attempt.ancestors[: self.locked_to]
        )

    def on_path(self, attempt: Attempt) -> bool:
        """Whether the attempt grew from the state that is saved for the frame before."""
        before = self.checkpoints.get(attempt.frame - 1)
        return before is not None and attempt.base_path == before.path

    def used(self, frame: int) -> int:
        """How many attempts at the frame count against the budget of the state that is saved for the frame before."""
        return sum(each.counted and self.on_path(each) for each in self.attempts.get(frame, ()))

    @property
    def attempts_left(self) -> int | None:
        """How many attempts can be made from the base, the open one included; None where there are none, or no limit."""
        if self.budget is None or self.next_attempt is None:
            return None
        if self.open_attempt:
            return max(self.budget - self.used(self.base + 1), 0) + 1
        return self.budget - self.used(self.base + 1) if self._may_try_from_here() else 0

    def rewritten_by(self, attempt: Attempt) -> list[int]:
        """The saved frames before the attempt's that would become others if it was committed."""
        return [each.frame for each in attempt.ancestors if self._is_other(each)]

    def dropped_by(self, attempt: Attempt) -> list[int]:
        """The saved frames after the attempt's that would go if it was committed, since they grew from others."""
        same = not any(map(self._is_other, attempt.chain()))
        return [] if same else [frame for frame in sorted(self.checkpoints) if frame > attempt.frame]

    def chain(self, frame: int) -> tuple[Checkpoint, ...]:
        """The checkpoints of frames 1..frame; KeyError if one is not saved."""
        return tuple(self.checkpoints[each] for each in range(1, frame + 1))

    def program(self) -> Program:
        """The saved checkpoints as a program: step k leads from frame k to k + 1; no pending actions."""
        return self._program(self.chain(len(self.checkpoints)))

    def current_program(self) -> Program:
        """The current state as a program: the steps to the base, then the pending actions if any."""
        return self._program(self.chain(self.base), self.pending)

    def _is_other(self, checkpoint: Checkpoint) -> bool:
        """Whether another state than this is saved for its frame."""
        saved = self.checkpoints.get(checkpoint.frame)
        return saved is not None and saved.path != checkpoint.path

    def _may_try_from_here(self) -> bool:
        """Whether the frame after the base has been tried from it less often than it may be, and from few enough others."""
        made = [each for each in self.attempts.get(self.base + 1, ()) if each.counted]
        tried_from = {each.base_path for each in made}
        if self.base_path in tried_from:
            return self.used(self.base + 1) < (self.budget or 0)
        return len(tried_from) < BUDGETS_PER_FRAME or not any(map(self.committable, made))

    def _program(self, chain: tuple[Checkpoint, ...], last: Actions = ()) -> Program:
        steps = tuple(checkpoint.actions for checkpoint in chain[1:])
        return Program(
            name=self.sequence or "untitled",
            front_color=self.front_color,
            back_color=self.back_color,
            sheet=self.sheet,
            steps=(*steps, last) if last else steps,
        )


class RecordDamaged(ValueError):
    """The events of a run do not follow from one another; the message says where."""


def fold_events(run_id: str, events: Iterable[RunEvent]) -> RunView | None:
    """The view of a run from all its events in order; None if there are none. Raises RecordDamaged."""
    remaining = iter(events)
    first = next(remaining, None)
    if first is None:
        return None
    if not isinstance(first, Opened) or first.seq != 1:
        raise RecordDamaged(f"event {first.seq} comes first")
    return reduce(step, remaining, opened_view(run_id, first))


def opened_view(run_id: str, event: Opened) -> RunView:
    """The view of a run that has only been opened. A free fold has its flat sheet saved as frame 1."""
    view = RunView(
        run_id=run_id,
        seq=event.seq,
        opened=event.time,
        changed=event.time,
        **event.model_dump(exclude=set(IN_COLUMNS)),
    )
    return _with_chain(view, (Checkpoint(1, (), ()),)) if view.free else view


def step(view: RunView, event: RunEvent) -> RunView:
    """The view after one more event, which the rules allowed. Raises RecordDamaged if it cannot follow."""
    if event.seq != view.seq + 1:
        raise RecordDamaged(f"event {event.seq} follows event {view.seq}")
    try:
        after = _happen(view, event)
    except LookupError as error:
        raise RecordDamaged(f"event {event.seq} ({event.kind}) speaks of what is not there") from error
    return replace(after, seq=event.seq, changed=event.time)


def _happen(view: RunView, event: RunEvent) -> RunView:
    match event:
        case Acted(action=action):
            return _acted(view, (*view.pending, action))
        case Undone():
            return _undone(view, view.pending[:-1])
        case Saved(frame=frame, notes=notes):
            return _saved(view, frame, notes)
        case Restored(frame=frame, technical=technical):
            return _restored(view, frame, counted=not technical)
        case Committed(frame=frame, attempt=number, state=state):
            return _committed(view, frame, number, state)
        case Opened():
            raise LookupError(event.kind)


def _acted(view: RunView, pending: Actions) -> RunView:
    """The view after an action; begins an attempt if none is open."""
    after = replace(view, pending=pending)
    if view.free:
        return after
    return _with_attempt(after, (view.open_attempt or _new_attempt(view)).acted(pending))


def _undone(view: RunView, pending: Actions) -> RunView:
    """The view without its last action; back at the checkpoint, the attempt has ended."""
    after, attempt = replace(view, pending=pending), view.open_attempt
    if attempt is None:
        return after
    ends = not pending and view.rules > 1
    return _with_attempt(after, attempt.taken_back() if ends else replace(attempt, actions=pending))


def _new_attempt(view: RunView) -> Attempt:
    frame = view.base + 1
    return Attempt(frame, len(view.attempts.get(frame, ())) + 1, view.chain(view.base))


def _with_attempt(view: RunView, attempt: Attempt) -> RunView:
    """The view with the attempt put in place of the one with its frame and number, or after the last."""
    made = view.attempts.get(attempt.frame, ())
    made = (*made[: attempt.number - 1], attempt, *made[attempt.number :])
    return replace(view, attempts=MappingProxyType({**view.attempts, attempt.frame: made}))


def _with_chain(view: RunView, chain: tuple[Checkpoint, ...]) -> RunView:
    """The view standing on this chain of checkpoints; later ones stay only if they grew from the same one."""
    frame = len(chain)
    same = frame in view.checkpoints and [c.path for c in view.chain(frame)] == [c.path for c in chain]
    later = {number: each for number, each in view.checkpoints.items() if number > frame} if same else {}
    checkpoints = {each.frame: each for each in chain} | later
    return replace(view, checkpoints=MappingProxyType(checkpoints), base=frame, pending=())


def _saved(view: RunView, frame: int, notes: str | None) -> RunView:
    saved = Checkpoint(frame, view.pending, view.actions, notes)
    chain = (*view.chain(frame - 1), saved)
    if not view.free and frame > 1:
        attempt = view.open_attempt or _new_attempt(view)
        view = _with_attempt(view, replace(attempt.ended("saved"), notes=notes))
    return _with_chain(view, chain)


def _restored(view: RunView, frame: int, *, counted: bool) -> RunView:
    view = _with_attempt_given_up(view, counted=counted)
    restores = {**view.restores, frame: view.restores.get(frame, 0) + 1}
    base = view.checkpoints[frame].frame
    return replace(view, base=base, pending=(), restores=MappingProxyType(restores))


def _with_attempt_given_up(view: RunView, *, counted: bool = True) -> RunView:
    attempt = view.open_attempt
    return _with_attempt(view, attempt.ended("restored", counted=counted)) if attempt else view


def _committed(view: RunView, frame: int, number: int, state: int | None) -> RunView:
    view = _with_attempt_given_up(view)
    chosen = view.attempts[frame][number - 1]
    chosen = replace(chosen if state is None else chosen.at(state), outcome="committed")
    return replace(_with_chain(_with_attempt(view, chosen), chosen.chain()), locked_to=frame)
