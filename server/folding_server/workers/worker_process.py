"""One worker process, from the server's side: started when first needed, killed when nobody waits for its job.

Both sides speak in pickles over the process's own stdin and stdout, which are pipes: nothing of it touches the server's.
"""

import contextlib
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import IO, Any

from folding_server.workers.job import (
    Announce,
    Answer,
    JobOutcome,
    JobStopped,
    WorkerEnded,
    WorkerJob,
)

END_SECONDS = 5
"""Seconds that a process has to go after it was killed, or has closed its output."""
COMMAND = (sys.executable, "-P", "-m", "folding_server.workers.computing")
"""Starts a worker process. ``-P``: modules in the folder where the server was started are none of ours."""
_FLAGS = 0x00004000 | 0x08000000 if sys.platform == "win32" else 0
"""BELOW_NORMAL_PRIORITY_CLASS and CREATE_NO_WINDOW of Windows; elsewhere the process lowers its own priority."""
_SINGLE_THREADED = {"OPENBLAS_NUM_THREADS": "1"}
"""Where nothing else is said: threads for the small matrices of vision cost a fifth of its processor time and save nothing."""


class WorkerProcess:
    """A process that computes one job at a time, and another one after it has ended."""

    stoppable = True

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._computing: subprocess.Popen[bytes] | None = None
        self._changing = threading.Lock()

    @property
    def process_id(self) -> int | None:
        """The id of the process; None while there is none."""
        process = self._process
        return None if process is None else process.pid

    def compute(
        self, job: WorkerJob[Answer], announce: Announce, stopped: Callable[[], bool]
    ) -> JobOutcome[Answer]:
        """Have a job computed. JobStopped if ``stopped`` says so before it has begun, WorkerEnded if the process ends."""
        process = self._running(stopped)
        try:
            outcome = _hear(process, job, announce)
        except (EOFError, OSError, pickle.UnpicklingError) as error:
            raise self._ended(process, job) from error
        except BaseException:  # nobody hears the answer, and the next job must not
            self._forget(process)
            process.kill()
            _wait_for_end(process)
            raise
        with self._changing:
            if self._computing is process:
                self._computing = None
            killed = self._process is not process
        if killed:
            _wait_for_end(process)
        return outcome

    def stop(self) -> None:
        """Kill the process. The thread that waits in ``compute`` is told by its end."""
        with self._changing:
            process, self._process = self._process, None
            computing = self._computing is process
        if process is not None:
            process.kill()
            if not computing:
                threading.Thread(target=_wait_for_end, args=(process,)).start()

    def close(self) -> None:
        """Kill the process and wait until it is gone."""
        process = self._process
        self.stop()
        if process is not None:
            _wait_for_end(process)

    def _running(self, stopped: Callable[[], bool]) -> subprocess.Popen[bytes]:
        """The process, started if need be."""
        with self._changing:
            if stopped():
                raise JobStopped
            if self._process is not None and self._process.poll() is not None:
                _wait_for_end(self._process)
                self._process = None
            if self._process is None:
                self._process = subprocess.Popen(  # noqa: S603 - our own interpreter and module
                    COMMAND,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    creationflags=_FLAGS,
                    env=_SINGLE_THREADED | os.environ,
                )
            self._computing = self._process
            return self._process

    def _forget(self, process: subprocess.Popen[bytes]) -> None:
        """Start another process for the next job."""
        with self._changing:
            if self._computing is process:
                self._computing = None
            if self._process is process:
                self._process = None

    def _ended(self, process: subprocess.Popen[bytes], job: WorkerJob[Any]) -> WorkerEnded:
        """The error for a job whose process is gone."""
        self._forget(process)
        code = _wait_for_end(process)
        return WorkerEnded(
            f"the process that computed {job.name} has ended before its answer ({_cause(code)}); nothing has changed: "
            f"call {job.name} again, and if that ends the same way, the machine may have too little memory for it"
        )


def _hear(process: subprocess.Popen[bytes], job: WorkerJob[Answer], announce: Announce) -> JobOutcome[Answer]:
    """Hand over a job and listen until its outcome is there."""
    said, heard = _pipes(process)
    said.write(pickle.dumps((job.work, job.given)))
    said.flush()
    while True:
        message = pickle.load(heard)  # noqa: S301 - from a process of our own, by a pipe that nobody else has
        if isinstance(message, JobOutcome):
            return message
        announce(*message)


def _pipes(process: subprocess.Popen[bytes]) -> tuple[IO[bytes], IO[bytes]]:
    assert process.stdin is not None
    assert process.stdout is not None
    return process.stdin, process.stdout


def _wait_for_end(process: subprocess.Popen[bytes]) -> int:
    """Wait for the end of a process that is ending, and give its exit code."""
    for pipe in _pipes(process):
        with contextlib.suppress(OSError):
            pipe.close()
    try:
        return process.wait(END_SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()


def _cause(code: int) -> str:
    """How a process ended, in words."""
    if code >= 0:
        return f"exit code {code}"
    try:
        return f"killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"killed by signal {-code}"
