"""Where events are kept: one table of any SQL database, to which rows are only ever added. Beside it, written in the
same transactions, stands a row for each run, with its owner and what a list of runs tells (``owners``).

Writers to a run wait for one another: SQLite has one write lock for the whole file, other databases lock the
run's first row. Should a database know no such lock, the primary key (run_id, seq) still lets only one of two
writers who saw event n add event n+1; the other gets ``Taken``. SQLite writes ahead (WAL), and the log is synced
before anything in it is answered (``log_sync``): what has been answered survives the death of the process and of the
machine. Every failure of the database becomes a RunError of one sentence that names the database, without its password.
"""

import json
import re
import sqlite3
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from datetime import datetime
from pathlib import Path
from threading import Lock
from typing import NamedTuple

from pydantic import ValidationError
from sqlalchemy import (
    URL,
    Connection,
    Engine,
    QueuePool,
    bindparam,
    create_engine,
    event,
    insert,
    make_url,
    select,
)
from sqlalchemy.exc import ArgumentError, DBAPIError, IntegrityError, SQLAlchemyError
from sqlalchemy.pool import ConnectionPoolEntry

from folding_server.errors import RunError
from folding_server.store import owners
from folding_server.store.log_sync import LogSync
from folding_server.store.loop_connection import LoopConnection, without_waiting
from folding_server.store.non_blocking import WouldBlock, has_changed, may_block
from folding_server.store.prepared import PreparedStatement
from folding_server.store.run_events import EVENT, EVENT_FORMAT, IN_COLUMNS, RunEvent
from folding_server.store.schema import EVENTS, bring_up_to_date, up_to_date
from folding_server.store.views import RunView

DATABASE_NAME = "runs.sqlite3"
"""The file that holds the runs of a data folder."""

BUSY_SECONDS = 10.0
"""How long a writer waits for another process's transaction on the same SQLite file."""

_FULL = re.compile(r"disk is full|disk I/O error|No space left|could not extend file")
"""What SQLite and PostgreSQL say when there is no room; SQLite calls a limit on the size of files an I/O error."""


_WRITE_AHEAD = "wal"


class Taken(Exception):
    """Another writer was first: the event's number, or its request id, is in the table already."""


class Requested(NamedTuple):
    """The event that was recorded for a request, and its run."""

    run_id: str
    event: RunEvent


def database_url(folder: Path) -> str:
    """The URL of a data folder's database; makes the folder if need be. Raises RunError if that cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(
            f"the data folder {str(folder)!r} cannot be made ({error.strerror}); choose another with --data"
        ) from error
    return URL.create("sqlite", database=str(folder / DATABASE_NAME)).render_as_string()


_EVENTS_FROM = PreparedStatement(
    select(EVENTS)
    .where(EVENTS.c.run_id == bindparam("run"), EVENTS.c.seq >= bindparam("first"))
    .order_by(EVENTS.c.seq)
)
_ADD_EVENT = PreparedStatement(insert(EVENTS))


class EventRow(NamedTuple):
    """A row of the table of events, in the order of its columns."""

    run_id: str
    seq: int
    format: int
    time: str
    kind: str
    payload: str
    request_id: str | None


class Transaction:
    """Reads and adds events within one transaction of an ``EventTable``, on its ``connection``."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection

    def events(self, run_id: str, first: int = 1) -> list[RunEvent]:
        """The run's events from number ``first`` on, in order. Raises RunError if one cannot be read."""
        return [_event(row) for row in self._rows(run_id, first)]

    def events_after(self, run_id: str, seq: int, time: datetime) -> list[RunEvent] | None:
        """The run's events after number ``seq``; None if that one is not there, or is another than that of ``time``."""
        rows = self._rows(run_id, seq)
        if not rows or rows[0].seq != seq or rows[0].time != time.isoformat():
            return None
        return [_event(row) for row in rows[1:]]

    def _rows(self, run_id: str, first: int) -> list[EventRow]:
        found = _EVENTS_FROM.execute(self.connection, {"run": run_id, "first": first})
        return [EventRow(*row) for row in found.fetchall()]

    def holds(self, run_id: str) -> bool:
        """Whether there is a first event of this run."""
        query = select(EVENTS.c.seq).where(EVENTS.c.run_id == run_id, EVENTS.c.seq == 1)
        return self.connection.execute(query).first() is not None

    def lock(self, run_id: str) -> None:
        """Make other writers to the run wait until this transaction ends. SQLite's have waited already."""
        if self.connection.dialect.name != "sqlite":
            query = select(EVENTS.c.seq).where(EVENTS.c.run_id == run_id, EVENTS.c.seq == 1)
            self.connection.execute(query.with_for_update())

    def requested(self, request_id: str) -> Requested | None:
        """What was recorded for a request; None if nothing was. Raises RunError if it cannot be read."""
        row = self.connection.execute(select(EVENTS).where(EVENTS.c.request_id == request_id)).first()
        return Requested(row.run_id, _event(EventRow(*row))) if row else None

    def append(self, after: RunView, added: RunEvent, owner: str | None = None) -> None:
        """Add the event by which the run became ``after``; an opening also says whose the run is.

        ``EventTable.writing`` raises Taken if its number or request id is taken.
        """
        payload = added.model_dump_json(exclude=set(IN_COLUMNS))
        row = {
            "run_id": after.run_id,
            "seq": added.seq,
            "format": EVENT_FORMAT,
            "time": added.time.isoformat(),
            "kind": added.kind,
            "payload": payload,
            "request_id": added.request_id,
        }
        _ADD_EVENT.execute(self.connection, row)
        size = len(payload.encode())
        if added.seq == 1:
            owners.add_run(self.connection, after, size, owner)
        else:
            owners.change_run(self.connection, after, size)


class EventTable:
    """The table of events in one database. Safe to share between threads; close it when done."""

    def __init__(self, url: str) -> None:
        """Connect and make or migrate the table. Raises RunError if the database cannot be used."""
        self._engine = _engine(url)
        self._driver = self._engine.dialect.loaded_dbapi
        self._turn = Lock() if self._engine.dialect.name == "sqlite" else None
        self._log_sync: LogSync | None = None
        self._in_loop: LoopConnection | None = None
        try:
            self._prepare()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Give back all connections."""
        self._engine.dispose()
        if self._in_loop is not None:
            self._in_loop.close()

    @contextmanager
    def reading(self) -> Iterator[Transaction]:
        """A transaction that only reads. What it read is on the disk when the context ends.

        In a call that may not wait it is so after ``on_disk``. Raises WouldBlock there.
        """
        with self._answered():
            if not may_block():
                with self._without_waiting().begun(writing=False) as connection:
                    yield Transaction(connection)
                return
            with self._engine.connect() as connection, connection.begin():
                yield Transaction(connection)
            self._wait_for_disk()

    @contextmanager
    def writing(self) -> Iterator[Transaction]:
        """A transaction that may append; rolled back on any exception. Raises Taken.

        What it added is on the disk when the context ends. Threads that write to SQLite take turns here: waiting for
        its lock, it may let one of many wait until it gives up. In a call that may not wait, what it added is on the
        disk after ``on_disk``. Raises WouldBlock there.
        """
        with self._answered():
            if not may_block():
                with self._begun_without_waiting() as connection:
                    yield Transaction(connection)
                has_changed()
                return
            with self._turn or nullcontext(), self._adding(), self._begun() as connection:
                yield Transaction(connection)
            self._wait_for_disk()

    async def on_disk(self) -> None:
        """Wait, in an event loop, until what calls that may not wait have read and added is on the disk."""
        if self._log_sync is not None:
            with self._disk_answered():
                await self._log_sync.wait_in_loop()

    @contextmanager
    def _begun_without_waiting(self) -> Iterator[Connection]:
        connection = self._without_waiting()
        assert self._turn, "what is kept for event loops is SQLite's"
        with without_waiting(self._turn), self._adding(), connection.begun(writing=True) as begun:
            yield begun

    def _without_waiting(self) -> LoopConnection:
        """The connection of event loops. WouldBlock for databases that are elsewhere or in memory."""
        if self._in_loop is None:
            raise WouldBlock
        return self._in_loop

    def _adding(self) -> AbstractContextManager[None]:
        return nullcontext() if self._log_sync is None else self._log_sync.adding()

    @contextmanager
    def _begun(self) -> Iterator[Connection]:
        with self._engine.connect() as connection:
            connection.execution_options(writing=True)
            with connection.begin():
                yield connection

    def _wait_for_disk(self) -> None:
        """Wait until what is committed is on the disk. Other databases than SQLite do so themselves."""
        if self._log_sync is not None:
            with self._disk_answered():
                self._log_sync.wait()

    @contextmanager
    def _disk_answered(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise _refused(
                f"the run database {self._engine.url.database}",
                f"could not be synced ({error.strerror}), so a change may be lost if the machine fails now; mend its disk, then "
                "see with get_run where the run stands",
            ) from error

    def _prepare(self) -> None:
        """Bring the tables up to date; where they are, as ever after the first time, without waiting for writers."""
        with self._answered():
            with self._engine.connect() as connection, connection.begin():
                self._log_sync = _log_sync(connection)
                self._in_loop = LoopConnection(self._engine.url) if self._log_sync else None
                if up_to_date(connection):
                    return
            with self._begun() as connection:
                bring_up_to_date(connection)

    @contextmanager
    def _answered(self) -> Iterator[None]:
        try:
            yield
        except (IntegrityError, self._driver.IntegrityError) as error:
            raise Taken from error
        except (SQLAlchemyError, self._driver.Error) as error:
            raise self._sentence(error) from error

    def _sentence(self, error: Exception) -> RunError:
        cause = error.orig if isinstance(error, DBAPIError) else error
        reason = str(cause).strip().split("\n")[0].rstrip(".")
        url = self._engine.url
        own_file = url.get_backend_name() == "sqlite"
        name = f"the run database {url.database if own_file else url.render_as_string()}"
        if "locked" in reason:
            return _refused(name, "is busy with another process; try again in a moment")
        because = (
            f" ({reason})" if own_file else ""
        )  # what other databases say may name the machine that they run on
        if full := _FULL.search(reason):
            room = "so nothing was changed; make room on its disk and try again"
            return _refused(
                name, f"could not be written ({reason}), {room}", f"could not be written ({full[0]}), {room}"
            )
        mending = "mend it or choose another"
        return _refused(
            name,
            f"cannot be used ({reason}); {mending}",
            f"cannot be used{because}; whoever runs it has to mend it",
        )


def _refused(name: str, said: str, said_elsewhere: str | None = None) -> RunError:
    """A refusal that names the database, but not to callers on other machines."""
    return RunError(
        f"{name} {said}", f"the run database {said if said_elsewhere is None else said_elsewhere}"
    )


def _event(row: EventRow) -> RunEvent:
    """The event in a row. Raises RunError if it is from a newer format or unreadable."""
    if row.format > EVENT_FORMAT:
        raise RunError(
            f"run {row.run_id} was recorded in format {row.format}, and this server reads up to {EVENT_FORMAT}; "
            f"use a newer server or open another run"
        )
    try:
        columns = {name: getattr(row, name) for name in IN_COLUMNS}
        return EVENT.validate_python({**columns, **json.loads(row.payload)})
    except (ValidationError, ValueError, TypeError) as error:
        raise RunError(
            f"the record of run {row.run_id} is damaged at event {row.seq}; open another run with open_run"
        ) from error


def _engine(url: str) -> Engine:
    """An engine for the URL; RunError if it is no URL or its driver is not installed."""
    try:
        parsed = make_url(url)
    except ArgumentError as error:
        shown = re.sub(":.*@", ":***@", url)
        raise RunError(
            f"{shown!r} is not a database URL; give one such as sqlite:///runs.sqlite3, or leave it out"
        ) from error
    try:
        if parsed.get_backend_name() == "sqlite":
            return _sqlite_engine(parsed)
        return create_engine(parsed, pool_pre_ping=True)  # the database may have been started again since
    except (ArgumentError, ImportError) as error:
        shown = parsed.render_as_string()
        raise RunError(
            f"the database {shown} cannot be reached ({error}); install its driver or use sqlite:///FILE"
        ) from error


def _sqlite_engine(url: URL) -> Engine:
    in_memory = url.database in (None, "", ":memory:")
    arguments = {"timeout": BUSY_SECONDS}
    if in_memory:
        shared = {**arguments, "check_same_thread": False}
        engine = create_engine(url, connect_args=shared, poolclass=QueuePool, pool_size=1, max_overflow=0)
    else:
        engine = create_engine(url, connect_args=arguments, poolclass=QueuePool)
    event.listen(engine, "connect", _prepare_sqlite)
    event.listen(engine, "begin", _begin_sqlite)
    return engine


def _prepare_sqlite(connection: sqlite3.Connection, _entry: ConnectionPoolEntry) -> None:
    """Leave transactions to ``_begin_sqlite``, and syncs to ``LogSync`` where there is a log to be synced."""
    connection.isolation_level = None
    synchronous = "NORMAL" if _journal(connection) == _WRITE_AHEAD else "FULL"
    connection.execute(f"PRAGMA synchronous = {synchronous}")


def _journal(connection: sqlite3.Connection) -> str:
    """Switch to WAL, and tell which kind of journal there is now: a database in memory has another.

    SQLite does not wait when two processes switch a new file at once, so this does.
    """
    deadline = time.monotonic() + BUSY_SECONDS
    while True:
        try:
            return str(connection.execute(f"PRAGMA journal_mode = {_WRITE_AHEAD}").fetchone()[0])
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > deadline:
                raise
            time.sleep(0.01)


def _log_sync(connection: Connection) -> LogSync | None:
    """What syncs the write-ahead log of an SQLite file; None for a database that has none or syncs by itself."""
    if connection.dialect.name != "sqlite":
        return None
    if connection.exec_driver_sql("PRAGMA journal_mode").scalar() != _WRITE_AHEAD:
        return None
    file = connection.exec_driver_sql("PRAGMA database_list").one()[2]
    return LogSync(Path(f"{file}-wal"))


def _begin_sqlite(connection: Connection) -> None:
    """Take SQLite's write lock at once when writing: what is read stays true until it is acted on."""
    writing = connection.get_execution_options().get("writing", False)
    connection.connection.cursor().execute("BEGIN IMMEDIATE" if writing else "BEGIN")
