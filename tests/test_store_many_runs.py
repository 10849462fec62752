"""What a start and a list of runs cost does not grow with the runs that are stored: counted in SQLite's own steps."""

import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest
from folding_server.store import database
from folding_server.store.database import DATABASE_NAME
from folding_server.store.limits import OwnerLimits
from folding_server.store.run_store import RunStore
from store import fill


@pytest.fixture
def steps_of(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[], object]], int]:
    """Counts the instructions of SQLite's virtual machine that a call takes on connections it makes itself."""
    count = 0

    def one_more() -> int:
        nonlocal count
        count += 1
        return 0

    prepare = database._prepare_sqlite

    def prepare_and_count(connection: sqlite3.Connection, entry: object) -> None:
        prepare(connection, entry)  # type: ignore[arg-type]
        connection.set_progress_handler(one_more, 1)

    monkeypatch.setattr(database, "_prepare_sqlite", prepare_and_count)

    def steps(call: Callable[[], object]) -> int:
        nonlocal count
        count = 0
        call()
        return count

    return steps


def folder_with(runs: int, folder: Path) -> Path:
    """A data folder with this many runs of four owners."""
    with RunStore.in_folder(folder) as store:
        run_id = store.create(owner="owner0").run_id
    fill(folder / DATABASE_NAME, run_id, runs - 1)
    return folder


def test_start_list_and_opening_take_as_many_steps_with_many_runs_as_with_few(
    tmp_path: Path, steps_of: Callable[[Callable[[], object]], int]
) -> None:
    found = {}
    for runs in (60, 3000):
        folder = folder_with(runs, tmp_path / str(runs))
        with RunStore.in_folder(folder) as store:
            newest = store.list_runs()
            assert len(newest) == runs
            assert len(store.list_runs("owner1")) == runs // 4
            last = newest[-6].run_id
            found[runs] = [
                steps_of(lambda folder=folder: RunStore.in_folder(folder).close()),
                steps_of(lambda store=store: store.list_runs(None, 5)),
                steps_of(lambda store=store: store.list_runs("owner1", 5)),
                steps_of(lambda store=store, last=last: store.list_runs(None, 5, last)),
                steps_of(lambda store=store: store.create(owner="owner1")),
            ]
    assert min(found[60]) > 10
    for few, many in zip(found[60], found[3000], strict=True):
        assert many <= 1.5 * few


def test_counting_what_an_owner_has_is_left_to_servers_with_limits(
    tmp_path: Path, steps_of: Callable[[Callable[[], object]], int]
) -> None:
    """The count reads all runs of the owner, which the limit itself keeps few."""
    folder = folder_with(400, tmp_path)
    with RunStore.in_folder(folder) as free, RunStore.in_folder(folder, OwnerLimits(runs=1000)) as limited:
        without, counted = (
            steps_of(lambda each=each: each.create(owner="owner1")) for each in (free, limited)
        )
    assert counted > 2 * without
