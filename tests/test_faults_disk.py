"""Disks that are full, folders that may not be written, files that are damaged: a sentence, and no loss."""

import os
import sqlite3
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from direct_store import DirectStore
from folding_schemas.actions import Rotate
from folding_server.errors import RunError
from folding_server.store.database import DATABASE_NAME
from pictures import write_sequence_folder
from sqlalchemy import event

pytestmark = pytest.mark.skipif(os.name != "posix", reason="limits of processes are POSIX's")

ACTING_UNTIL_REFUSED = """
import os, resource, sys
from pathlib import Path
from folding_schemas.actions import Rotate
from folding_server.errors import RunError
from folding_server.store.run_store import RunStore

folder, limit, user = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
if user:
    os.setuid(user)
if limit:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
try:
    store = RunStore.in_folder(folder)
    run_id = sys.argv[4] if len(sys.argv) > 4 else store.create().run_id
    print(run_id, flush=True)
    store.load(run_id)
    for angle in range(100_000):
        with store.change(run_id) as change:
            change.act(Rotate(angle=angle))
        print(angle, flush=True)
except RunError as refusal:
    print(refusal)
"""
NOBODY = 65534


def until_refused(folder: Path, limit: int = 0, user: int = 0, run_id: str | None = None) -> list[str]:
    """The lines of a process that acts on a run until it is refused: run id, what was answered, the refusal."""
    command = [
        sys.executable,
        "-c",
        ACTING_UNTIL_REFUSED,
        *map(str, (folder, limit, user)),
        *filter(None, [run_id]),
    ]
    finished = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert finished.stderr == ""
    assert finished.returncode == 0
    return finished.stdout.splitlines()


@pytest.mark.parametrize("limit", [150_000, 200_000, 300_001])
def test_when_no_file_can_grow_a_call_is_refused_and_what_was_answered_is_there(
    tmp_path: Path, limit: int
) -> None:
    run_id, *answered, refusal = until_refused(tmp_path, limit)
    assert "could not be written" in refusal
    assert "make room on its disk and try again" in refusal
    with DirectStore.in_folder(tmp_path) as store:
        assert answered
        assert store.load(run_id).actions == tuple(Rotate(angle=int(angle)) for angle in answered)
        assert store.act(run_id, Rotate(angle=1)).seq == len(answered) + 2
        assert store.list_runs()[0].events == len(answered) + 2


@contextmanager
def small_disk(folder: Path) -> Iterator[Path]:
    """A file system of half a megabyte, in memory. Skips the test where none can be mounted."""
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=512k", "tmpfs", str(folder)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("only the superuser of a whole system can mount a file system")
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.skipif(not Path("/proc/mounts").exists(), reason="a file system in memory is Linux's")
def test_on_a_full_disk_a_call_is_refused_and_goes_through_once_there_is_room(tmp_path: Path) -> None:
    with small_disk(tmp_path / "small") as folder:
        run_id, *answered, refusal = until_refused(folder)
        assert "could not be written (database or disk is full), so nothing was changed; make room" in refusal
        assert len(answered) > 10
        with DirectStore.in_folder(folder) as store:
            assert store.load(run_id).actions == tuple(Rotate(angle=int(angle)) for angle in answered)
        more = ["mount", "-o", "remount,size=8m", str(folder)]
        subprocess.run(more, check=True)
        with DirectStore.in_folder(folder) as store:
            assert store.act(run_id, Rotate(angle=1)).seq == len(answered) + 2


def test_when_the_disk_is_full_reading_goes_on_and_so_does_writing_once_there_is_room(tmp_path: Path) -> None:
    """SQLite's own limit stands for the disk's: the error is the same, SQLITE_FULL."""
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        pages = "PRAGMA max_page_count = 20"

        @event.listens_for(store._log._engine, "begin")
        def limit_pages(connection: object) -> None:
            connection.exec_driver_sql(pages)  # type: ignore[attr-defined]

        with pytest.raises(
            RunError, match=r"could not be written \(database or disk is full\), so nothing was changed"
        ):
            save_often(store, run_id)
        seq = store.load(run_id).seq
        assert seq > 2
        assert store.list_runs()[0].events == seq
        pages = "PRAGMA max_page_count = 100000"
        assert store.save(run_id, seq + 1, notes="n" * 5000).seq == seq + 1


def save_often(store: DirectStore, run_id: str) -> None:
    for frame in range(2, 100):
        store.save(run_id, frame, notes="n" * 5000)


@pytest.mark.skipif(os.geteuid() != 0, reason="only the superuser can become somebody who may not write")
def test_a_data_folder_that_may_only_be_read_is_refused_and_left_as_it_was(tmp_path: Path) -> None:
    data = _reachable(tmp_path)
    with DirectStore.in_folder(data) as store:
        run_id = store.create().run_id
    before = {file.name: file.read_bytes() for file in data.iterdir()}
    refusals = [until_refused(data, user=NOBODY, run_id=run_id), until_refused(data / "new", user=NOBODY)]
    assert "cannot be used" in refusals[0][-1]
    assert "cannot be made (Permission denied); choose another with --data" in refusals[1][-1]
    assert {file.name: file.read_bytes() for file in data.iterdir()} == before


LISTING = """
import os, sys
from pathlib import Path
from folding_server.frames.sequences import Library

roots = [Path(sys.argv[1])]
Library(roots).sequences()  # so that what Python loads for it is loaded before it may no longer be read
os.setuid(int(sys.argv[2]))
library = Library(roots)
print([each.name for each in library.sequences()], library.problems())
"""


@pytest.mark.skipif(os.geteuid() != 0, reason="only the superuser can become somebody who may not read")
def test_folders_that_may_not_be_read_do_not_keep_the_others_from_being_served(tmp_path: Path) -> None:
    sequences = _reachable(tmp_path)
    write_sequence_folder(sequences / "boat", [1, 2])
    write_sequence_folder(sequences / "closed", [1, 2])
    (sequences / "closed" / "frames").chmod(0o700)
    (sequences / "lost+found").mkdir(mode=0o700)
    command = [sys.executable, "-c", LISTING, str(sequences), str(NOBODY)]
    told = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout
    assert told.startswith("['boat'] [")
    assert "'closed' cannot be read (Permission denied)" in told


def _reachable(folder: Path) -> Path:
    """A folder that others may look into, and so may all above it that are the test's own."""
    common = Path(tempfile.gettempdir()).resolve()
    for each in (folder, *folder.parents):
        if each != common and each.is_relative_to(common):
            each.chmod(0o755)
    data = folder / "data"
    data.mkdir(mode=0o755)
    return data


def test_a_database_with_a_damaged_page_answers_a_sentence_and_is_not_written_over(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_ids = [store.create().run_id for _ in range(20)]
        for run_id in run_ids:
            store.save(run_id, 2, notes="n" * 5000)
    file = tmp_path / DATABASE_NAME
    damaged = bytearray(file.read_bytes())
    for page in range(2 * 4096, len(damaged), 4096):
        damaged[page : page + 100] = b"\xff" * 100
    file.write_bytes(damaged)
    with pytest.raises(
        RunError, match=r"cannot be used \(.*malformed.*\); mend it or choose another"
    ) as refusal:
        _use(tmp_path, run_ids[0])
    assert "\n" not in str(refusal.value)
    assert file.read_bytes() == bytes(damaged)


def _use(folder: Path, run_id: str) -> None:
    with DirectStore.in_folder(folder) as store:
        store.act(run_id, Rotate(angle=1))


def test_a_database_cut_off_in_the_middle_answers_a_sentence(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
    file = tmp_path / DATABASE_NAME
    file.write_bytes(file.read_bytes()[:6000])
    with pytest.raises(RunError, match=r"cannot be used \(.*(malformed|not a database)"):
        _use(tmp_path, run_id)


def test_a_server_waits_its_turn_or_says_that_another_process_writes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("folding_server.store.database.BUSY_SECONDS", 0.2)
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        other = sqlite3.connect(tmp_path / DATABASE_NAME, isolation_level=None)
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(RunError, match="is busy with another process; try again in a moment"):
            store.act(run_id, Rotate(angle=1))
        assert store.load(run_id).seq == 1
        other.execute("ROLLBACK")
        other.close()
        assert store.act(run_id, Rotate(angle=1)).seq == 2
