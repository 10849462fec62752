"""Where events are kept: one table of any SQL database, to which rows are only ever added.

A run's events are numbered, and (run_id, seq) is the primary key: of two writers who both saw event n, one
adds event n+1 and the other gets ``SeqTaken``, whatever the database. SQLite writes ahead (WAL) and syncs at
every commit (FULL): what has been answered survives the death of the process and of the machine. Every
failure of the database becomes a RunError of one sentence that names the database, without its password.
"""

import json
import re
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pydantic import ValidationError
from sqlalchemy import (
    URL,
    Column,
    Connection,
    Engine,
    Integer,
    MetaData,
    QueuePool,
    Row,
    String,
    Table,
    Text,
    create_engine,
    event,
    func,
    insert,
    make_url,
    select,
)
from sqlalchemy.exc import ArgumentError, DBAPIError, IntegrityError, SQLAlchemyError
from sqlalchemy.pool import ConnectionPoolEntry
from sqlalchemy.schema import CreateTable

from folding_server.errors import RunError
from folding_server.store.run_events import EVENT, FORMAT, Event

DATABASE_NAME = "runs.sqlite3"
"""The file that holds the runs of a data folder."""

BUSY_SECONDS = 10.0
"""How long a writer waits for another process's transaction on the same SQLite file."""

EVENTS = Table(
    "folding_events",
    MetaData(),
    Column("run_id", String(40), primary_key=True),
    Column("seq", Integer, primary_key=True, autoincrement=False),
    Column("format", Integer, nullable=False),
    Column("time", String(40), nullable=False),
    Column("kind", String(16), nullable=False),
    Column("payload", Text, nullable=False),
)


class SeqTaken(Exception):
    """Another writer has added an event with this number to the run; look again and try again."""


def database_url(folder: Path) -> str:
    """The URL of a data folder's database; makes the folder if need be. Raises RunError if that cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(
            f"the data folder {str(folder)!r} cannot be made ({error.strerror}); choose another with --data"
        ) from error
    return URL.create("sqlite", database=str(folder / DATABASE_NAME)).render_as_string()


class Transaction:
    """Reads and adds events within one transaction of an ``EventLog``."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def events(self, run_id: str, first: int = 1) -> list[Event]:
        """The run's events from number ``first`` on, in order. Raises RunError if one cannot be read."""
        query = select(EVENTS).where(EVENTS.c.run_id == run_id, EVENTS.c.seq >= first).order_by(EVENTS.c.seq)
        return [_event(row) for row in self._connection.execute(query)]

    def holds(self, run_id: str) -> bool:
        """Whether there is a first event of this run."""
        query = select(EVENTS.c.seq).where(EVENTS.c.run_id == run_id, EVENTS.c.seq == 1)
        return self._connection.execute(query).first() is not None

    def append(self, run_id: str, added: Event) -> None:
        """Add the event under its number; ``EventLog.writing`` raises SeqTaken if the number is taken."""
        row = {
            "run_id": run_id,
            "seq": added.seq,
            "format": FORMAT,
            "time": added.time.isoformat(),
            "kind": added.kind,
            "payload": added.model_dump_json(exclude={"seq", "time", "kind"}),
        }
        self._connection.execute(insert(EVENTS), row)

    def openings(self) -> list[tuple[str, Event, int]]:
        """Every run's id, first event and number of events, oldest run first."""
        last = func.max(EVENTS.c.seq).label("last")
        counts = select(EVENTS.c.run_id, last).group_by(EVENTS.c.run_id).subquery()
        query = (
            select(EVENTS, counts.c.last)
            .join(counts, counts.c.run_id == EVENTS.c.run_id)
            .where(EVENTS.c.seq == 1)
            .order_by(EVENTS.c.run_id)
        )
        return [(row.run_id, _event(row), row.last) for row in self._connection.execute(query)]


class EventLog:
    """The table of events in one database. Safe to share between threads; close it when done."""

    def __init__(self, url: str) -> None:
        """Connect and make the table if it is missing. Raises RunError if the database cannot be used."""
        self._engine = _engine(url)
        try:
            self._create_table()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Give back all connections."""
        self._engine.dispose()

    @contextmanager
    def reading(self) -> Iterator[Transaction]:
        """A transaction that only reads."""
        with self._answered(), self._engine.connect() as connection, connection.begin():
            yield Transaction(connection)

    @contextmanager
    def writing(self) -> Iterator[Transaction]:
        """A transaction that may append; rolled back on any exception. Raises SeqTaken."""
        with self._answered(), self._engine.connect() as connection:
            connection.execution_options(writing=True)
            with connection.begin():
                yield Transaction(connection)

    def _create_table(self) -> None:
        create = CreateTable(EVENTS, if_not_exists=True)
        try:
            with self._engine.connect() as connection:
                connection.execution_options(writing=True)
                with connection.begin():
                    connection.execute(create)
        except IntegrityError:
            # PostgreSQL: another process made the table between the look and the making.
            with self.reading() as transaction:
                transaction.holds("")
        except SQLAlchemyError as error:
            raise self._sentence(error) from error

    @contextmanager
    def _answered(self) -> Iterator[None]:
        try:
            yield
        except IntegrityError as error:
            raise SeqTaken from error
        except SQLAlchemyError as error:
            raise self._sentence(error) from error

    def _sentence(self, error: SQLAlchemyError) -> RunError:
        cause = error.orig if isinstance(error, DBAPIError) else error
        reason = str(cause).strip().split("\n")[0].rstrip(".")
        url = self._engine.url
        name = url.database if url.get_backend_name() == "sqlite" else url.render_as_string()
        if "locked" in reason:
            return RunError(f"the run database {name} is busy with another process; try again in a moment")
        return RunError(f"the run database {name} cannot be used ({reason}); mend it or choose another")


def _event(row: Row[tuple[object, ...]]) -> Event:
    """The event in a row. Raises RunError if it is from a newer format or unreadable."""
    if row.format > FORMAT:
        raise RunError(
            f"run {row.run_id} was recorded in format {row.format}, and this server reads up to {FORMAT}; "
            f"use a newer server or open another run"
        )
    try:
        payload = json.loads(row.payload)
        return EVENT.validate_python({"seq": row.seq, "time": row.time, "kind": row.kind, **payload})
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
        return _sqlite_engine(parsed) if parsed.get_backend_name() == "sqlite" else create_engine(parsed)
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
    """Leave transactions to ``_begin_sqlite``; make commits durable."""
    connection.isolation_level = None
    _write_ahead(connection)
    connection.execute("PRAGMA synchronous = FULL")


def _write_ahead(connection: sqlite3.Connection) -> None:
    """Switch to WAL. SQLite does not wait when two processes switch a new file at once, so this does."""
    deadline = time.monotonic() + BUSY_SECONDS
    while True:
        try:
            connection.execute("PRAGMA journal_mode = WAL")
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > deadline:
                raise
            time.sleep(0.01)
        else:
            return


def _begin_sqlite(connection: Connection) -> None:
    """Take SQLite's write lock at once when writing: what is read stays true until it is acted on."""
    writing = connection.get_execution_options().get("writing", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writing else "BEGIN")
