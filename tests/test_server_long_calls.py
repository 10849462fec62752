"""Long calls through the protocol: worker processes behind the tools, progress, cancellation, and whose time it was."""

import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

import anyio
import pytest
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.server import FoldingServer
from folding_server.workers.job_queue import QueueLimits
from folding_server.workers.worker_pool import WorkerPool
from folding_server.workers.worker_process import WorkerProcess
from hosts import Host, http_process, images_of, in_memory
from mcp import Client
from mcp.client.streamable_http import streamable_http_client
from photographed import photos
from test_http_tokens import ALICE, BOB, bearing, token_file
from test_worker_processes import gone_within, lives

pytestmark = pytest.mark.anyio


@pytest.fixture(scope="module")
def worker() -> Iterator[WorkerProcess]:
    """A worker process that servers share. Stopped, it has to start again and to find the sheet, which takes a second."""
    process = WorkerProcess()
    yield process
    process.close()


@asynccontextmanager
async def served(
    data: Path, worker: WorkerProcess, limits: QueueLimits | None = None, **client: Any
) -> AsyncIterator[Host]:
    """A host of a server whose long calls are computed by one worker process."""
    with AppContext(ServerSettings(data, sequences=(photos(),)), WorkerPool([worker], limits)) as app:
        async with Client(FoldingServer(app), **client) as connected:
            host = Host(connected)
            await host.call("open_run", sequence="sailboat")
            await host.call("save_checkpoint", frame=1)
            yield host


class Told:
    """What a host is told of a call's progress."""

    def __init__(self) -> None:
        self.steps: list[tuple[float, float | None, str | None]] = []
        self.begun = anyio.Event()

    async def __call__(self, progress: float, total: float | None, message: str | None) -> None:
        self.steps.append((progress, total, message))
        self.begun.set()


async def compare_in_a_run(client: Client, told: Told) -> None:
    """Open a run and compare its first frame; ``told`` is told how far that is."""
    run_id = (await Host(client).call("open_run", sequence="sailboat"))["run_id"]
    await client.call_tool("compare_to_frame", {"frame": 1, "run_id": run_id}, progress_callback=told)


@pytest.mark.slow
async def test_answers_are_those_of_a_server_that_computes_in_its_own_process(
    tmp_path: Path, worker: WorkerProcess
) -> None:
    calls: tuple[tuple[str, dict[str, Any]], ...] = (
        ("propose_actions", {"frame": 2}),
        ("compare_to_frame", {"frame": 1}),
        ("compare_to_frame", {"frame": 2, "images": "small"}),
        ("compare_to_frame", {"frame": 2, "images": "none"}),
        ("check_foldability", {}),
    )
    async with served(tmp_path / "processes", worker) as host:
        by_process = [await host.answer(tool, **arguments) for tool, arguments in calls]
    async with in_memory(tmp_path / "threads", photos()) as host:
        await host.call("open_run", sequence="sailboat")
        await host.call("save_checkpoint", frame=1)
        by_thread = [await host.answer(tool, **arguments) for tool, arguments in calls]
    assert by_process == by_thread
    assert [len(images_of(answer)) for answer in by_process] == [0, 1, 1, 0, 0]
    assert not any(answer.is_error for answer in by_process)


async def test_progress_comes_from_the_worker(tmp_path: Path, worker: WorkerProcess) -> None:
    told = Told()
    async with served(tmp_path, worker) as host:
        await host.client.call_tool("compare_to_frame", {"frame": 1}, progress_callback=told)
    assert told.steps == [(0, 2, "finding the sheet in the photos"), (1, 2, "comparing with frame 1")]


@pytest.mark.slow
async def test_a_call_that_waits_says_so_and_one_too_many_is_refused(
    tmp_path: Path, worker: WorkerProcess
) -> None:
    first, second = Told(), Told()
    worker.stop()
    async with served(tmp_path, worker, QueueLimits(waiting=1)) as host, anyio.create_task_group() as group:

        async def propose(told: Told) -> None:
            result = await host.client.call_tool("propose_actions", {"frame": 2}, progress_callback=told)
            assert not result.is_error

        group.start_soon(propose, first)
        await first.begun.wait()
        group.start_soon(propose, second)
        await second.begun.wait()
        refused = await host.refusal("check_foldability")
    assert "check_foldability would have to wait, and the queue is full (1 waiting)" in refused.lower()
    assert [step[:2] for step in second.steps] == [(0, 3), (1, 3), (2, 3)]
    assert "waiting" in (second.steps[0][2] or "")


@pytest.mark.slow
async def test_paper_is_folded_while_a_photo_is_being_explained(
    tmp_path: Path, worker: WorkerProcess
) -> None:
    told, folds = Told(), 0
    worker.stop()
    async with served(tmp_path, worker) as host, anyio.create_task_group() as group:
        other = (await host.call("open_run"))["run_id"]
        done = anyio.Event()

        async def propose() -> None:
            run_id = (await host.call("list_runs"))["runs"][-1]["run_id"]
            await host.client.call_tool(
                "propose_actions", {"frame": 2, "run_id": run_id}, progress_callback=told
            )
            done.set()

        group.start_soon(propose)
        await told.begun.wait()
        while not done.is_set():
            await host.call("fold", edge=[1, 3], direction=1, run_id=other)
            await host.call("undo", run_id=other)
            folds += not done.is_set()
    assert folds > 0


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["auto", "legacy"])
async def test_a_cancelled_call_stops_its_worker_within_a_second(
    tmp_path: Path, worker: WorkerProcess, mode: str
) -> None:
    told = Told()
    worker.stop()
    async with served(tmp_path, worker, mode=mode) as host:
        async with anyio.create_task_group() as group:

            async def propose() -> None:
                await host.client.call_tool("propose_actions", {"frame": 2}, progress_callback=told)

            group.start_soon(propose)
            await told.begun.wait()
            process = worker.process_id
            group.cancel_scope.cancel()
        assert process is not None
        assert await gone_within(1, process)
        assert (await host.call("compare_to_frame", frame=1))["verdict"]
    assert worker.process_id != process


async def test_a_worker_that_is_killed_is_told_in_one_sentence(tmp_path: Path, worker: WorkerProcess) -> None:
    told = Told()
    worker.stop()
    async with served(tmp_path, worker) as host:
        refused: list[str] = []

        async def propose() -> None:
            result = await host.client.call_tool("propose_actions", {"frame": 2}, progress_callback=told)
            assert result.is_error
            refused.append(result.content[0].text)  # type: ignore[union-attr]

        async with anyio.create_task_group() as group:
            group.start_soon(propose)
            await told.begun.wait()
            worker._process.kill()  # type: ignore[union-attr]
        assert (await host.call("compare_to_frame", frame=1))["verdict"]
    (sentence,) = refused
    assert sentence.startswith(
        "The process that computed propose_actions has ended before its answer (killed by SIGKILL)"
    )


def workers_of(server: int) -> list[int]:
    """The processes that a server has started."""
    threads = Path(f"/proc/{server}/task").iterdir()
    told = " ".join((each / "children").read_text(encoding="ascii") for each in threads)
    return [int(each) for each in told.split() if lives(int(each))]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc").exists(), reason="looks for processes as Linux tells them")
@pytest.mark.parametrize("mode", ["auto", "legacy"])
async def test_over_http_a_client_that_is_gone_frees_the_worker_and_its_time_counts(
    tmp_path: Path, mode: str
) -> None:
    options = (
        "--token-file",
        str(token_file(tmp_path, f"alice {ALICE}\n")),
        "--limit",
        "vision-seconds=0.001",
    )
    told = Told()
    with http_process(tmp_path, *options, "--vision-workers", "1", "--sequences", str(photos())) as server:
        async with bearing(ALICE) as web, anyio.create_task_group() as group:

            async def propose() -> None:
                async with Client(streamable_http_client(server.url, http_client=web), mode=mode) as client:
                    await compare_in_a_run(client, told)

            group.start_soon(propose)
            await told.begun.wait()
            (process,) = workers_of(server.process.pid)
            group.cancel_scope.cancel()
        assert await gone_within(2, process)
        async with (
            bearing(ALICE) as web,
            Client(streamable_http_client(server.url, http_client=web)) as client,
        ):
            host = Host(client)
            run_id = (await host.call("open_run", sequence="sailboat"))["run_id"]
            begun = time.monotonic()
            refused = await host.refusal("compare_to_frame", frame=1, run_id=run_id)
    assert time.monotonic() - begun < 5
    assert "seconds for alice today" in refused


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc").exists(), reason="looks for processes as Linux tells them")
async def test_a_server_that_is_told_to_end_takes_a_busy_worker_along(tmp_path: Path) -> None:
    told = Told()
    with http_process(tmp_path, "--vision-workers", "1", "--sequences", str(photos())) as server:
        async with anyio.create_task_group() as group:

            async def compare() -> None:
                with suppress(BaseExceptionGroup):  # the server goes in the middle of the call
                    async with Client(server.url) as client:
                        await compare_in_a_run(client, told)

            group.start_soon(compare)
            await told.begun.wait()
            (process,) = workers_of(server.process.pid)
            server.process.terminate()
            assert await gone_within(6, process)
    assert server.process.returncode is not None


@pytest.mark.slow
async def test_one_owner_waits_while_another_is_answered(tmp_path: Path) -> None:
    options = ["--token-file", str(token_file(tmp_path, f"alice {ALICE}\nbob {BOB}\n"))]
    options += ["--limit", "vision-at-once=1", "--limit", "vision-waiting=0", "--vision-workers", "2"]
    refused, hers, his = list[str](), Told(), Told()
    with http_process(tmp_path, *options, "--sequences", str(photos())) as server:
        async with (
            bearing(ALICE) as ada_web,
            bearing(BOB) as bob_web,
            Client(streamable_http_client(server.url, http_client=ada_web)) as ada,
            Client(streamable_http_client(server.url, http_client=bob_web)) as bob,
            anyio.create_task_group() as group,
        ):

            async def compare(client: Client, told: Told) -> None:
                run_id = (await Host(client).call("open_run", sequence="sailboat"))["run_id"]
                arguments = {"frame": 1, "run_id": run_id}
                await client.call_tool("compare_to_frame", arguments, progress_callback=told)

            group.start_soon(compare, ada, hers)
            await hers.begun.wait()
            run_id = (await Host(ada).call("open_run"))["run_id"]
            refused.append(await Host(ada).refusal("check_foldability", run_id=run_id))
            group.start_soon(compare, bob, his)
    assert "the queue is full for alice (0 waiting)" in refused[0]
    assert [step[2] for step in his.steps] == ["finding the sheet in the photos", "comparing with frame 1"]
