"""A job: long work as plain data, and what comes of it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

from folding_server.errors import FoldingError

Answer = TypeVar("Answer")


class Announce(Protocol):
    """Says what is being done now, and what part of the whole job is done, 0 to 1, where that is known.

    What was announced before is done.
    """

    def __call__(self, doing: str, part: float | None = None, /) -> None:
        """Say it to whoever waits for the job."""
        ...


class JobRefused(FoldingError):
    """The queue takes no further job now."""


class WorkerEnded(FoldingError):
    """The process that computed a job has ended in the middle of it."""


class WorkerFault(Exception):
    """A fault of the server's own in a worker process; the message is its traceback."""


class JobStopped(Exception):
    """Nobody waits for the job any more."""


@dataclass(frozen=True, eq=False)
class WorkerJob(Generic[Answer]):
    """``work(announce, *given)``, to be computed where there is room.

    ``work`` is a function of a module and ``given`` can be pickled, as what it returns, so that both can go to another
    process. ``name`` is the tool that asks. ``owner`` is whom the queue counts it for. ``place`` is what workers keep
    from one job to the next, such as the path of a sequence: a job goes to a worker that has seen its place where there is a choice.
    """

    name: str
    work: Callable[..., Answer]
    given: tuple[Any, ...] = ()
    owner: str | None = None
    place: str | None = None


@dataclass(frozen=True)
class JobOutcome(Generic[Answer]):
    """What a job came to: an answer or an error, and the seconds of processor time it took."""

    seconds: float
    answer: Answer | None = None
    error: Exception | None = field(default=None)


class Waiter(Protocol):
    """Who waits for a job and is told how far it is, in the event loop."""

    async def queued(self, before: int) -> None:
        """The job waits, and ``before`` others before it."""
        ...

    async def announced(self, doing: str, part: float | None = None) -> None:
        """The job has begun with something, in words, or has come to a part of the whole; what was announced before is done."""
        ...

    def took(self, seconds: float) -> None:
        """The job took so many seconds; told once it is over, also where it failed or was stopped."""
        ...


class JobWorker(Protocol):
    """What computes one job at a time."""

    stoppable: bool
    """Whether ``stop`` ends a job that is being computed."""

    def compute(
        self, job: WorkerJob[Answer], announce: Announce, stopped: Callable[[], bool]
    ) -> JobOutcome[Answer]:
        """Compute a job in the thread that calls. JobStopped if ``stopped`` says so before it has begun; WorkerEnded."""
        ...

    def stop(self) -> None:
        """End what is being computed, where that can be done."""
        ...

    def close(self) -> None:
        """Give back what the worker holds. It computes nothing any more."""
        ...
