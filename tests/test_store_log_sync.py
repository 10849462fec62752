"""What is answered is on the disk: SQLite's log is synced once for all who wait, after their commits and before their answers."""

import os
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import anyio
import anyio.to_thread
import pytest
from direct_store import DirectStore
from folding_schemas.actions import Rotate
from folding_server.errors import RunError
from folding_server.store import log_sync
from folding_server.store.database import DATABASE_NAME
from folding_server.store.log_sync import LogSync


class SyncedDisk:
    """Counts the syncs of files, and remembers each file as it was when its last sync began."""

    def __init__(self) -> None:
        self.on_disk: dict[int, bytes] = {}
        self.syncs = 0
        self.before: Callable[[], None] = lambda: None

    def sync(self, file: int) -> None:
        """Sync a file, after whatever is to happen first."""
        self.before()
        found = os.fstat(file)
        self.on_disk[found.st_ino] = os.pread(file, found.st_size, 0)
        self.syncs += 1
        os.fsync(file)

    def holds(self, path: Path) -> bool:
        """Whether all that a file holds now has been synced."""
        return self.on_disk.get(path.stat().st_ino) == path.read_bytes()


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> SyncedDisk:
    synced = SyncedDisk()
    monkeypatch.setattr(log_sync, "_sync", synced.sync)
    return synced


def log_of(folder: Path) -> Path:
    return folder / f"{DATABASE_NAME}-wal"


def test_sqlite_is_durable_by_default(tmp_path: Path, disk: SyncedDisk) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        with store._log._engine.connect() as connection:
            assert connection.exec_driver_sql("PRAGMA journal_mode").scalar() == "wal"
            assert (
                connection.exec_driver_sql("PRAGMA synchronous").scalar() == 1
            )  # the log; syncs of it are ours
        run_id = store.create().run_id
        assert disk.holds(log_of(tmp_path))
        for angle in range(3):
            store.act(run_id, Rotate(angle=angle))
            assert disk.holds(log_of(tmp_path))


def test_a_database_without_a_log_is_synced_by_sqlite() -> None:
    with DirectStore("sqlite://") as store, store._log._engine.connect() as connection:
        assert connection.exec_driver_sql("PRAGMA synchronous").scalar() == 2


def test_a_reader_waits_for_what_it_may_have_read(tmp_path: Path, disk: SyncedDisk) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        seen: list[tuple[int, bool]] = []
        reader = threading.Thread(
            target=lambda: seen.append((store.load(run_id).seq, disk.holds(log_of(tmp_path))))
        )

        def read_meanwhile() -> None:
            disk.before = lambda: None
            reader.start()
            reader.join(0.3)
            assert seen == []

        disk.before = read_meanwhile
        store.act(run_id, Rotate(angle=1))
        reader.join()
    assert seen == [(2, True)]


def test_reading_what_is_on_the_disk_syncs_nothing(tmp_path: Path, disk: SyncedDisk) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        before = disk.syncs
        for _ in range(5):
            store.load(run_id)
        assert disk.syncs == before


def test_writers_at_once_share_syncs(tmp_path: Path, disk: SyncedDisk) -> None:
    """While the first is synced the other seven commit; the next sync is for all of them."""
    with DirectStore.in_folder(tmp_path) as store, ThreadPoolExecutor(8) as pool:
        run_ids = [store.create().run_id for _ in range(8)]
        sync, before = store._log._log_sync, disk.syncs
        assert sync is not None
        all_of_them = sync._ended + 8

        def until_all_have_committed() -> None:
            deadline = time.monotonic() + 20
            while sync._ended < all_of_them and time.monotonic() < deadline:
                time.sleep(0.01)

        disk.before = until_all_have_committed
        assert [
            view.seq for view in pool.map(lambda run_id: store.act(run_id, Rotate(angle=1)), run_ids)
        ] == [2] * 8
        assert disk.syncs - before == 2
        assert disk.holds(log_of(tmp_path))


def test_a_sync_that_began_before_a_commit_does_not_answer_for_it(tmp_path: Path, disk: SyncedDisk) -> None:
    log = tmp_path / "log"
    log.write_bytes(b"")
    sync = LogSync(log)

    def add(what: bytes) -> None:
        with sync.adding(), log.open("ab") as file:
            file.write(what)

    add(b"one")
    began, go_on = threading.Event(), threading.Event()

    def hold() -> None:
        began.set()
        go_on.wait(5)

    disk.before = hold
    first = threading.Thread(target=sync.wait)
    first.start()
    assert began.wait(5)
    disk.before = lambda: None
    add(b"two")
    go_on.set()
    sync.wait()
    first.join()
    assert disk.holds(log)


def test_a_disk_that_refuses_to_sync_is_told_in_a_sentence(tmp_path: Path, disk: SyncedDisk) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id

        def refuse() -> None:
            raise OSError(5, "Input/output error")

        disk.before = refuse
        with pytest.raises(
            RunError, match=r"could not be synced \(Input/output error\).*see with get_run"
        ) as refusal:
            store.act(run_id, Rotate(angle=1))
        assert "\n" not in str(refusal.value)
        disk.before = lambda: None
        assert store.load(run_id).seq == 2
        assert disk.holds(log_of(tmp_path))


@pytest.mark.anyio
async def test_in_an_event_loop_a_sync_serves_all_that_wait_also_if_who_asked_for_it_gives_up(
    tmp_path: Path, disk: SyncedDisk
) -> None:
    log = tmp_path / "log"
    log.write_bytes(b"a commit")
    sync = LogSync(log)
    with sync.adding():
        pass
    held, go_on = threading.Event(), threading.Event()

    def hold() -> None:
        held.set()
        assert go_on.wait(20)

    disk.before = hold
    done: list[int] = []

    async def wait(number: int) -> None:
        await sync.wait_in_loop()
        done.append(number)

    async with anyio.create_task_group() as others, anyio.create_task_group() as asking:
        asking.start_soon(wait, 0)
        await anyio.to_thread.run_sync(held.wait)
        for number in (1, 2, 3):
            others.start_soon(wait, number)
        await anyio.sleep(0.01)
        asking.cancel_scope.cancel()
        go_on.set()
    assert {1, 2, 3} <= set(done)
    assert disk.syncs <= 2
    assert disk.holds(log)
