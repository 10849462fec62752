"""A few workers with one queue before them."""

import os
import time
from collections.abc import Sequence
from threading import Event
from typing import Any, cast

import anyio
from anyio import from_thread, to_thread
from cachetools import LRUCache

from folding_server.workers.computing import WorkerThread
from folding_server.workers.job import Announce, Answer, JobOutcome, JobWorker, Waiter, WorkerJob
from folding_server.workers.job_queue import JobQueue, QueuedJob, QueueLimits
from folding_server.workers.worker_process import WorkerProcess

MOST_BY_DEFAULT = 2
"""Worker processes where nothing is said: each takes up to 400 MB."""
PLACES_KEPT = 4
"""Places that a worker is taken to remember, as many as it keeps observers for."""


def usual_workers() -> int:
    """How many worker processes a server has where nothing is said: one for each core, at most MOST_BY_DEFAULT."""
    return min(os.cpu_count() or 1, MOST_BY_DEFAULT)


def usual_pool(processes: int, limits: QueueLimits) -> "WorkerPool":
    """Workers that are so many processes; with 0, as many threads of this process as there would be processes elsewhere."""
    if processes:
        return WorkerPool([WorkerProcess() for _ in range(processes)], limits)
    return WorkerPool([WorkerThread() for _ in range(MOST_BY_DEFAULT)], limits)


class WorkerPool:
    """Computes jobs for one event loop at a time.

    >>> pool = WorkerPool([WorkerProcess(), WorkerProcess()])
    >>> total = await pool.compute(WorkerJob("add", operator.add, (1, 2)), waiter)
    """

    def __init__(self, workers: Sequence[JobWorker], limits: QueueLimits | None = None) -> None:
        self._queue = JobQueue(limits or QueueLimits())
        self._workers = tuple(workers)
        self._idle = list(workers)
        self._seen: dict[JobWorker, LRUCache[str, None]] = {each: LRUCache(PLACES_KEPT) for each in workers}

    @property
    def waiting(self) -> int:
        """How many jobs wait."""
        return len(self._queue)

    async def compute(self, job: WorkerJob[Answer], waiter: Waiter) -> Answer:
        """The answer of a job, once there is room and it is computed; its own error if it raises one.

        Where the call is cancelled, the job leaves the queue, or its worker is stopped. JobRefused if the queue is full,
        WorkerEnded if the worker's process ends.
        """
        queued = QueuedJob(job)
        self._queue.add(queued, idle=bool(self._idle))
        self._hand_out()
        try:
            if queued.worker is None:
                await waiter.queued(self.waiting - 1)
            await queued.turn.wait()
            assert queued.worker is not None
            outcome = await self._on(queued.worker, job, waiter)
        finally:
            self._leave(queued)
        if outcome.error is not None:
            raise outcome.error
        return cast("Answer", outcome.answer)

    def close(self) -> None:
        """End all worker processes."""
        for worker in self._workers:
            worker.close()

    async def _on(self, worker: JobWorker, job: WorkerJob[Answer], waiter: Waiter) -> JobOutcome[Answer]:
        """Have one worker compute a job, and stop it if nobody waits any more."""
        begun, stopped = time.monotonic(), Event()
        seconds: float | None = None
        try:
            outcome = await to_thread.run_sync(
                worker.compute,
                job,
                _announcing(waiter),
                stopped.is_set,
                abandon_on_cancel=worker.stoppable,
                limiter=anyio.CapacityLimiter(1),  # the queue is the limit
            )
            seconds = outcome.seconds
        finally:
            if seconds is None:
                stopped.set()
                worker.stop()
                self._seen[worker].clear()
            waiter.took(time.monotonic() - begun if seconds is None else seconds)
        return outcome

    def _hand_out(self) -> None:
        """Give jobs that wait to workers that are idle."""
        while self._idle and (queued := self._queue.take()) is not None:
            queued.worker = self._best_for(queued.job.place)
            self._idle.remove(queued.worker)
            queued.turn.set()

    def _best_for(self, place: str | None) -> JobWorker:
        """The idle worker that has seen the place; else the one that has computed most lately."""
        seen = [worker for worker in self._idle if place in self._seen[worker]]
        worker = seen[-1] if seen else self._idle[-1]
        if place is not None:
            self._seen[worker][place] = None
        return worker

    def _leave(self, queued: QueuedJob) -> None:
        """A job is done, or nobody waits for it: its place is free."""
        self._queue.remove(queued)
        if queued.worker is not None:
            self._queue.finished(queued.job)
            self._idle.append(queued.worker)
            self._hand_out()


def _announcing(waiter: Waiter) -> Announce:
    """Tells a waiter, from the thread in which its job is computed. Where nobody waits any more, that ends what announces."""

    def announce(*said: Any) -> None:  # noqa: ANN401 - what ``announced`` takes
        from_thread.check_cancelled()
        from_thread.run(waiter.announced, *said)

    return announce
