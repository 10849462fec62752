"""``RunStore``: create, load and change runs. A change is one event, decided on and added in one transaction."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import reduce
from math import isfinite
from pathlib import Path
from threading import Lock
from typing import Self

from cachetools import LRUCache

from folding_server.errors import RunError
from folding_server.store import owners
from folding_server.store.change import Change, other_call, require_same_call
from folding_server.store.database import EventTable, Requested, Taken, Transaction, database_url
from folding_server.store.limits import BUDGET, NO_LIMITS, OwnerLimits
from folding_server.store.non_blocking import WouldBlock, may_block
from folding_server.store.owners import RunSummary
from folding_server.store.run_events import RULES, Opened, RunEvent
from folding_server.store.run_ids import is_run_id, new_run_id
from folding_server.store.views import RecordDamaged, RunView, fold_events, opened_view, step

_CACHED_RUNS = 256
_CACHED_OWNERS = 10_000
_SHOWN_ID_LENGTH = 60


class RunStore:
    """The runs of one database, shared by any number of threads and processes.

    ::

        with store.change(run_id) as change:
            after = change.act(action)
            paper = apply(paper_of(change.view), action)    # a refusal takes the action back

    All methods raise RunError, with nothing changed, for an unknown run, for what the rules do not allow and
    for a database that cannot be used. Views of recent runs are kept; a call reads only the events that came
    after.

    A run may have an owner, for good. Whoever has found out who is calling asks ``require_owner`` first; the other
    methods leave runs to anyone. ``limits`` hold for each owner.
    """

    def __init__(self, url: str, limits: OwnerLimits = NO_LIMITS) -> None:
        """Open the database at an SQLAlchemy URL; makes its tables, or brings them up to date."""
        self._limits = limits
        self._log = EventTable(url)
        self._owners: LRUCache[str, str | None] = LRUCache(_CACHED_OWNERS)
        self._views: LRUCache[str, RunView] = LRUCache(_CACHED_RUNS)
        self._views_lock = Lock()

    @classmethod
    def in_folder(cls, folder: Path, limits: OwnerLimits = NO_LIMITS) -> Self:
        """The store of a data folder: SQLite in one file; makes the folder if it is missing."""
        return cls(database_url(folder), limits)

    def forget(self) -> None:
        """Drop the kept views; the next call on a run reads all its events again, with the same answer."""
        with self._views_lock:
            self._views.clear()

    async def on_disk(self) -> None:
        """Wait, in an event loop, until what calls that may not wait were told here is on the disk: now it may be answered."""
        await self._log.on_disk()

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
        request_id: str | None = None,
        owner: str | None = None,
    ) -> RunView:
        """Start a run under a new id: of a sequence with its number of frames, or a free fold without either.

        ``fingerprint`` is any text that changes when the sequence does; ``rules.check_same_sequence``
        compares it on resuming. A free fold has no budget. If the request has started a run before, the
        answer is that run as it then was.
        """
        _check_opening(sequence, frames, sheet, budget)
        opened = Opened(
            seq=1,
            time=datetime.now(UTC),
            request_id=request_id,
            sequence=sequence,
            frames=frames,
            sheet=sheet,
            front_color=front_color,
            back_color=back_color,
            fingerprint=fingerprint if sequence is not None else None,
            budget=budget if sequence is not None else None,
            rules=RULES,
        )
        return self._keep(self._opened(opened, owner))

    @contextmanager
    def change(self, run_id: str, request_id: str | None = None) -> Iterator[Change]:
        """A transaction in which one change of the run is decided on and recorded; see ``Change``.

        Nobody else changes the run within the context, and on SQLite nobody writes at all, so what is done
        in it should be short. An exception leaves everything as it was. A ``request_id`` that an event was
        recorded for before is not carried out again. The store may not be asked for anything else within
        the context.
        """
        _check_run_id(run_id)
        try:
            with self._log.writing() as transaction:
                transaction.lock(run_id)
                change = self._begun(transaction, run_id, request_id)
                yield change
        except Taken as error:
            raise RunError(
                f"run {run_id} was changed by another call at the same moment; try again"
            ) from error
        if change.after is not None:
            self._keep(change.after)

    def last_seen(self, run_id: str) -> RunView:
        """The run as this store saw it last, which may be behind; as it stands where it never did."""
        with self._views_lock:
            kept = self._views.get(run_id)
        return kept or self.load(run_id)

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

    def list_runs(
        self, owner: str | None = None, limit: int | None = None, before: str | None = None
    ) -> list[RunSummary]:
        """The runs of an owner, or of everybody, newest first: at most ``limit``, those that come after run ``before``."""
        if before is not None:
            _check_run_id(before)
        with self._log.reading() as transaction:
            found = owners.runs_page(transaction.connection, owner, limit, before)
        if found is None:
            raise _unknown(str(before))
        return found

    def has_runs(self, sequence: str, fingerprint: str) -> bool:
        """Whether runs, whosesoever, were opened on the sequence of this name as it was with this fingerprint."""
        with self._log.reading() as transaction:
            return owners.opened_on(transaction.connection, sequence, fingerprint)

    def own_run_on(self, owner: str | None, sequence: str, fingerprint: str) -> str | None:
        """The owner's newest run that was opened on such a sequence, or nobody's if the owner is None; None if there is none."""
        with self._log.reading() as transaction:
            return owners.own_run_on(transaction.connection, owner, sequence, fingerprint)

    def owner_of(self, run_id: str) -> str | None:
        """Whose the run is; None if it is nobody's, or there is none."""
        return self._owner(run_id) if is_run_id(run_id) else None

    def require_owner(self, run_id: str, owner: str | None) -> None:
        """Raise RunError, as for a run that there is not, if the run belongs to another than this owner.

        None is nobody's own: whoever reaches the server without a token may use all runs, as may the database's reader.
        """
        if owner is not None and not (is_run_id(run_id) and self._owner(run_id) == owner):
            raise _unknown(run_id)

    def check_vision(self, owner: str) -> None:
        """Raise RunError if the vision tools have computed for the owner for as long today as they may."""
        if self._limits.vision_seconds is not None:
            with self._log.reading() as transaction:
                seconds = owners.vision_seconds(transaction.connection, owner, _today())
            self._limits.check_vision(owner, seconds)

    def add_vision(self, owner: str, seconds: float) -> None:
        """Count time that the vision tools have computed for the owner, on the day that ends it (UTC)."""
        try:
            self._add_vision(owner, seconds)
        except Taken:  # another has counted the first of the day at the same moment
            self._add_vision(owner, seconds)

    def history(self, run_id: str) -> list[RunEvent]:
        """All events of the run, oldest first."""
        _check_run_id(run_id)
        with self._log.reading() as transaction:
            events = transaction.events(run_id)
        if not events:
            raise _unknown(run_id)
        return events

    def _add_vision(self, owner: str, seconds: float) -> None:
        with self._log.writing() as transaction:
            owners.add_vision_seconds(transaction.connection, owner, _today(), seconds)

    def _owner(self, run_id: str) -> str | None:
        """Whose the run is; None if it is nobody's, or there is none."""
        with self._views_lock:
            if run_id in self._owners:
                return self._owners[run_id]
        with self._log.reading() as transaction:
            owner = owners.owner_of(transaction.connection, run_id)
        if owner is not None:
            with self._views_lock:
                self._owners[run_id] = owner
        return owner

    def _opened(self, opened: Opened, owner: str | None) -> RunView:
        """The run that the event opens under a new id, or has opened before if it was requested before."""
        while True:
            run_id = new_run_id(opened.time)
            try:
                with self._log.writing() as transaction:
                    if (earlier := _requested(transaction, opened.request_id)) is not None:
                        return _opened_before(transaction, earlier, opened, owner)
                    self._check_room(transaction, owner)
                    transaction.append(opened_view(run_id, opened), opened, owner)
            except Taken:
                continue
            return opened_view(run_id, opened)

    def _check_room(self, transaction: Transaction, owner: str | None) -> None:
        """Raise RunError if the owner may open no other run."""
        if owner is None or (self._limits.runs is None and self._limits.bytes is None):
            return
        owners.lock_owner(transaction.connection, owner)
        usage = owners.stored_by(transaction.connection, owner)
        self._limits.check_runs(owner, usage.runs)
        self._limits.check_bytes(owner, usage.bytes)

    def _check_bytes(self, transaction: Transaction, run_id: str) -> None:
        """Raise RunError if the run's owner may record nothing more."""
        if self._limits.bytes is None:
            return
        owner = owners.owner_of(transaction.connection, run_id)
        if owner is not None:
            self._limits.check_bytes(owner, owners.stored_by(transaction.connection, owner).bytes)

    def _begun(self, transaction: Transaction, run_id: str, request_id: str | None) -> Change:
        """A change of the run as it stands, or, if it was requested before, as it stood then."""
        earlier = _requested(transaction, request_id)
        if earlier is None:
            self._check_bytes(transaction, run_id)
            return Change(transaction, self._read(transaction, run_id), request_id, None)
        if earlier.run_id != run_id or isinstance(earlier.event, Opened):
            raise other_call(request_id)
        before = transaction.events(run_id)[: earlier.event.seq - 1]
        return Change(transaction, _folded(run_id, before), request_id, earlier.event)

    def _read(self, transaction: Transaction, run_id: str) -> RunView:
        """The view as of this transaction, from the kept view and the events after it.

        The kept view's last event is read again: if it is gone, so is what the view was made of.
        """
        with self._views_lock:
            kept = self._views.get(run_id)
        if kept is None and not may_block():
            raise WouldBlock
        after = transaction.events_after(run_id, kept.seq, kept.changed) if kept else None
        return _folded(
            run_id,
            transaction.events(run_id) if after is None else after,
            kept if after is not None else None,
        )

    def _keep(self, view: RunView) -> RunView:
        """Keep the view unless a newer one is kept already; the run used longest ago is forgotten."""
        with self._views_lock:
            kept = self._views.get(view.run_id)
            if kept is None or kept.seq <= view.seq:
                self._views[view.run_id] = view
        return view


def _requested(transaction: Transaction, request_id: str | None) -> Requested | None:
    """What was recorded for a request, if it has a name."""
    return None if request_id is None else transaction.requested(request_id)


def _opened_before(
    transaction: Transaction, earlier: Requested, opened: Opened, owner: str | None
) -> RunView:
    """The run that an earlier request of the same owner opened, as it then was. RunError if it was another call."""
    if owners.owner_of(transaction.connection, earlier.run_id) != owner:
        raise other_call(opened.request_id)
    require_same_call(earlier.event, opened)
    return _folded(earlier.run_id, [earlier.event])


def _today() -> str:
    return f"{datetime.now(UTC):%Y-%m-%d}"


def _folded(run_id: str, events: Sequence[RunEvent], kept: RunView | None = None) -> RunView:
    """The view of a run from its events, or from an earlier view and those after it."""
    try:
        view = reduce(step, events, kept) if kept else fold_events(run_id, events)
    except RecordDamaged as error:
        raise RunError(
            f"the record of run {run_id} is damaged: {error}; open another run with open_run"
        ) from error
    if view is None:
        raise _unknown(run_id)
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
