"""A batch on a Dask cluster: one task a sequence, on workers that see the same folders.

A worker that dies loses nothing but time: its sequence goes to another one, which continues the run from its last
checkpoint. The lock of a run's record keeps two workers from working on one run. No more tasks are with the scheduler than the
workers have use for; the index of the batch, in the process that began it, knows the others.
"""

import asyncio
import uuid
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from folding_client.batch.batch_budget import RunWatch
from folding_client.batch.batch_entry import BatchEntry
from folding_client.batch.batch_index import BatchTask
from folding_client.batch.conditions import Condition
from folding_client.batch.runner import Batch, PlannedBatch, batch_entry, failed_entry, planned_batch
from folding_client.batch.scheduling import Listener
from folding_client.interrupts import LimitReached, UsageError
from folding_client.progress import Silent
from folding_client.record.redaction import redact
from folding_client.record.totals import Totals, total_cost, total_tokens
from folding_client.settings import Settings

if TYPE_CHECKING:
    from distributed import Client, Event, Future

CLUSTER_SECONDS = 30
"""Seconds that a scheduler has to answer, and that runs have to end after an interrupt."""
POLL_SECONDS = 1.0
"""Seconds between two looks of a worker at whether it should stop."""
TASKS_PER_THREAD = 2
"""Tasks with the scheduler for each thread of its workers: one being worked on, and the next."""


async def run_on_cluster(
    address: str, sequences: Sequence[Path], out: Path, settings: Settings, listener: Listener
) -> list[BatchEntry]:
    """Reconstruct sequences on the cluster of a scheduler. A cancellation ends all runs and leaves each
    resumable. UsageError if the scheduler does not answer, or Dask is not installed.
    """
    batch = Batch([each.resolve() for each in sequences], [Condition(settings)], out)
    with planned_batch(batch, listener) as planned:
        await work_on_cluster(address, planned)
        return list(planned.entries())


async def work_on_cluster(address: str, planned: PlannedBatch) -> None:
    """Do a batch on the cluster of a scheduler, as ``run_on_cluster``."""
    async with _client(address) as client:
        from distributed import Event

        work = _ClusterWork(planned, client, Event(f"foldingagent-stop-{uuid.uuid4().hex}", client=client))
        threads = sum((await client.nthreads()).values())
        limits = replace(planned.batch.limits, jobs=max(threads, 1) * TASKS_PER_THREAD)
        try:
            await planned.queue.work_through(work.entry, limits)
        except asyncio.CancelledError:
            await work.end()
            raise


@dataclass
class _ClusterWork:
    """The runs that are with the workers of a cluster; ``stop`` is set when they are to end."""

    planned: PlannedBatch
    client: "Client"
    stop: "Event"

    def __post_init__(self) -> None:
        self._watches: dict[int, RunWatch] = {}
        self._futures: set[Future[BatchEntry]] = set()
        self.client.subscribe_topic(self.stop.name, self._heard)

    async def entry(self, task: BatchTask, watch: RunWatch) -> BatchEntry:
        """How a run fared as its worker reports it; an entry that says so if no worker could report it."""
        self._watches[task.number] = watch
        settings, folder = self.planned.settings_of(task), self.planned.folder_of(task)
        given = settings.model_dump(mode="json", exclude_unset=True)
        future = self.client.submit(
            work_on, task.sequence, str(folder), given, self.stop.name, task.number, pure=False
        )
        self._futures.add(future)
        try:
            why = await _reported(future)
        except asyncio.CancelledError:
            self._watches.pop(task.number)
            raise
        self._watches.pop(task.number)
        self._futures.discard(future)
        if not isinstance(why, str):
            return why
        return failed_entry(Path(task.sequence).name, folder, why, settings)

    async def end(self) -> None:
        """Have the workers end their runs."""
        from distributed import wait
        from distributed.client import FuturesCancelledError

        await self.stop.set()
        with suppress(TimeoutError, FuturesCancelledError):
            await wait(list(self._futures), timeout=CLUSTER_SECONDS)

    async def _heard(self, event: tuple[Any, Mapping[str, Any]]) -> None:
        """What a worker tells of a run: how far it is, and what it has cost."""
        told = event[1]
        if (watch := self._watches.get(told["run"])) is not None:
            watch.frames, watch.saved = told["frames"], told["saved"]
            watch.spent(told["tokens"], told["cost"])
        if self.planned.budget.is_reached:
            await self.client.set_metadata(self.stop.name, self.planned.budget.reason)


async def _reported(future: "Future[BatchEntry]") -> BatchEntry | str:
    """What a worker reports; why it does not, if none does."""
    from distributed.client import FutureCancelledError

    try:
        error = await future.exception()
        return _why(error) if error is not None else await future
    except FutureCancelledError:
        return "the scheduler is gone; the same command goes on from here"


def work_on(sequence: str, folder: str, given: dict[str, Any], stop: str, run: int = 0) -> BatchEntry:
    """What a worker does with one sequence, until it is done or the event named ``stop`` is set."""
    settings = Settings.model_validate(given)
    return asyncio.run(_unless_stopped(Path(sequence), Path(folder), settings, stop, run))


class _Told(Silent):
    """Tells the process that began the batch what a run costs; stops the run before its next query when that says so."""

    def __init__(self, topic: str, run: int) -> None:
        self._topic = topic
        self._run = run
        self._where = 0, 0
        self._reason: str | None = None

    def step(self, frame: int, frames: int, saved: int) -> None:  # noqa: ARG002
        """A step begins."""
        self._where = frames, saved
        self._tell({})

    def told(self, kind: str, data: Mapping[str, Any], totals: Mapping[str, Totals]) -> None:  # noqa: ARG002
        """A reply came; other events cost nothing."""
        if kind in {"reply", "opened", "resumed"}:
            self._tell(totals)

    def stop(self, reason: str) -> None:
        """The batch has reached its limit."""
        self._reason = reason

    def check(self) -> None:
        """LimitReached if the batch has."""
        if self._reason is not None:
            raise LimitReached(self._reason)

    def _tell(self, totals: Mapping[str, Totals]) -> None:
        from distributed import get_worker

        frames, saved = self._where
        used = {"tokens": total_tokens(totals), "cost": total_cost(totals)}
        get_worker().log_event(self._topic, {"run": self._run, "frames": frames, "saved": saved, **used})


async def _unless_stopped(
    sequence: Path, folder: Path, settings: Settings, stop: str, run: int
) -> BatchEntry:
    from distributed import Event, get_client

    ended, told, client = Event(stop), _Told(stop, run), get_client()
    work = asyncio.ensure_future(batch_entry(sequence, folder, settings, told, told))
    while not (await asyncio.wait({work}, timeout=POLL_SECONDS))[0] and not ended.is_set():
        if reason := client.get_metadata(stop, default=None):
            told.stop(reason)
    if not work.done():
        work.cancel()
        await asyncio.wait({work})
    if work.cancelled():
        return failed_entry(sequence.name, folder, "interrupted", settings)
    return work.result()


def _why(error: BaseException) -> str:
    """Why a worker did not report."""
    from distributed import KilledWorker

    if isinstance(error, KilledWorker):
        return "every worker that had it died; the same command goes on from here"
    said = redact(f"{type(error).__name__}: {error}")
    return (
        f"its worker failed ({said}); see that the workers run this version of the project, then give the same "
        "command again"
    )


@asynccontextmanager
async def _client(address: str) -> AsyncIterator["Client"]:
    try:
        from distributed import Client
    except ImportError as error:
        message = (
            "--dask needs Dask, which is not installed; install it with pip install 'foldingagent-mcp[dask]', or leave "
            "out --dask."
        )
        raise UsageError(message) from error
    client = Client(address, asynchronous=True, timeout=CLUSTER_SECONDS)
    try:
        try:
            await client
        except (OSError, ValueError) as error:
            message = (
                f"No Dask scheduler answers at {address}; name the address that it printed, such as "
                "tcp://HOST:8786."
            )
            raise UsageError(message) from error
        yield client
    finally:
        await client.close()
