"""The tables of the store, in any SQL dialect, and bringing a database of an earlier version up to them.

A database says its version in a table of one row, as alembic keeps it. One that is up to date costs a look at that
row; an empty one gets its tables as they are now; an earlier one is taken through ``migrations`` by alembic, which is
loaded for that alone. The first two versions had no such row and are recognised by their columns. They go on reading and
writing a database that was brought up to date, since they name the columns that they use.
"""

from pathlib import Path
from typing import Final

from sqlalchemy import (
    BigInteger,
    Column,
    Connection,
    Float,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    func,
    insert,
    inspect,
    select,
)

from folding_server.errors import RunError

REVISIONS: Final = ("0001", "0002", "0003")
"""The versions of these tables, oldest first: events; their request ids; the list of runs and what owners have used."""

VERSION: Final = REVISIONS[-1]

_METADATA = MetaData()

EVENTS = Table(
    "folding_events",
    _METADATA,
    Column("run_id", String(40), primary_key=True),
    Column("seq", Integer, primary_key=True, autoincrement=False),
    Column("format", Integer, nullable=False),
    Column("time", String(40), nullable=False),
    Column("kind", String(16), nullable=False),
    Column("payload", Text, nullable=False),
    Column("request_id", String(36), nullable=True),
)
"""One row an event. ``request_id`` names the call that asked for it, where the caller gave it a name."""

REQUESTS = Index("folding_events_requests", EVENTS.c.request_id, unique=True)
"""A call is carried out once; SQL counts rows without a request id as different."""

RUNS = Table(
    "folding_runs",
    _METADATA,
    Column("run_id", String(40), primary_key=True),
    Column("owner", String(64), nullable=True),
    Column("sequence", Text, nullable=True),
    Column("frames", Integer, nullable=False),
    Column("opened", String(40), nullable=False),
    Column("changed", String(40), nullable=False),
    Column("events", Integer, nullable=False),
    Column("saved", Integer, nullable=False),
    Column("bytes", BigInteger, nullable=False),
)
"""One row a run, written with each of its events: whose it is, and what a list of runs tells.

``saved`` counts its checkpoints, ``bytes`` the payloads of its events. ``opened`` and ``changed`` always have
microseconds, so that they sort as text.
"""

NEWEST = Index("folding_runs_newest", RUNS.c.opened, RUNS.c.run_id)
NEWEST_OF_OWNER = Index("folding_runs_newest_of_owner", RUNS.c.owner, RUNS.c.opened, RUNS.c.run_id)
"""The orders in which runs are listed, so that a page costs the same however many there are."""

VISION = Table(
    "folding_vision",
    _METADATA,
    Column("owner", String(64), primary_key=True),
    Column("day", String(10), primary_key=True),
    Column("seconds", Float, nullable=False),
)
"""How many seconds the vision tools have computed for an owner on a day (UTC, as YYYY-MM-DD)."""

STORED_VERSION = Table("folding_version", _METADATA, Column("version_num", String(32), primary_key=True))
"""Alembic's table, under a name that no other program's in the same database has."""

_FIRST_COLUMNS = frozenset({column.name for column in EVENTS.columns} - {EVENTS.c.request_id.name})

_UPGRADE_LOCK = 0x464F4C44
"""The number of the advisory lock under which one of several processes brings a database up to date ("FOLD" in ASCII)."""

_MIGRATIONS = Path(__file__).parent / "migrations"


def up_to_date(connection: Connection) -> bool:
    """Whether the database has the tables of this version. RunError if it has those of a later one."""
    if not inspect(connection).has_table(STORED_VERSION.name):
        return False
    found = connection.execute(select(STORED_VERSION.c.version_num)).scalar()
    if found is not None and found not in REVISIONS:
        raise RunError(
            f"the run database has tables of version {found}, and this server knows versions up to {VERSION}; "
            f"use a newer server or choose another database"
        )
    return found == VERSION


def bring_up_to_date(connection: Connection) -> None:
    """Make the tables where there are none, and have alembic change those of an earlier version.

    To be called in a transaction that may write. Others who do the same wait: on SQLite for the transaction, on
    PostgreSQL for a lock. A table of our name with other columns is left alone; calls on it are then refused.
    """
    if up_to_date(connection):
        return
    if connection.dialect.name == "postgresql":
        connection.execute(select(func.pg_advisory_xact_lock(_UPGRADE_LOCK)))
        if up_to_date(connection):
            return
    if not inspect(connection).has_table(EVENTS.name):
        _METADATA.create_all(connection)
        connection.execute(insert(STORED_VERSION), {"version_num": VERSION})
    elif _stamped(connection):
        _migrate(connection)


def _stamped(connection: Connection) -> bool:
    """Whether it is known of which version the tables are; writes it down where they did not say it themselves."""
    if inspect(connection).has_table(STORED_VERSION.name):
        return True
    found = {column["name"] for column in inspect(connection).get_columns(EVENTS.name)}
    if not found >= _FIRST_COLUMNS or found - _FIRST_COLUMNS - {EVENTS.c.request_id.name}:
        return False
    indexes = {index["name"] for index in inspect(connection).get_indexes(EVENTS.name)}
    STORED_VERSION.create(connection)
    version = REVISIONS[1] if REQUESTS.name in indexes else REVISIONS[0]
    connection.execute(insert(STORED_VERSION), {"version_num": version})
    return True


def _migrate(connection: Connection) -> None:
    from alembic import command  # noqa: PLC0415  (only where a database is of an earlier version)
    from alembic.config import Config  # noqa: PLC0415

    settings = Config()
    settings.set_main_option("script_location", str(_MIGRATIONS).replace("%", "%%"))
    settings.attributes["connection"] = connection
    command.upgrade(settings, "head")
