"""The rows of runs and owners: whose a run is, lists of runs, and what an owner has used; queries of one transaction."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any, NamedTuple

from sqlalchemy import Connection, Row, Select, bindparam, func, insert, select, tuple_, update

from folding_server.store.prepared import PreparedStatement
from folding_server.store.schema import EVENTS, RUNS, VISION
from folding_server.store.views import RunView


@dataclass(frozen=True, slots=True)
class RunSummary:
    """One line of the list of runs.

    ``sequence`` is None and ``frames`` 0 for a free fold; ``events`` counts what happened, ``saved`` the checkpoints.
    ``owner`` is None where the run was opened without a token.
    """

    run_id: str
    sequence: str | None
    opened: datetime
    events: int
    changed: datetime
    frames: int
    saved: int
    owner: str | None

    @property
    def complete(self) -> bool:
        """Whether all frames of a sequence are saved; a free fold is never complete."""
        return self.sequence is not None and self.saved == self.frames


class OwnedRuns(NamedTuple):
    """How many runs an owner has, and how many bytes their events take up."""

    runs: int
    bytes: int


def add_run(connection: Connection, view: RunView, size: int, owner: str | None) -> None:
    """The row of a run whose events take up ``size`` bytes."""
    row = {"run_id": view.run_id, "owner": owner, "sequence": view.sequence, "frames": view.frames}
    row |= {"opened": _sortable(view.opened), "bytes": size, **_progress(view)}
    connection.execute(insert(RUNS), row)


def change_run(connection: Connection, view: RunView, size: int) -> None:
    """The row of a run after one more event, of ``size`` bytes.

    A run without a row was opened by a server of an earlier version beside this one; it gets one.
    """
    changed = _CHANGE.execute(connection, {"which": view.run_id, "more": size, **_progress(view)})
    if not changed.rowcount:
        add_run(connection, view, size, None)


_CHANGE = PreparedStatement(
    update(RUNS)
    .where(RUNS.c.run_id == bindparam("which"))
    .values(
        changed=bindparam("changed"),
        events=bindparam("events"),
        saved=bindparam("saved"),
        bytes=RUNS.c.bytes + bindparam("more"),
    )
)


def _progress(view: RunView) -> dict[str, Any]:
    """What an event changes in the row of its run."""
    return {"changed": _sortable(view.changed), "events": view.seq, "saved": len(view.checkpoints)}


def _sortable(time: datetime) -> str:
    return time.isoformat(timespec="microseconds")


def owner_of(connection: Connection, run_id: str) -> str | None:
    """Whose the run is; None if it is nobody's, or there is none."""
    return connection.execute(select(RUNS.c.owner).where(RUNS.c.run_id == run_id)).scalar()


def runs_page(
    connection: Connection, owner: str | None, limit: int | None, before: str | None
) -> list[RunSummary] | None:
    """At most ``limit`` runs, newest first: of the owner, or of all; those after ``before``; None if there is no such run."""
    query = select(RUNS).order_by(RUNS.c.opened.desc(), RUNS.c.run_id.desc()).limit(limit)
    if owner is not None:
        query = query.where(RUNS.c.owner == owner)
    if before is not None:
        last = connection.execute(select(RUNS).where(RUNS.c.run_id == before)).first()
        if last is None or (owner is not None and last.owner != owner):
            return None
        query = query.where(tuple_(RUNS.c.opened, RUNS.c.run_id) < (last.opened, last.run_id))
    return [_summary(row) for row in connection.execute(query)]


def opened_on(connection: Connection, sequence: str, fingerprint: str) -> bool:
    """Whether a run was opened on the sequence of this name while it had this fingerprint, a digest in hexadecimal."""
    return connection.execute(_opened_on(sequence, fingerprint)).first() is not None


def own_run_on(connection: Connection, owner: str | None, sequence: str, fingerprint: str) -> str | None:
    """The owner's newest run that was opened so, or nobody's where the owner is None; None if there is none."""
    found: str | None = connection.execute(
        _opened_on(sequence, fingerprint).where(RUNS.c.owner == owner)
    ).scalar()
    return found


def _opened_on(sequence: str, fingerprint: str) -> Select[Any]:
    """The newest run on the sequence of this name as it was with this fingerprint."""
    first = (EVENTS.c.run_id == RUNS.c.run_id) & (EVENTS.c.seq == 1)
    query = select(RUNS.c.run_id).join(EVENTS, first).where(RUNS.c.sequence == sequence)
    return query.where(EVENTS.c.payload.contains(fingerprint)).order_by(RUNS.c.opened.desc()).limit(1)


def _summary(row: Row[Any]) -> RunSummary:
    return RunSummary(
        run_id=row.run_id,
        sequence=row.sequence,
        opened=datetime.fromisoformat(row.opened),
        events=row.events,
        changed=datetime.fromisoformat(row.changed),
        frames=row.frames,
        saved=row.saved,
        owner=row.owner,
    )


def lock_owner(connection: Connection, owner: str) -> None:
    """Make others who open a run for the owner wait until this transaction ends. SQLite's have waited already."""
    if connection.dialect.name == "postgresql":
        connection.execute(select(func.pg_advisory_xact_lock(_OWNER_LOCK, func.hashtext(owner))))


_OWNER_LOCK = 0x464F4C44
"""The space of the advisory locks of owners ("FOLD" in ASCII); it has nothing to do with locks of one number."""


def stored_by(connection: Connection, owner: str) -> OwnedRuns:
    """What the owner has, counted."""
    query = select(func.count(), func.coalesce(func.sum(RUNS.c.bytes), 0)).where(RUNS.c.owner == owner)
    runs, size = connection.execute(query).one()
    return OwnedRuns(runs, int(size))


def vision_seconds(connection: Connection, owner: str, day: str) -> float:
    """How long the vision tools have computed for the owner on a day."""
    query = select(VISION.c.seconds).where(VISION.c.owner == owner, VISION.c.day == day)
    return connection.execute(query).scalar() or 0.0


def add_vision_seconds(connection: Connection, owner: str, day: str, seconds: float) -> None:
    """Count computing time of the vision tools. IntegrityError if another counts the day's first at the same moment."""
    of_day = (VISION.c.owner == owner) & (VISION.c.day == day)
    more = update(VISION).where(of_day).values(seconds=VISION.c.seconds + seconds)
    if not connection.execute(more).rowcount:
        connection.execute(insert(VISION), {"owner": owner, "day": day, "seconds": seconds})
