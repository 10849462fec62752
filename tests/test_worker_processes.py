"""Jobs in processes of their own: answers, progress, stopping, and what happens when a process ends."""

import os
import signal
import subprocess
import sys
import time
import types
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import anyio
import long_work
import pytest
from folding_server.errors import PhotoError
from folding_server.workers.computing import NICENESS, WorkerThread
from folding_server.workers.job import WorkerEnded, WorkerFault, WorkerJob
from folding_server.workers.worker_pool import WorkerPool
from folding_server.workers.worker_process import WorkerProcess

pytestmark = pytest.mark.anyio
HERE = Path(__file__).parent
LONG = 60.0
"""Seconds of work that no test waits for."""


@dataclass
class Listener:
    """Who waits for a job, and what it was told."""

    told: list[str] = field(default_factory=list)
    before: list[int] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    begun: anyio.Event = field(default_factory=anyio.Event)

    async def queued(self, before: int) -> None:
        self.before.append(before)

    async def announced(self, doing: str) -> None:
        self.told.append(doing)
        self.begun.set()

    def took(self, seconds: float) -> None:
        self.seconds.append(seconds)


@pytest.fixture(scope="module")
def processes() -> Iterator[WorkerPool]:
    """Two worker processes that find the work of tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(HERE))
        pool = WorkerPool([WorkerProcess(), WorkerProcess()])
        yield pool
        pool.close()


def job(work: Callable[..., Any], *given: Any, place: str | None = None) -> WorkerJob[Any]:
    return WorkerJob(f"the tool {work.__name__}", work, given, place=place)


def lives(process: int) -> bool:
    """Whether there is such a process, and it is not over."""
    if not Path("/proc").exists():  # macOS
        return subprocess.run(["ps", "-p", str(process)], capture_output=True, check=False).returncode == 0
    try:
        state = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


async def gone_within(seconds: float, process: int) -> bool:
    with anyio.move_on_after(seconds):
        while lives(process):  # noqa: ASYNC110 - nobody else tells
            await anyio.sleep(0.01)
        return True
    return False


async def test_a_job_is_answered_with_progress_and_its_time(processes: WorkerPool) -> None:
    waiter = Listener()
    assert await processes.compute(job(long_work.add, 1, 2), waiter) == 3
    assert waiter.told == ["adding"]
    assert len(waiter.seconds) == 1
    assert 0 <= waiter.seconds[0] < 1


async def test_the_time_of_a_job_is_what_its_process_computed(processes: WorkerPool) -> None:
    waiter = Listener()
    await processes.compute(job(long_work.compute_for, 0.3), waiter)
    assert 0 < waiter.seconds[0] <= 0.4


async def test_what_a_caller_can_mend_is_raised_as_itself(processes: WorkerPool) -> None:
    with pytest.raises(PhotoError, match="the photo is blank"):
        await processes.compute(job(long_work.refuse), Listener())


async def test_a_fault_tells_where_it_was(processes: WorkerPool) -> None:
    with pytest.raises(WorkerFault, match=r"(?s)long_work\.py.*ZeroDivisionError"):
        await processes.compute(job(long_work.fail), Listener())


async def test_a_process_has_no_input_and_goes_on_after_a_job(processes: WorkerPool) -> None:
    first = await processes.compute(job(long_work.process_id), Listener())
    assert await processes.compute(job(long_work.input_left), Listener()) == b""
    assert await processes.compute(job(long_work.process_id), Listener()) == first != os.getpid()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has classes of priority instead")
async def test_a_process_gives_way_to_the_server(processes: WorkerPool) -> None:
    assert await processes.compute(job(long_work.niceness), Listener()) == os.nice(0) + NICENESS


async def test_two_jobs_are_computed_at_once_and_a_third_waits(processes: WorkerPool) -> None:
    waiters = [Listener(), Listener(), Listener()]
    found: list[int] = []

    async def computed(waiter: Listener) -> None:
        found.append(await processes.compute(job(long_work.compute_for, 0.3), waiter))

    async with anyio.create_task_group() as group:
        for waiter in waiters:
            group.start_soon(computed, waiter)
    assert [waiter.before for waiter in waiters] == [[], [], [0]]
    assert len(set(found)) == 2
    assert processes.waiting == 0


async def test_a_job_goes_to_the_process_that_has_seen_its_place(processes: WorkerPool) -> None:
    places = {"cat": set[int](), "cup": set[int]()}

    async def computed(place: str) -> None:
        found = await processes.compute(job(long_work.compute_for, 0.1, place=place), Listener())
        places[place].add(found)

    async with anyio.create_task_group() as group:
        for place in places:
            group.start_soon(computed, place)
    for place in ("cup", "cat", "cat", "cup"):
        await computed(place)
    assert [len(found) for found in places.values()] == [1, 1]
    assert places["cat"] != places["cup"]


async def test_a_cancelled_job_is_stopped_within_a_second_and_the_next_is_computed(
    processes: WorkerPool,
) -> None:
    waiter = Listener()
    async with anyio.create_task_group() as group:
        group.start_soon(processes.compute, job(long_work.compute_for, LONG), waiter)
        await waiter.begun.wait()
        process = int(waiter.told[0])
        assert lives(process)
        group.cancel_scope.cancel()
    assert await gone_within(1, process)
    assert len(waiter.seconds) == 1
    assert 0 < waiter.seconds[0] < LONG
    assert await processes.compute(job(long_work.process_id), Listener()) != process


async def test_a_cancelled_job_that_waits_is_forgotten() -> None:
    pool, waiters = WorkerPool([WorkerThread()]), [Listener(), Listener()]
    async with anyio.create_task_group() as group:
        group.start_soon(pool.compute, job(long_work.compute_for, 0.3), waiters[0])
        await waiters[0].begun.wait()
        with anyio.move_on_after(0.05) as waiting:
            await pool.compute(job(long_work.compute_for, LONG), waiters[1])
    assert waiting.cancelled_caught
    assert (waiters[1].before, waiters[1].told, waiters[1].seconds) == ([0], [], [])
    assert pool.waiting == 0
    assert await pool.compute(job(long_work.add, 1, 2), Listener()) == 3


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
async def test_a_killed_process_is_told_in_one_sentence_and_the_next_call_works(
    processes: WorkerPool,
) -> None:
    waiter = Listener()

    async def kill() -> None:
        await waiter.begun.wait()
        os.kill(int(waiter.told[0]), signal.SIGKILL)

    async with anyio.create_task_group() as group:
        group.start_soon(kill)
        with pytest.raises(
            WorkerEnded, match=r"the process that computed the tool compute_for has ended.*SIGKILL"
        ):
            await processes.compute(job(long_work.compute_for, LONG), waiter)
    assert await processes.compute(job(long_work.add, 1, 2), Listener()) == 3


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
async def test_a_process_that_was_killed_while_it_was_idle_is_started_anew(processes: WorkerPool) -> None:
    process = await processes.compute(job(long_work.process_id), Listener())
    os.kill(process, signal.SIGKILL)
    assert await gone_within(5, process)
    assert await processes.compute(job(long_work.process_id), Listener()) != process


SERVER = """
import anyio, long_work
from folding_server.workers.job import WorkerJob
from folding_server.workers.worker_pool import WorkerPool
from folding_server.workers.worker_process import WorkerProcess

class Listener:
    async def announced(self, doing):
        print(doing, flush=True)

anyio.run(WorkerPool([WorkerProcess()]).compute, WorkerJob("x", long_work.compute_for, (60,)), Listener())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
async def test_a_busy_process_ends_when_its_server_is_killed() -> None:
    process = worker_of_a_killed_server()
    assert await gone_within(2, process)


def worker_of_a_killed_server() -> int:
    """The id of a worker process that computed when its server was killed."""
    environment = {**os.environ, "PYTHONPATH": str(HERE)}
    with subprocess.Popen(
        [sys.executable, "-c", SERVER], stdout=subprocess.PIPE, text=True, env=environment
    ) as server:
        assert server.stdout is not None
        process = int(server.stdout.readline())
        assert lives(process)
        server.kill()
    return process


async def test_work_that_a_process_does_not_know_is_told_and_the_next_is_computed(
    processes: WorkerPool, monkeypatch: pytest.MonkeyPatch
) -> None:
    elsewhere = types.ModuleType("elsewhere")
    exec("def work(announce): pass", elsewhere.__dict__)  # noqa: S102 - makes a function of a module that has no file
    monkeypatch.setitem(sys.modules, "elsewhere", elsewhere)
    with pytest.raises(WorkerEnded, match=r"exit code 1"):
        await processes.compute(job(elsewhere.work), Listener())
    assert await processes.compute(job(long_work.add, 1, 2), Listener()) == 3


async def test_closing_ends_every_process() -> None:
    pool, found = WorkerPool([WorkerProcess()]), Listener()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(HERE))
        process = await pool.compute(job(long_work.process_id), found)
    begun = time.monotonic()
    pool.close()
    assert not lives(process)
    assert time.monotonic() - begun < 5
