"""Who is next: a bounded queue that is fair between owners."""

from collections import Counter, deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import anyio

from folding_server.workers.job import JobRefused, JobWorker, WorkerJob

WAITING = 64
"""Jobs that wait at once, of all owners together: two workers with jobs of 2 seconds answer the last after a minute."""
OWNER_WAITING = 16
"""Jobs of one owner of tokens that wait at once: a quarter of the queue."""


@dataclass(frozen=True)
class QueueLimits:
    """How many jobs may wait, and how many of one owner may wait and be computed at once; None for no limit.

    The limits for an owner hold for owners of tokens: callers without are one and the same to the server.
    """

    waiting: int = WAITING
    owner_waiting: int | None = OWNER_WAITING
    owner_at_once: int | None = None


@dataclass(eq=False)
class QueuedJob:
    """A job in the queue. ``turn`` is set when it has a worker."""

    job: WorkerJob[Any]
    turn: anyio.Event = field(default_factory=anyio.Event)
    worker: JobWorker | None = None


class JobQueue:
    """Jobs that wait, and counts of those that are computed.

    Owners take turns: next is the oldest job of the owner with the fewest jobs being computed, and among those of the
    one that has been passed over longest.
    """

    def __init__(self, limits: QueueLimits) -> None:
        self._limits = limits
        self._waiting: dict[str | None, deque[QueuedJob]] = {}
        self._computed: Counter[str | None] = Counter()

    def __len__(self) -> int:
        """How many jobs wait."""
        return sum(map(len, self._waiting.values()))

    def add(self, queued: QueuedJob, *, idle: bool = False) -> None:
        """Let a job wait, if only until it is given to a worker that is ``idle``. JobRefused if as many wait as may."""
        job = queued.job
        if not (idle and self._may_begin(job.owner)):
            self._check_may_wait(job)
        self._waiting.setdefault(job.owner, deque()).append(queued)

    def remove(self, queued: QueuedJob) -> None:
        """Forget a job that waits no longer; nothing if it is not there."""
        own = self._waiting.get(queued.job.owner)
        if own is not None and queued in own:
            own.remove(queued)
            self._drop_empty(queued.job.owner)

    def take(self) -> QueuedJob | None:
        """The job that is to be computed next, counted for its owner until ``finished``; None if none may be."""
        allowed = list(self._may_compute())
        if not allowed:
            return None
        owner = min(allowed, key=lambda each: self._computed[each])
        own = self._waiting.pop(owner)
        queued = own.popleft()
        if own:
            self._waiting[owner] = own  # at the end: the others come first now
        self._computed[owner] += 1
        return queued

    def finished(self, job: WorkerJob[Any]) -> None:
        """Count a job no longer."""
        self._computed[job.owner] -= 1
        if not self._computed[job.owner]:
            del self._computed[job.owner]

    def _may_compute(self) -> Iterator[str | None]:
        """The owners with jobs that wait and need not, the one passed over longest first."""
        yield from filter(self._may_begin, self._waiting)

    def _may_begin(self, owner: str | None) -> bool:
        """Whether another job of an owner may be computed."""
        most = self._limits.owner_at_once
        return owner is None or most is None or self._computed[owner] < most

    def _check_may_wait(self, job: WorkerJob[Any]) -> None:
        waiting, most = len(self), self._limits.owner_waiting
        if waiting >= self._limits.waiting:
            raise JobRefused(
                f"{job.name} would have to wait, and the queue is full ({waiting} waiting); call it again in a minute, or go on "
                "without it"
            )
        own = len(self._waiting.get(job.owner, ()))
        if job.owner is not None and most is not None and own >= most:
            raise JobRefused(
                f"{job.name} would have to wait, and the queue is full for {job.owner} ({own} waiting); call it again when another "
                "call is answered"
            )

    def _drop_empty(self, owner: str | None) -> None:
        if not self._waiting[owner]:
            del self._waiting[owner]
