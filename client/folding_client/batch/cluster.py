"""A batch on a Dask cluster: one task a sequence, on workers that see the same folders.

A worker that dies loses nothing but time: its sequence goes to another one, which continues the run from its last
checkpoint. The lock of a run's record keeps two workers from working on one run.
"""

import asyncio
import uuid
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from folding_client.batch.runner import BatchEntry, Listener, batch_entry
from folding_client.interrupts import UsageError
from folding_client.record.redaction import redact
from folding_client.settings import Settings

if TYPE_CHECKING:
    from distributed import Client, Future

CLUSTER_SECONDS = 30
"""Seconds that a scheduler has to answer, and that runs have to end after an interrupt."""
POLL_SECONDS = 1.0
"""Seconds between two looks of a worker at whether it should stop."""


async def run_on_cluster(
    address: str, sequences: Sequence[Path], out: Path, settings: Settings, listener: Listener
) -> list[BatchEntry]:
    """Reconstruct sequences on the cluster of a scheduler. A cancellation ends all runs and leaves each
    resumable. UsageError if the scheduler does not answer, or Dask is not installed.
    """
    given = settings.model_dump(mode="json", exclude_unset=True)
    folders = [each.resolve() for each in sequences]
    async with _client(address) as client:
        from distributed import Event, wait
        from distributed.client import FuturesCancelledError

        stop = Event(f"foldingagent-stop-{uuid.uuid4().hex}", client=client)
        futures = [
            client.submit(work_on, str(each), str(out / each.name), given, stop.name, pure=False)
            for each in folders
        ]
        reports = [_reported(*pair, listener) for pair in zip(folders, futures, strict=True)]
        try:
            return list(await asyncio.gather(*reports))
        except asyncio.CancelledError:
            await stop.set()
            with suppress(TimeoutError, FuturesCancelledError):
                await wait(futures, timeout=CLUSTER_SECONDS)
            raise


def work_on(sequence: str, folder: str, given: dict[str, Any], stop: str) -> BatchEntry:
    """What a worker does with one sequence, until it is done or the event named ``stop`` is set."""
    settings = Settings.model_validate(given)
    return asyncio.run(_unless_stopped(Path(sequence), Path(folder), settings, stop))


async def _unless_stopped(sequence: Path, folder: Path, settings: Settings, stop: str) -> BatchEntry:
    from distributed import Event

    told = Event(stop)
    work = asyncio.ensure_future(batch_entry(sequence, folder, settings))
    while not (await asyncio.wait({work}, timeout=POLL_SECONDS))[0] and not told.is_set():
        pass
    if not work.done():
        work.cancel()
        await asyncio.wait({work})
    return _failed(sequence, folder, "interrupted") if work.cancelled() else work.result()


async def _reported(sequence: Path, future: "Future[BatchEntry]", listener: Listener) -> BatchEntry:
    """The line of a sequence as its worker reports it; a line that says so if no worker could report it."""
    from distributed.client import FutureCancelledError

    try:
        error = await future.exception()
        line: BatchEntry = await future if error is None else _failed(sequence, None, _why(error))
    except FutureCancelledError:
        line = _failed(sequence, None, "the scheduler is gone; the same command goes on from here")
    listener.ended(line)
    return line


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


def _failed(sequence: Path, folder: Path | None, reason: str) -> BatchEntry:
    return BatchEntry(sequence.name, "failed", reason, 0, 0, 0.0, str(folder or ""))


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
