"""Calls that take about a millisecond are carried out in the event loop, in a thread where they would have to wait, and on the
disk before they are answered."""

import sqlite3
import threading
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, closing, contextmanager
from pathlib import Path

import anyio
import anyio.to_thread
import pytest
from folding_schemas.actions import Rotate
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.server import FoldingServer
from folding_server.mcp.services import replay_cache
from folding_server.simulator import apply
from folding_server.store import log_sync
from folding_server.store.database import DATABASE_NAME
from hosts import Host
from mcp import Client
from test_store_log_sync import SyncedDisk, log_of

pytestmark = pytest.mark.anyio

HOSTS = 12
"""Hosts at once, each with a run of its own."""
TURNS = 15
"""Calls of each of them."""


@asynccontextmanager
async def served(folder: Path) -> AsyncIterator[tuple[AppContext, Host]]:
    """A server whose tools have loaded what they need, as after their first calls."""
    with AppContext(ServerSettings(folder)) as app:
        async with Client(FoldingServer(app)) as client:
            host = Host(client)
            await host.call("open_run")
            await host.call("rotate", angle=1)
            await host.call("get_current_state")
            yield app, host


@pytest.fixture
def folding_threads(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The threads in which actions were applied, in order."""
    threads: list[int] = []

    def noting(*given: object) -> object:
        threads.append(threading.get_ident())
        return apply(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(replay_cache, "apply", noting)
    return threads


@contextmanager
def writing_elsewhere(folder: Path) -> Iterator[sqlite3.Connection]:
    """Another process's transaction, which has SQLite's write lock."""
    with closing(sqlite3.connect(folder / DATABASE_NAME, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        yield other


async def test_a_fold_on_a_small_paper_needs_no_thread(tmp_path: Path, folding_threads: list[int]) -> None:
    async with served(tmp_path) as (_, host):
        folding_threads.clear()
        await host.call("rotate", angle=2)
        await host.call("rotate", angle=3)
    assert folding_threads == [threading.get_ident()] * 2


async def test_the_first_call_of_a_tool_and_a_replay_are_a_threads(
    tmp_path: Path, folding_threads: list[int]
) -> None:
    async with served(tmp_path) as (app, host):
        assert threading.get_ident() not in folding_threads
        await host.call("rotate", angle=2)
        app.replays = replay_cache.ReplayCache()
        folding_threads.clear()
        state = await host.call("rotate", angle=3)
    assert len(folding_threads) == 3
    assert threading.get_ident() not in folding_threads
    assert len(state["state"]["faces"]) == 1


async def test_a_large_paper_is_folded_in_a_thread(
    tmp_path: Path, folding_threads: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(replay_cache, "BRIEF_FACES", 0)
    async with served(tmp_path) as (_, host):
        folding_threads.clear()
        await host.call("rotate", angle=2)
    assert threading.get_ident() not in folding_threads


async def test_a_run_that_is_not_at_hand_is_read_and_folded_once(tmp_path: Path) -> None:
    async with served(tmp_path) as (app, host):
        app.store.forget()
        await host.call("rotate", angle=2)
        assert [action.angle for action in app.run(None).actions if isinstance(action, Rotate)] == [1, 2]


async def test_while_another_process_writes_a_call_waits_and_the_loop_goes_on(tmp_path: Path) -> None:
    async with served(tmp_path) as (app, host):
        with writing_elsewhere(tmp_path) as other:
            async with anyio.create_task_group() as group:
                group.start_soon(lambda: host.call("rotate", angle=2))
                await anyio.sleep(0.1)
                read = await host.call("get_current_state")
                assert len(app.run(None).actions) == 1
                other.execute("ROLLBACK")
        assert read["state"]
        assert len(app.run(None).actions) == 2


async def test_while_a_thread_of_the_process_writes_a_call_waits_and_the_loop_goes_on(tmp_path: Path) -> None:
    async with served(tmp_path) as (app, host):
        own, other = app.run(None).run_id, app.store.create().run_id
        begun, go_on = threading.Event(), threading.Event()

        def change_slowly() -> None:
            with app.store.change(other) as change:
                change.act(Rotate(angle=5))
                begun.set()
                assert go_on.wait(20)

        async with anyio.create_task_group() as group:
            group.start_soon(anyio.to_thread.run_sync, change_slowly)
            await anyio.to_thread.run_sync(begun.wait)
            group.start_soon(lambda: host.call("rotate", angle=2, run_id=own))
            await host.call("get_current_state", run_id=own)
            assert len(app.run(own).actions) == 1
            go_on.set()
        assert len(app.run(own).actions) == 2
        assert len(app.run(other).actions) == 1


async def test_what_is_refused_changes_nothing_and_the_next_call_goes_through(tmp_path: Path) -> None:
    async with served(tmp_path) as (app, host):
        before = app.run(None)
        assert "vertex" in await host.refusal("fold", edge=[1, 99], direction=1)
        assert app.run(None) == before
        await host.call("fold", edge=[1, 3], direction=1)
        assert app.run(None).seq == before.seq + 1


async def test_what_is_answered_is_on_the_disk_and_one_sync_serves_all_that_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk = SyncedDisk()
    monkeypatch.setattr(log_sync, "_sync", disk.sync)
    async with served(tmp_path) as (app, host):
        runs = [(await host.call("open_run"))["run_id"] for _ in range(HOSTS)]
        before = disk.syncs

        async def turn(run_id: str) -> None:
            for angle in range(TURNS):
                answer = await host.call("rotate", angle=angle, run_id=run_id)
                assert answer["run_id"] == run_id
                assert disk.on_disk[log_of(tmp_path).stat().st_ino]

        async with anyio.create_task_group() as group:
            for run_id in runs:
                group.start_soon(turn, run_id)
        assert disk.holds(log_of(tmp_path))
        assert disk.syncs - before < HOSTS * TURNS / 2
        expected = [Rotate(angle=angle) for angle in range(TURNS)]
        assert all(list(app.run(run_id).actions) == expected for run_id in runs)


async def test_a_disk_that_cannot_be_synced_is_told_to_every_call_that_waits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_file: int) -> None:
        raise OSError(5, "Input/output error")

    async with served(tmp_path) as (_, host):
        told: list[str] = []

        async def turn(angle: float) -> None:
            told.append(await host.refusal("rotate", angle=angle))

        with monkeypatch.context() as patched:
            patched.setattr(log_sync, "_sync", broken)
            async with anyio.create_task_group() as group:
                for angle in range(3):
                    group.start_soon(turn, angle)
        assert len(told) == 3
        assert all("could not be synced (Input/output error)" in each for each in told)
        await host.call("rotate", angle=9)
