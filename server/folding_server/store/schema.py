"""The table of events, and bringing the table of an earlier version up to it, in any SQL dialect.

Earlier versions had no ``request_id``: their tables gain the column, empty, and a unique index on it. They go on
reading and writing such a table, since they name the columns that they use.
"""

from sqlalchemy import Column, Connection, Index, Integer, MetaData, String, Table, Text, inspect
from sqlalchemy.schema import CreateColumn, CreateIndex, CreateTable

EVENTS = Table(
    "folding_events",
    MetaData(),
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


def bring_up_to_date(connection: Connection) -> None:
    """Make the table where it is missing, and add to an earlier version's what that lacks.

    A table of our name with other columns is left alone; calls on it are then refused.
    """
    connection.execute(CreateTable(EVENTS, if_not_exists=True))
    found = {column["name"] for column in inspect(connection).get_columns(EVENTS.name)}
    if found == {column.name for column in EVENTS.columns} - {EVENTS.c.request_id.name}:
        _add_column(connection, EVENTS.c.request_id)
        found.add(EVENTS.c.request_id.name)
    indexes = {index["name"] for index in inspect(connection).get_indexes(EVENTS.name)}
    if EVENTS.c.request_id.name in found and REQUESTS.name not in indexes:
        connection.execute(CreateIndex(REQUESTS))


def _add_column(connection: Connection, column: Column[str | None]) -> None:
    """Add a column that may be empty."""
    dialect = connection.dialect
    table = dialect.identifier_preparer.format_table(EVENTS)
    definition = CreateColumn(column).compile(dialect=dialect)
    connection.exec_driver_sql(f"ALTER TABLE {table} ADD COLUMN {definition}")
