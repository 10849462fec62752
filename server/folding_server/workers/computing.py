"""Computing jobs: in a worker process (``python -m folding_server.workers.computing``), or in a thread of the server."""

import os
import pickle
import queue
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable
from typing import IO, Any

from folding_server.errors import FoldingError
from folding_server.workers.job import Announce, Answer, JobOutcome, JobStopped, WorkerFault, WorkerJob

NICENESS = 10
"""How much a worker process gives way: with 10, Linux gives it a tenth of the time of what runs beside it, and all that is left."""


class WorkerThread:
    """Computes in the server's own process: what it computes ends, once nobody waits for it, where it next announces something."""

    stoppable = False

    def compute(
        self, job: WorkerJob[Answer], announce: Announce, stopped: Callable[[], bool]
    ) -> JobOutcome[Answer]:
        """Compute a job here. JobStopped if ``stopped`` says so before it has begun."""
        if stopped():
            raise JobStopped
        return outcome_of(job.work, job.given, announce, time.thread_time)

    def stop(self) -> None:
        """Nothing can be done."""

    def close(self) -> None:
        """Nothing is held."""


def outcome_of(
    work: Callable[..., Answer], given: tuple[Any, ...], announce: Announce, clock: Callable[[], float]
) -> JobOutcome[Answer]:
    """What work comes to, with the seconds by ``clock``."""
    begun = clock()
    try:
        answer = work(announce, *given)
    except Exception as error:  # noqa: BLE001 - whoever waits for the job is told
        return JobOutcome(clock() - begun, error=error)
    return JobOutcome(clock() - begun, answer)


def compute_jobs() -> None:
    """Compute job after job until the server hangs up."""
    jobs, answers = _own_pipes()
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C goes to all processes of a terminal; the server ends us
    if sys.platform != "win32":
        os.nice(NICENESS)
    waiting: queue.SimpleQueue[tuple[Callable[..., object], tuple[Any, ...]]] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(jobs, waiting), daemon=True).start()

    def tell(message: object) -> None:
        answers.write(_pickled(message))
        answers.flush()

    def announce(*said: str | float | None) -> None:
        tell(said)

    while True:
        work, given = waiting.get()
        tell(outcome_of(work, given, announce, time.process_time))


def _own_pipes() -> tuple[IO[bytes], IO[bytes]]:
    """The pipes to and from the server, after which stdin is empty and what libraries print goes to stderr."""
    jobs, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return jobs, answers


def _read(jobs: IO[bytes], waiting: "queue.SimpleQueue[Any]") -> None:
    """Take in jobs. When the server closes its end, or is gone however it went, the process ends, even while it computes."""
    while True:
        try:
            waiting.put(pickle.load(jobs))  # noqa: S301 - from the server itself, by a pipe that nobody else has
        except (EOFError, OSError, pickle.UnpicklingError):
            os._exit(0)
        except Exception:  # noqa: BLE001 - a job that is not understood, such as of a module that is missing here
            traceback.print_exc()
            os._exit(1)


def _pickled(message: object) -> bytes:
    """A message for the server. What a caller can mend stays itself; another error becomes its traceback."""
    if isinstance(message, JobOutcome) and message.error and not isinstance(message.error, FoldingError):
        told = "".join(traceback.format_exception(message.error))
        message = JobOutcome(message.seconds, error=WorkerFault(told))
    return pickle.dumps(message)


if __name__ == "__main__":
    compute_jobs()
