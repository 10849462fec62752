"""Servers over stdio that start at once: forked from a process that has loaded all they need.

A server takes a second to load, and is killed within half of one: without this, ``benchmarks/kills.py`` waits most of
its time. A forked process runs the same command, with pipes of its own.
"""

import importlib
import os
import runpy
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import IO, Self

MODULE = "folding_server"
LOADED = (
    "folding_server.cli",
    "folding_server.diagram.palette",
    "folding_server.mcp.server",
    "folding_server.store.run_store",
    "mcp.server.stdio",
    "sqlalchemy.dialects.sqlite",
    "sqlalchemy.dialects.postgresql.psycopg",
    "psycopg",
)
"""What a server loads until it has answered its first call."""
_SHORT = 4096


class ForkedServer:
    """One forked process, as far as ``subprocess.Popen`` is used for it."""

    def __init__(self, pid: int, stdin: IO[str], stdout: IO[str]) -> None:
        self.pid, self.stdin, self.stdout = pid, stdin, stdout
        self._killed = threading.Lock()

    def kill(self) -> None:
        """Kill it with SIGKILL; once, since its number may be another's afterwards."""
        if self._killed.acquire(blocking=False):
            os.kill(self.pid, signal.SIGKILL)


class ServerStem:
    """The process that servers are forked from. It forks one when asked and waits for its end before the next."""

    def __init__(self) -> None:
        self._channel, theirs = socket.socketpair()
        command = [sys.executable, __file__, str(theirs.fileno())]
        self._process = subprocess.Popen(command, pass_fds=[theirs.fileno()])
        theirs.close()

    @contextmanager
    def server(self, database: str) -> Iterator[ForkedServer]:
        """A server on a database; it is killed at the end, if it was not before."""
        (their_input, ours), (our_output, theirs) = os.pipe(), os.pipe()
        socket.send_fds(self._channel, [database.encode()], [their_input, theirs])
        for end in (their_input, theirs):
            os.close(end)
        pid = int(self._channel.recv(_SHORT))
        stdin, stdout = os.fdopen(ours, "w"), os.fdopen(our_output)
        forked = ForkedServer(pid, stdin, stdout)
        try:
            yield forked
        finally:
            forked.kill()
            stdout.close()
            with suppress(BrokenPipeError):  # what was written and never read
                stdin.close()
            self._channel.recv(_SHORT)  # it has ended

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the process."""
        self._channel.close()
        self._process.wait()


def fork_when_asked(channel: socket.socket) -> None:
    """Be the stem: fork a server for each request, tell its process id, and later that it has ended."""
    for module in LOADED:
        with suppress(ImportError):  # drivers of databases that are not asked for
            importlib.import_module(module)
    while True:
        request, ends, *_ = socket.recv_fds(channel, _SHORT, 2)
        if not request:
            return
        pid = os.fork()
        if pid == 0:
            become_server(request.decode(), *ends)
        for end in ends:
            os.close(end)
        channel.send(str(pid).encode())
        os.waitpid(pid, 0)
        channel.send(b"ended")


def become_server(database: str, stdin: int, stdout: int) -> None:
    """Be a server, in a process that was just forked."""
    os.dup2(stdin, 0)
    os.dup2(stdout, 1)
    os.close(stdin)
    os.close(stdout)
    sys.argv = [MODULE, "--database", database]
    try:
        runpy.run_module(MODULE, run_name="__main__")
    finally:
        os._exit(0)


if __name__ == "__main__":
    fork_when_asked(socket.socket(fileno=int(sys.argv[1])))
