"""Working through the runs of a batch: some at a time, finished ones skipped, failed ones again, until a limit is reached.

It knows nothing of how a run is done: here, on a cluster, or made up. What it holds in memory does not grow with the batch.
"""

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass, replace

from folding_client.batch.batch_budget import BatchBudget, RunWatch
from folding_client.batch.batch_entry import BatchEntry
from folding_client.batch.batch_index import BatchIndex, BatchSums, BatchTask

RunWork = Callable[[BatchTask, RunWatch], Awaitable[BatchEntry]]
"""Does one run, tells how it goes, and says how it fared; whatever goes wrong with it is an entry."""
IsThere = Callable[[BatchTask], bool]
"""Whether the folder of a run that was complete is still there."""
FIRST_TRY = frozenset({"waiting", "running", "stopped", "failed", "interrupted"})
"""What is worked on when a batch begins: all but what is complete. What is still called running was cut short."""


class Listener:
    """Is told of every run that begins and ends; does nothing of itself."""

    def planned(self, sums: BatchSums, budget: BatchBudget) -> None:
        """The batch begins; ``sums`` are kept up to date from now on."""

    def begun(self, watch: RunWatch) -> None:
        """A run begins; ``watch`` knows how it goes."""

    def ended(self, line: BatchEntry) -> None:
        """A run ended."""

    def skipped(self, task: BatchTask) -> None:
        """A run was complete before this batch."""

    def left(self, watch: RunWatch) -> None:
        """A run is not worked on any more, however it ended."""

    def finished(self) -> None:
        """Nothing is being worked on any more."""


@dataclass(frozen=True)
class BatchLimits:
    """How many runs are worked on at a time, and how often one that fails is tried in this batch."""

    jobs: int = 1
    tries: int = 1


class BatchQueue:
    """The runs of a batch that are left, in order; it keeps index, sums and listener up to date."""

    def __init__(self, index: BatchIndex, budget: BatchBudget, listener: Listener, is_there: IsThere) -> None:
        self._index = index
        self._budget = budget
        self._listener = listener
        self._is_there = is_there
        self.sums = index.sums()
        budget.settled_before(self.sums.cost)
        self.failed_now = 0
        listener.planned(self.sums, budget)

    async def work_through(self, work: RunWork, limits: BatchLimits) -> None:
        """Do all that is left. A cancellation ends what is under way; the index says then what is left."""
        try:
            for number in range(limits.tries):
                self.failed_now = 0
                tasks = self._left(again=number > 0)
                async with asyncio.TaskGroup() as group:
                    for _ in range(limits.jobs):
                        group.create_task(self._work_on(tasks, work))
                if not self.failed_now or self._budget.is_reached:
                    break
        finally:
            self._listener.finished()

    def _left(self, *, again: bool) -> Iterator[BatchTask]:
        """What is to be done now; what is complete is told, and looked for in its folder."""
        for task in self._index.tasks(frozenset({"failed"}) if again else FIRST_TRY | {"complete"}):
            if self._budget.is_reached:
                return
            if task.status != "complete":
                yield task
            elif self._is_there(task):
                self._listener.skipped(task)
            else:
                self._index.again(task)
                self._moved("complete", "waiting")
                yield replace(task, status="waiting")

    async def _work_on(self, tasks: Iterator[BatchTask], work: RunWork) -> None:
        """RunWork on one run after the other. What was under way when the work is cancelled is left to the next batch."""
        for task in tasks:
            watch = RunWatch(task.number, task.folder, self._budget, (task.tokens, task.cost))
            self._index.begun(task)
            self._moved(task.status, "running")
            self._listener.begun(watch)
            try:
                entry = await work(task, watch)
            except asyncio.CancelledError:
                self._moved("running", "interrupted")
                raise
            finally:
                self._listener.left(watch)
            watch.spent(entry.tokens, entry.cost)
            self._settle(task, watch, replace(entry, tokens=watch.tokens, cost=watch.cost))

    def _settle(self, task: BatchTask, watch: RunWatch, entry: BatchEntry) -> None:
        self._index.ended(task, entry)
        self._moved("running", "complete" if entry.is_done else entry.status)
        self.failed_now += entry.status == "failed"
        self.sums.tokens += watch.tokens_now
        self.sums.cost += watch.cost_now
        self._budget.ended(task.number, watch.cost_now)
        self._listener.ended(entry)

    def _moved(self, before: str, after: str) -> None:
        self.sums.counts[before] -= 1
        self.sums.counts[after] += 1
