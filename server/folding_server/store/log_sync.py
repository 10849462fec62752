"""Syncing SQLite's write-ahead log once for all the commits that wait for it (group commit).

A sync takes some milliseconds of a disk, and SQLite's own (``synchronous = FULL``) takes them within every commit, while
all other writers wait. With ``synchronous = NORMAL`` a commit only adds to the log; SQLite syncs it when it begins anew
and before it is copied into the database, so that what is there after a failure of the machine is always a whole number of
commits, the last ones perhaps missing. ``LogSync`` makes good on these: whoever has committed waits, with the lock given
back, for a sync of the log that begins after the commit, and one sync serves all who wait by then. Who has only read waits
likewise for what it may have read. So an answer holds after the death of the process and of the machine, as with FULL
(https://www.sqlite.org/wal.html, section 2.3). Processes that share a file sync each what they write: what one has read
within the milliseconds before another's sync is lost with it if the machine dies just then.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Lock

import anyio
import anyio.to_thread
from anyio.lowlevel import RunVar

_sync = getattr(os, "fdatasync", os.fsync)
"""SQLite's own choice: the data, and of the metadata what is needed to read them, where the system can tell them apart."""


class LogSync:
    """The write-ahead log of one SQLite file, and how much of it is on the disk. Safe to share between threads.

    ::

        with sync.adding():     # one writer at a time
            ...                 # begin, write, commit
        sync.wait()             # now it may be answered
        await sync.wait_in_loop()   # the same in an event loop
    """

    def __init__(self, log: Path) -> None:
        self._log = log
        self._turn = Lock()
        self._begun = self._ended = self._synced = 0
        """Writers that have begun, that have ended, and those of them whose commits are on the disk."""
        self._started = self._done = 0
        """Syncs that have begun, and the last that was done."""
        self._asked: RunVar[anyio.Event | None] = RunVar(f"sync of {log}", None)
        """The end of the sync that an event loop has asked a thread for, if it has."""

    @contextmanager
    def adding(self) -> Iterator[None]:
        """The time of one writer, from before it begins until after its commit. Writers may not overlap."""
        self._begun += 1
        try:
            yield
        finally:
            self._ended = self._begun

    def wait(self) -> None:
        """Return when all that can have been read by now is on the disk. OSError if the disk refuses.

        That is so after any sync that begins from now on.
        """
        if self._synced == self._begun:
            return
        before = self._started
        with self._turn:
            if self._done > before or self._synced == self._begun:
                return
            self._started += 1
            ended = self._ended
            self._sync_log()
            self._synced, self._done = ended, self._started

    async def wait_in_loop(self) -> None:
        """The same as ``wait``, in an event loop: one of those who wait asks a thread for a sync, for all of them."""
        before = self._started
        while self._synced != self._begun and self._done <= before:
            if (asked := self._asked.get()) is not None:
                await asked.wait()
            else:
                await self._ask()

    async def _ask(self) -> None:
        asked = anyio.Event()
        self._asked.set(asked)
        try:
            await anyio.to_thread.run_sync(self.wait)
        finally:
            self._asked.set(None)
            asked.set()

    def _sync_log(self) -> None:
        """Sync the log. Where there is none, SQLite has copied it into the database and synced that."""
        with suppress(FileNotFoundError):
            log = os.open(self._log, os.O_RDWR | getattr(os, "O_BINARY", 0))
            try:
                _sync(log)
            finally:
                os.close(log)
