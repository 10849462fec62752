"""``RunStore``: create, load and change runs. A change is one event, checked and added in one transaction."""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import reduce
from math import isfinite
from pathlib import Path
from threading import Lock
from typing import Self

from folding_schemas.actions import Action

from folding_server.errors import RunError
from folding_server.store import rules
from folding_server.store.database import EventLog, SeqTaken, Transaction, database_url
from folding_server.store.run_events import Acted, Committed, Event, Opened, Restored, Saved, Undone
from folding_server.store.run_ids import is_run_id, new_run_id
from folding_server.store.views import RecordDamaged, RunView, fold_events, opened_view, step

BUDGET = 5
"""How many attempts a frame of a sequence is allowed (paper, section "Bounded exploration")."""

_CACHED_RUNS = 256
_TRIES = 50
_SHOWN_ID_LENGTH = 60

MakeEvent = Callable[[int, datetime], Event]


@dataclass(frozen=True, slots=True)
class RunSummary:
    """One line of the list of runs; ``sequence`` is None for a free fold, ``events`` counts what happened."""

    run_id: str
    sequence: str | None
    opened: datetime
    events: int


class RunStore:
    """The runs of one database, shared by any number of threads and processes.

    All changing methods return the run's new view. ``after`` is the ``seq`` of the view that the caller
    decided on: if the run has moved on since, the change is refused, so an action is never added to a state
    it was not computed for. All methods raise RunError, with nothing changed, for an unknown run, for what
    the rules do not allow and for a database that cannot be used.

    Views of recent runs are kept; a call reads only the events that came after. Views are immutable and the
    database decides every race, so nothing is locked while the database works.
    """

    def __init__(self, url: str) -> None:
        """Open the database at an SQLAlchemy URL; makes the table if it is missing."""
        self._log = EventLog(url)
        self._views: OrderedDict[str, RunView] = OrderedDict()
        self._views_lock = Lock()

    @classmethod
    def in_folder(cls, folder: Path) -> Self:
        """The store of a data folder: SQLite in one file; makes the folder if it is missing."""
        return cls(database_url(folder))

    def forget(self) -> None:
        """Drop the kept views; the next call on a run reads all its events again, with the same answer."""
        with self._views_lock:
            self._views.clear()

    def close(self) -> None:
        """Give back all connections. The store may not be used afterwards."""
        self._log.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def create(
        self,
        *,
        sequence: str | None = None,
        frames: int = 0,
        fingerprint: str | None = None,
        front_color: str = "white",
        back_color: str = "white",
        sheet: tuple[float, float] = (1.0, 1.0),
        budget: int = BUDGET,
    ) -> RunView:
        """Start a run under a new id: of a sequence with its number of frames, or a free fold without either.

        ``fingerprint`` is any text that changes when the sequence does; ``rules.check_same_sequence``
        compares it on resuming. A free fold has no budget.
        """
        _check_opening(sequence, frames, sheet, budget)
        now = datetime.now(UTC)
        opened = Opened(
            seq=1,
            time=now,
            sequence=sequence,
            frames=frames,
            sheet=sheet,
            front_color=front_color,
            back_color=back_color,
            fingerprint=fingerprint if sequence is not None else None,
            budget=budget if sequence is not None else None,
        )
        return self._keep(opened_view(self._append_opened(opened), opened))

    def load(self, run_id: str) -> RunView:
        """The run as it stands."""
        _check_run_id(run_id)
        with self._log.reading() as transaction:
            view = self._read(transaction, run_id)
        return self._keep(view)

    def exists(self, run_id: str) -> bool:
        """Whether the database holds a run with this id."""
        if not is_run_id(run_id):
            return False
        with self._log.reading() as transaction:
            return transaction.holds(run_id)

    def list_runs(self) -> list[RunSummary]:
        """All runs, oldest first."""
        with self._log.reading() as transaction:
            openings = transaction.openings()
        return [
            RunSummary(run_id, first.sequence, first.time, count)
            for run_id, first, count in openings
            if isinstance(first, Opened)
        ]

    def history(self, run_id: str) -> list[Event]:
        """All events of the run, oldest first."""
        _check_run_id(run_id)
        with self._log.reading() as transaction:
            events = transaction.events(run_id)
        if not events:
            raise _unknown(run_id)
        return events

    def act(self, run_id: str, action: Action, *, after: int | None = None) -> RunView:
        """Add an action, which the caller has found possible on the state of ``after``."""
        return self._append(run_id, lambda seq, time: Acted(seq=seq, time=time, action=action), after)

    def undo(self, run_id: str, *, after: int | None = None) -> RunView:
        """Take back the newest action since the base checkpoint. The attempt it began still counts."""
        return self._append(run_id, lambda seq, time: Undone(seq=seq, time=time), after)

    def save(self, run_id: str, frame: int, notes: str | None = None, *, after: int | None = None) -> RunView:
        """Save the current state as the checkpoint of the frame after the base, and stand on it."""
        rules.check_notes(notes)
        return self._append(
            run_id, lambda seq, time: Saved(seq=seq, time=time, frame=frame, notes=notes), after
        )

    def restore(self, run_id: str, frame: int, *, after: int | None = None) -> RunView:
        """Go back (or forth) to a frame's checkpoint; pending actions are given up, checkpoints stay."""
        return self._append(run_id, lambda seq, time: Restored(seq=seq, time=time, frame=frame), after)

    def commit(self, run_id: str, frame: int, attempt: int, *, after: int | None = None) -> RunView:
        """Choose an attempt for good: save it and the chain it grew from, lock these frames, stand on it."""
        return self._append(
            run_id, lambda seq, time: Committed(seq=seq, time=time, frame=frame, attempt=attempt), after
        )

    def _append_opened(self, opened: Opened) -> str:
        """The new id under which the run was opened; another one is drawn should an id be taken."""
        while True:
            run_id = new_run_id(opened.time)
            try:
                with self._log.writing() as transaction:
                    transaction.append(run_id, opened)
            except SeqTaken:
                continue
            return run_id

    def _append(self, run_id: str, make: MakeEvent, after: int | None) -> RunView:
        _check_run_id(run_id)
        for _ in range(_TRIES):
            try:
                return self._keep(self._append_once(run_id, make, after))
            except SeqTaken:
                continue
        raise RunError(f"run {run_id} is being changed by too many callers at once; try again in a moment")

    def _append_once(self, run_id: str, make: MakeEvent, after: int | None) -> RunView:
        with self._log.writing() as transaction:
            view = self._read(transaction, run_id)
            if after is not None and view.seq != after:
                raise RunError(
                    f"run {run_id} was changed by another call meanwhile; call get_current_state first"
                )
            event = make(view.seq + 1, datetime.now(UTC))
            rules.check(view, event)
            transaction.append(run_id, event)
        return step(view, event)

    def _read(self, transaction: Transaction, run_id: str) -> RunView:
        """The view as of this transaction, from the kept view and the events after it.

        The kept view's last event is read again: if it is gone, so is what the view was made of.
        """
        kept = self._views.get(run_id)
        events = transaction.events(run_id, kept.seq if kept else 1)
        try:
            if kept and events and events[0].time == kept.changed:
                return reduce(step, events[1:], kept)
            view = fold_events(run_id, transaction.events(run_id) if kept else events)
        except RecordDamaged as error:
            raise RunError(
                f"the record of run {run_id} is damaged: {error}; open another run with open_run"
            ) from error
        if view is None:
            raise _unknown(run_id)
        return view

    def _keep(self, view: RunView) -> RunView:
        """Keep the view unless a newer one is kept already; forget the run used longest ago."""
        with self._views_lock:
            kept = self._views.get(view.run_id)
            if kept is None or kept.seq <= view.seq:
                self._views[view.run_id] = view
            self._views.move_to_end(view.run_id)
            if len(self._views) > _CACHED_RUNS:
                self._views.popitem(last=False)
        return view


def _check_run_id(run_id: str) -> None:
    if not is_run_id(run_id):
        raise _unknown(run_id)


def _unknown(run_id: str) -> RunError:
    shown = run_id if len(run_id) <= _SHOWN_ID_LENGTH else f"{run_id[:_SHOWN_ID_LENGTH]}..."
    return RunError(
        f"there is no run {shown!r} in this data folder; call open_run without run_id to start one"
    )


def _check_opening(sequence: str | None, frames: int, sheet: tuple[float, float], budget: int) -> None:
    if sequence is None and frames:
        raise RunError(f"a free fold has no frames, but {frames} were given; name a sequence or give none")
    if sequence is not None and frames < 1:
        raise RunError(f"sequence {sequence!r} has {frames} frames; a run needs at least 1")
    if not all(isfinite(side) and side > 0 for side in sheet):
        raise RunError(
            f"a sheet of {sheet[0]} by {sheet[1]} cannot be; both sides must be finite and above 0"
        )
    if budget < 1:
        raise RunError(f"a budget of {budget} attempts allows none; give at least 1")
