"""Adding a sequence is a long call: a worker process does it, with progress in percent, until nobody waits for it."""

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.server import FoldingServer
from folding_server.store.limits import OwnerLimits
from folding_server.workers.worker_pool import WorkerPool
from folding_server.workers.worker_process import WorkerProcess
from hosts import Host
from mcp import Client
from pictures import noise, write_image
from test_server_long_calls import Told
from test_worker_processes import gone_within
from token_hosts import called_by, served_to
from videos import SQUARE, Rest, write_clip

pytestmark = pytest.mark.anyio


@pytest.fixture
def films(tmp_path: Path) -> Path:
    """A folder that may be read, with photos of a hat."""
    for number in range(1, 5):
        write_image(tmp_path / "films" / "hat" / f"{number}.png", noise(120, 90, number))
    return tmp_path / "films"


@pytest.fixture
def worker() -> Iterator[WorkerProcess]:
    process = WorkerProcess()
    yield process
    process.close()


@asynccontextmanager
async def served(data: Path, films: Path, worker: WorkerProcess) -> AsyncIterator[Host]:
    """A host of a server whose long calls are computed by one worker process."""
    with AppContext(ServerSettings(data, allowed=(films,)), WorkerPool([worker])) as app:
        async with Client(FoldingServer(app)) as client:
            yield Host(client)


async def test_a_worker_process_looks_through_the_photos_and_tells_percents(
    tmp_path: Path, films: Path, worker: WorkerProcess
) -> None:
    told = Told()
    async with served(tmp_path / "data", films, worker) as host:
        answer = await host.client.call_tool("add_sequence", {"paths": "hat"}, progress_callback=told)
    assert not answer.is_error
    assert worker.process_id is not None
    assert told.steps == [(part, 100, "looking through the images") for part in (25, 50, 75, 100)]


@pytest.mark.slow
async def test_a_film_that_is_called_off_ends_its_process_and_paper_was_folded_meanwhile(
    tmp_path: Path, films: Path, worker: WorkerProcess
) -> None:
    write_clip(films / "long.mp4", [Rest(SQUARE, 60.0)])
    told, making = Told(), tmp_path / "data" / "added" / ".making"
    async with served(tmp_path / "data", films, worker) as host:
        run_id = (await host.call("open_run"))["run_id"]
        async with anyio.create_task_group() as group:

            async def add() -> None:
                await host.client.call_tool("add_sequence", {"paths": "long.mp4"}, progress_callback=told)

            group.start_soon(add)
            await told.begun.wait()
            process = worker.process_id
            before = len(told.steps)
            await host.call("fold", edge=[1, 3], direction=1, run_id=run_id)
            assert len(told.steps) < before + 50
            group.cancel_scope.cancel()
        assert process is not None
        assert await gone_within(1, process)
        with anyio.fail_after(5):
            while any(making.iterdir()):  # noqa: ASYNC110 - nobody else tells
                await anyio.sleep(0.05)
        assert (await host.call("list_sequences"))["sequences"] == []


async def test_an_owner_whose_time_is_used_up_adds_nothing(tmp_path: Path, films: Path) -> None:
    limits = OwnerLimits(vision_seconds=0)
    settings = ServerSettings(tmp_path / "data", allowed=(films,), shared=True, limits=limits)
    with served_to(settings, tmp_path, "ada") as url:
        async with called_by("ada", url) as ada:
            assert "seconds for ada today" in await ada.refusal("add_sequence", paths="hat")
            assert (await ada.call("list_sequences"))["sequences"] == []
