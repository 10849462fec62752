"""What a run's events amount to: ``RunView``, a pure function of the list of its events.

The saved checkpoints of a run are always one chain: frames 1..m without a gap, each grown from the one
before. The current state grew from one of them, the base, by the pending actions.

* Restoring only moves the base. Later checkpoints stay, so looking back costs nothing, and restoring a later
  one again is possible.
* Saving frame t puts a new checkpoint on the base t-1. Checkpoints after t stay only if the new one is
  reached by the same actions as the old one; otherwise they grew from a state that is gone, and go with it.
  So a run can never be complete in a mixture of two solutions.
* An attempt at frame t begins with the first action from checkpoint t-1 and ends at the next restore, save or
  commit. It is counted from its first action, also if that is undone later. Saving frame t without any action
  ("nothing changed") is an attempt with no actions. Frame 1 is the flat sheet and has no attempts.
* An attempt remembers the chain it grew from. Committing it makes that chain, with the attempt's state on
  top, the saved checkpoints, and locks them: ``locked_to`` is the attempt's frame from then on.
* An attempt at a later frame that grew from another chain than the locked one can no longer be chosen. It
  stays in the list but no longer counts against the budget: else a frame could be left with no attempt to
  make and none to choose. The lock only ever rises, so exploration stays bounded.
* A free fold begins with the flat sheet saved as frame 1; its further checkpoints are bookmarks without
  number limit, and it has no attempts.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import reduce
from types import MappingProxyType

from folding_schemas.actions import Actions, Program
from folding_schemas.results import AttemptOutcome

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


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A saved frame: ``actions`` lead to it from the frame before, ``path`` from the flat sheet."""

    frame: int
    actions: Actions
    path: Actions
    notes: str | None = None


@dataclass(frozen=True, slots=True)
class Attempt:
    """One explored transition to ``frame``: its ancestors, checkpoints 1..frame-1, and its actions."""

    frame: int
    number: int
    ancestors: tuple[Checkpoint, ...]
    actions: Actions = ()
    outcome: AttemptOutcome = "open"
    notes: str | None = None

    @property
    def label(self) -> str:
        """The name under which a selector sees the attempt: B1, B2, ..."""
        return f"B{self.number}"

    @property
    def base_path(self) -> Actions:
        """All actions from the flat sheet to the checkpoint that the attempt grew from."""
        return self.ancestors[-1].path

    @property
    def path(self) -> Actions:
        """All actions from the flat sheet to the attempt's state."""
        return self.base_path + self.actions

    def checkpoint(self) -> Checkpoint:
        """The attempt's state as a checkpoint of its frame."""
        return Checkpoint(self.frame, self.actions, self.path, self.notes)


@dataclass(frozen=True, slots=True)
class RunView:
    """Where a run stands after its event ``seq``. Immutable: every change makes a new view.

    ``base`` is the frame whose checkpoint the current state grew from, 0 before frame 1 is saved; ``pending``
    are the actions since. ``attempts`` holds the attempts at each frame, oldest first, ``restores`` how often
    each checkpoint was restored (never reset). Frames up to ``locked_to`` are committed. ``frames`` is 0, and
    ``sequence``, ``fingerprint`` and ``budget`` are None, for a free fold.
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

    def used(self, frame: int) -> int:
        """How many attempts at the frame count against the budget."""
        made = self.attempts.get(frame, ())
        return sum(frame <= self.locked_to or self.committable(attempt) for attempt in made)

    def chain(self, frame: int) -> tuple[Checkpoint, ...]:
        """The checkpoints of frames 1..frame; KeyError if one is not saved."""
        return tuple(self.checkpoints[each] for each in range(1, frame + 1))

    def program(self) -> Program:
        """The saved checkpoints as a program: step k leads from frame k to k + 1; no pending actions."""
        return self._program(self.chain(len(self.checkpoints)))

    def current_program(self) -> Program:
        """The current state as a program: the steps to the base, then the pending actions if any."""
        return self._program(self.chain(self.base), self.pending)

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
            return _with_pending(view, (*view.pending, action))
        case Undone():
            return _with_pending(view, view.pending[:-1])
        case Saved(frame=frame, notes=notes):
            return _saved(view, frame, notes)
        case Restored(frame=frame):
            return _restored(view, frame)
        case Committed(frame=frame, attempt=number):
            return _committed(view, frame, number)
        case Opened():
            raise LookupError(event.kind)


def _with_pending(view: RunView, pending: Actions) -> RunView:
    """The view with other pending actions; begins an attempt if none is open."""
    if view.free:
        return replace(view, pending=pending)
    attempt = view.open_attempt or _new_attempt(view)
    return replace(_with_attempt(view, replace(attempt, actions=pending)), pending=pending)


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
        view = _with_attempt(view, replace(attempt, outcome="saved", notes=notes))
    return _with_chain(view, chain)


def _restored(view: RunView, frame: int) -> RunView:
    view = _with_attempt_given_up(view)
    restores = {**view.restores, frame: view.restores.get(frame, 0) + 1}
    base = view.checkpoints[frame].frame
    return replace(view, base=base, pending=(), restores=MappingProxyType(restores))


def _with_attempt_given_up(view: RunView) -> RunView:
    attempt = view.open_attempt
    return _with_attempt(view, replace(attempt, outcome="restored")) if attempt else view


def _committed(view: RunView, frame: int, number: int) -> RunView:
    view = _with_attempt_given_up(view)
    chosen = view.attempts[frame][number - 1]
    view = _with_attempt(view, replace(chosen, outcome="committed"))
    return replace(_with_chain(view, (*chosen.ancestors, chosen.checkpoint())), locked_to=frame)
