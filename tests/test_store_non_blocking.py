"""Changes that may not wait: they take the lock at once or not at all, and leave nothing behind that was not committed."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from direct_store import DirectStore
from folding_schemas.actions import Rotate
from folding_server.errors import RunError
from folding_server.store.database import DATABASE_NAME
from folding_server.store.non_blocking import WouldBlock, has_changed, may_block, non_blocking
from folding_server.store.run_store import RunStore


def test_a_call_that_has_changed_something_may_wait() -> None:
    assert may_block()
    with non_blocking():
        assert not may_block()
        has_changed()
        assert may_block()
    assert may_block()


def test_a_change_that_may_not_wait_is_recorded_as_any_other(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        with non_blocking():
            store.act(run_id, Rotate(angle=1))
            assert may_block()
        with non_blocking():
            assert store.load(run_id).actions == (Rotate(angle=1),)
            assert not may_block()
        store.act(run_id, Rotate(angle=2))
        with non_blocking():
            assert store.act(run_id, Rotate(angle=3)).seq == 4
    with RunStore.in_folder(tmp_path) as later:
        assert later.load(run_id).actions == tuple(Rotate(angle=angle) for angle in (1, 2, 3))
        assert later.list_runs()[0].events == 4


def test_a_refused_change_is_rolled_back_and_the_next_goes_through(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        with non_blocking(), pytest.raises(RunError, match="no action to undo"):
            store.undo(run_id)
        with non_blocking(), pytest.raises(ZeroDivisionError), store.change(run_id) as change:
            change.act(Rotate(angle=1 / 0 if change.act(Rotate(angle=1)) else 0))
        with non_blocking():
            assert store.load(run_id).seq == 1
            assert store.act(run_id, Rotate(angle=2)).seq == 2


@pytest.mark.parametrize("lock", ["BEGIN IMMEDIATE", "BEGIN EXCLUSIVE"])
def test_a_lock_of_another_process_is_not_waited_for(tmp_path: Path, lock: str) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        with closing(sqlite3.connect(tmp_path / DATABASE_NAME, isolation_level=None)) as other:
            other.execute(lock)
            with non_blocking(), pytest.raises(WouldBlock):
                store.act(run_id, Rotate(angle=1))
            with non_blocking():
                assert store.load(run_id).seq == 1
            other.execute("ROLLBACK")
        with non_blocking():
            assert store.act(run_id, Rotate(angle=1)).seq == 2


def test_a_run_that_would_have_to_be_read_whole_is_not(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        store.forget()
        with non_blocking(), pytest.raises(WouldBlock):
            store.load(run_id)
        store.load(run_id)
        with non_blocking():
            assert store.load(run_id).run_id == run_id


def test_another_process_change_is_seen(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as store, DirectStore.in_folder(tmp_path) as other:
        run_id = store.create().run_id
        with non_blocking():
            store.act(run_id, Rotate(angle=1))
        other.act(run_id, Rotate(angle=2))
        with non_blocking():
            assert store.act(run_id, Rotate(angle=3)).actions == tuple(Rotate(angle=a) for a in (1, 2, 3))


def test_a_database_in_memory_has_no_connection_that_may_not_wait() -> None:
    with DirectStore("sqlite://") as store:
        run_id = store.create().run_id
        with non_blocking(), pytest.raises(WouldBlock):
            store.act(run_id, Rotate(angle=1))
        assert store.load(run_id).seq == 1


def test_after_the_database_failed_the_next_call_connects_anew(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        with closing(sqlite3.connect(tmp_path / DATABASE_NAME)) as other, other:
            other.execute("ALTER TABLE folding_events RENAME TO lost")
        with non_blocking(), pytest.raises(RunError, match="cannot be used"):
            store.act(run_id, Rotate(angle=1))
        with closing(sqlite3.connect(tmp_path / DATABASE_NAME)) as other, other:
            other.execute("ALTER TABLE lost RENAME TO folding_events")
        with non_blocking():
            assert store.act(run_id, Rotate(angle=2)).actions == (Rotate(angle=2),)
