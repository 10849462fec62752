"""The store on real files: what survives a kill, who may write at once, what a broken file answers."""

import os
import signal
import sqlite3
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from folding_schemas.actions import Rotate
from folding_server.errors import RunError
from folding_server.store.database import DATABASE_NAME, database_url
from folding_server.store.run_store import RunStore
from sqlalchemy import event
from sqlalchemy.exc import IntegrityError

ACTING_CHILD = """
import sys
from pathlib import Path
from folding_schemas.actions import Rotate
from folding_server.store.run_store import RunStore

with RunStore.in_folder(Path(sys.argv[1])) as store:
    run_id = sys.argv[2] if len(sys.argv) > 2 else store.create().run_id
    count = int(sys.argv[3]) if len(sys.argv) > 3 else 1_000_000
    print(run_id, flush=True)
    for angle in range(count):
        print(store.act(run_id, Rotate(angle=angle)).seq, flush=True)
"""


def start_child(*arguments: object) -> "subprocess.Popen[str]":
    command = [sys.executable, "-c", ACTING_CHILD, *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def numbers_are_gapless(store: RunStore, run_id: str) -> bool:
    events = store.history(run_id)
    return [each.seq for each in events] == list(range(1, len(events) + 1))


def test_what_was_answered_survives_kill_9(tmp_path: Path) -> None:
    child = start_child(tmp_path)
    assert child.stdout
    run_id = child.stdout.readline().strip()
    answered = [int(child.stdout.readline()) for _ in range(40)]
    os.kill(child.pid, signal.SIGKILL)
    answered += [int(line) for line in child.communicate()[0].split()]
    assert child.returncode == -signal.SIGKILL
    with RunStore.in_folder(tmp_path) as store:
        view = store.load(run_id)
        assert view.seq in (answered[-1], answered[-1] + 1)
        assert view.actions == tuple(Rotate(angle=angle) for angle in range(view.seq - 1))
        assert store.act(run_id, Rotate(angle=1)).seq == view.seq + 1


def test_two_processes_on_one_run_lose_and_repeat_nothing(tmp_path: Path) -> None:
    with RunStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        children = [start_child(tmp_path, run_id, 30) for _ in range(2)]
        answers = [[int(line) for line in child.communicate()[0].split()[1:]] for child in children]
        assert [child.returncode for child in children] == [0, 0]
        assert sorted(answers[0] + answers[1]) == list(range(2, 62))
        assert len(store.load(run_id).actions) == 60
        assert numbers_are_gapless(store, run_id)


def test_a_new_database_may_be_opened_by_many_at_once(tmp_path: Path) -> None:
    children = [start_child(tmp_path / "new", "20260101-000000-aaaaaaaaaa", 0) for _ in range(4)]
    for child in children:
        child.communicate()
    assert [child.returncode for child in children] == [0] * 4


def together(*calls: Callable[[], object]) -> list[object]:
    """What each call answers or how it is refused, all begun at the same moment."""
    barrier = threading.Barrier(len(calls))

    def one(call: Callable[[], object]) -> object:
        barrier.wait()
        try:
            return call()
        except RunError as refusal:
            return refusal

    with ThreadPoolExecutor(len(calls)) as pool:
        return list(pool.map(one, calls))


def test_threads_share_a_store_and_a_run(tmp_path: Path) -> None:
    with RunStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id

        def act_often() -> list[int]:
            return [store.act(run_id, Rotate(angle=1)).seq for _ in range(20)]

        answers = together(*[act_often] * 4)
        seen = [seq for answer in answers if isinstance(answer, list) for seq in answer]
        assert sorted(seen) == list(range(2, 82))
        assert numbers_are_gapless(store, run_id)


def test_of_callers_who_saw_the_same_state_one_acts(tmp_path: Path) -> None:
    with RunStore.in_folder(tmp_path) as store:
        view = store.create()
        answers = together(*[lambda: store.act(view.run_id, Rotate(angle=1), after=view.seq)] * 4)
        assert sum(isinstance(answer, RunError) for answer in answers) == 3
        assert store.load(view.run_id).seq == 2


def test_the_budget_holds_against_callers_in_a_race(tmp_path: Path) -> None:
    with RunStore.in_folder(tmp_path) as first, RunStore.in_folder(tmp_path) as second:
        run_id = first.create(sequence="cat", frames=3, budget=1).run_id
        first.save(run_id, 1)
        answers = together(*[lambda each=each: each.save(run_id, 2) for each in (first, second)])
        assert sum(isinstance(answer, RunError) for answer in answers) == 1
        assert first.load(run_id) == second.load(run_id)


def test_a_number_taken_by_another_writer_is_tried_again(tmp_path: Path) -> None:
    """Without SQLite's write lock the primary key decides; here its refusal is forced once."""
    with RunStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        slips = iter([True, False])

        @event.listens_for(store._log._engine, "before_cursor_execute")
        def slip_in(*arguments: object) -> None:
            statement = str(arguments[2])
            if statement.startswith("INSERT") and next(slips):
                raise IntegrityError(statement, None, sqlite3.IntegrityError("UNIQUE constraint failed"))

        assert store.act(run_id, Rotate(angle=1)).seq == 2


def test_stores_on_one_database_see_each_other_at_once(tmp_path: Path) -> None:
    with RunStore.in_folder(tmp_path) as first, RunStore.in_folder(tmp_path) as second:
        run_id = first.create().run_id
        for angle in range(3):
            assert second.act(run_id, Rotate(angle=angle)) == first.load(run_id)
            assert first.undo(run_id) == second.load(run_id)


def test_a_run_of_another_data_folder_is_unknown(tmp_path: Path) -> None:
    with RunStore.in_folder(tmp_path / "a") as here, RunStore.in_folder(tmp_path / "b") as there:
        run_id = there.create().run_id
        with pytest.raises(RunError, match=f"there is no run '{run_id}' in this data folder; call open_run"):
            here.load(run_id)


def test_sqlite_is_durable_by_default(tmp_path: Path) -> None:
    with RunStore.in_folder(tmp_path) as store, store._log._engine.connect() as connection:
        assert connection.exec_driver_sql("PRAGMA journal_mode").scalar() == "wal"
        assert connection.exec_driver_sql("PRAGMA synchronous").scalar() == 2


def one_sentence(refusal: pytest.ExceptionInfo[RunError]) -> str:
    text = str(refusal.value)
    assert "\n" not in text
    assert len(text) < 400
    return text


def test_a_file_that_is_no_database_is_named_and_left_alone(tmp_path: Path) -> None:
    (tmp_path / DATABASE_NAME).write_text("not a database " * 100)
    with pytest.raises(RunError, match="file is not a database") as refusal:
        RunStore.in_folder(tmp_path)
    assert DATABASE_NAME in one_sentence(refusal)
    assert (tmp_path / DATABASE_NAME).read_text() == "not a database " * 100


def test_a_database_with_other_tables_of_our_name_is_refused(tmp_path: Path) -> None:
    connection = sqlite3.connect(tmp_path / DATABASE_NAME)
    connection.execute("CREATE TABLE folding_events (something TEXT)")
    connection.close()
    with RunStore.in_folder(tmp_path) as store, pytest.raises(RunError, match="cannot be used") as refusal:
        store.create()
    one_sentence(refusal)


def test_a_read_only_database_is_refused(tmp_path: Path) -> None:
    with RunStore.in_folder(tmp_path) as store:
        view = store.create()
    url = f"sqlite:///file:{tmp_path / DATABASE_NAME}?mode=ro&uri=true"
    with pytest.raises(RunError, match="readonly database") as refusal, RunStore(url) as store:
        store.act(view.run_id, Rotate(angle=1))
    one_sentence(refusal)


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_read_only_folder_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(RunError, match="unable to open database file"):
        RunStore.in_folder(tmp_path)


def test_a_data_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "data").write_text("")
    with pytest.raises(RunError, match=r"the data folder .* cannot be made .*--data") as refusal:
        database_url(tmp_path / "data")
    one_sentence(refusal)


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("nonsense", "is not a database URL"),
        ("postgres:/me:secret@host", "is not a database URL"),
        ("oracle2://me:secret@host/runs", "cannot be reached"),
        ("sqlite:////nowhere/at/all.sqlite3", "unable to open database file"),
    ],
)
def test_a_bad_database_url_is_refused_without_telling_its_password(url: str, words: str) -> None:
    with pytest.raises(RunError, match=words) as refusal:
        RunStore(url)
    assert "secret" not in one_sentence(refusal)


def tamper(folder: Path, statement: str) -> None:
    connection = sqlite3.connect(folder / DATABASE_NAME)
    with connection:
        connection.execute(statement)
    connection.close()


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("UPDATE folding_events SET payload = '{' WHERE seq = 2", "damaged at event 2"),
        ("UPDATE folding_events SET payload = '[]' WHERE seq = 2", "damaged at event 2"),
        ("UPDATE folding_events SET kind = 'danced' WHERE seq = 2", "damaged at event 2"),
        (
            (
                "UPDATE folding_events SET kind = 'opened', "
                "payload = (SELECT payload FROM folding_events WHERE seq = 1) WHERE seq = 2"
            ),
            r"damaged: event 2 \(opened\)",
        ),
        ("DELETE FROM folding_events WHERE seq = 1", "damaged: event 2 comes first"),
        ("DELETE FROM folding_events WHERE seq = 2", "damaged: event 3 follows event 1"),
        (
            "UPDATE folding_events SET kind = 'restored', payload = '{\"frame\": 7}' WHERE seq = 2",
            r"damaged: event 2 \(restored\) speaks of what is not there",
        ),
        ("UPDATE folding_events SET format = 2 WHERE seq = 2", "in format 2, and this server reads up to 1"),
        ("DELETE FROM folding_events", "there is no run"),
    ],
)
def test_a_record_changed_by_hand_is_refused(tmp_path: Path, statement: str, words: str) -> None:
    with RunStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        for angle in range(2):
            store.act(run_id, Rotate(angle=angle))
    tamper(tmp_path, statement)
    with RunStore.in_folder(tmp_path) as store, pytest.raises(RunError, match=words) as refusal:
        store.load(run_id)
    one_sentence(refusal)


def test_a_kept_view_is_not_believed_when_its_events_are_gone(tmp_path: Path) -> None:
    with RunStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        tamper(tmp_path, "DELETE FROM folding_events")
        with pytest.raises(RunError, match="there is no run"):
            store.act(run_id, Rotate(angle=1))
