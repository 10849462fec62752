"""The connection to a SQLite file on which event loops read and write: it is kept, and gives up where it would have to wait."""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

from sqlalchemy import URL, Connection, StaticPool, create_engine
from sqlalchemy.exc import DBAPIError

from folding_server.store.non_blocking import WouldBlock

TURN_SECONDS = 0.005
"""How long an event loop lets a thread of its own process end its transaction: as long as Python has one thread of several
that compute go on (``sys.getswitchinterval``), so that a loop that waits is kept no longer than one that computes."""

_KIND = 0xFF
"""The bits of SQLite's error codes that tell kinds of errors apart (https://www.sqlite.org/rescode.html)."""


class LoopConnection:
    """One connection, for one transaction at a time. ``close`` it when done."""

    def __init__(self, url: URL) -> None:
        """Not connected yet."""
        arguments = {"timeout": 0, "check_same_thread": False}
        self._engine = create_engine(
            url, connect_args=arguments, poolclass=StaticPool, isolation_level="AUTOCOMMIT"
        )
        self._connection: Connection | None = None
        self._turn = Lock()

    def close(self) -> None:
        """Give the connection back."""
        with self._turn:
            self._disconnect()

    @contextmanager
    def begun(self, *, writing: bool) -> Iterator[Connection]:
        """A transaction; rolled back on any exception. Raises WouldBlock if another has the lock that it needs."""
        with without_waiting(self._turn):
            try:
                connection = self._connected()
                with _transaction(connection, writing=writing):
                    yield connection
            except (sqlite3.Error, DBAPIError) as error:
                if _is_busy(error):
                    raise WouldBlock from error
                self._disconnect()
                raise

    def _connected(self) -> Connection:
        if self._connection is None:
            self._connection = self._engine.connect()
            self._connection.connection.cursor().execute("PRAGMA synchronous = NORMAL")
        return self._connection

    def _disconnect(self) -> None:
        """Give up a connection, which may be broken."""
        if self._connection is not None:
            self._connection.invalidate()
            self._connection.close()
            self._connection = None
        self._engine.dispose()


@contextmanager
def without_waiting(turn: Lock) -> Iterator[None]:
    """Hold a lock of the process's own. Raises WouldBlock if it is not given back soon."""
    if not turn.acquire(timeout=TURN_SECONDS):
        raise WouldBlock
    try:
        yield
    finally:
        turn.release()


@contextmanager
def _transaction(connection: Connection, *, writing: bool) -> Iterator[None]:
    """A transaction of SQLite's own; SQLAlchemy knows of none, and so does nothing for it."""
    kept = connection.connection
    cursor = kept.cursor()
    cursor.execute("BEGIN IMMEDIATE" if writing else "BEGIN")
    try:
        yield
        cursor.execute("COMMIT")
    except BaseException:
        driver = kept.driver_connection
        if driver is not None and driver.in_transaction:  # a full disk has SQLite end it by itself
            cursor.execute("ROLLBACK")
        raise


def _is_busy(error: Exception) -> bool:
    """Whether another connection has the lock."""
    cause = error.orig if isinstance(error, DBAPIError) else error
    return getattr(cause, "sqlite_errorcode", 0) & _KIND == sqlite3.SQLITE_BUSY
