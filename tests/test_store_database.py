"""The store on real files: what survives a kill, who may write at once, what a broken file answers."""

import os
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest
from direct_store import DirectStore
from folding_schemas.actions import Rotate
from folding_server.errors import RunError
from folding_server.store.database import DATABASE_NAME, database_url
from folding_server.store.views import RunView

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
        with store.change(run_id) as change:
            seq = change.act(Rotate(angle=angle)).seq
        print(seq, flush=True)
"""


def start_child(*arguments: object) -> "subprocess.Popen[str]":
    command = [sys.executable, "-c", ACTING_CHILD, *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def numbers_are_gapless(store: DirectStore, run_id: str) -> bool:
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
    with DirectStore.in_folder(tmp_path) as store:
        view = store.load(run_id)
        assert view.seq in (answered[-1], answered[-1] + 1)
        assert view.actions == tuple(Rotate(angle=angle) for angle in range(view.seq - 1))
        assert store.act(run_id, Rotate(angle=1)).seq == view.seq + 1


def test_two_processes_on_one_run_lose_and_repeat_nothing(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as store:
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
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id

        def act_often() -> list[int]:
            return [store.act(run_id, Rotate(angle=1)).seq for _ in range(20)]

        answers = together(*[act_often] * 4)
        seen = [seq for answer in answers if isinstance(answer, list) for seq in answer]
        assert sorted(seen) == list(range(2, 82))
        assert numbers_are_gapless(store, run_id)


def test_of_callers_who_saw_the_same_state_one_acts(tmp_path: Path) -> None:
    """What a caller decides on stays true until its change is recorded; the next one sees it."""
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id

        def act_if_nobody_has() -> RunView:
            with store.change(run_id) as change:
                if change.view.actions:
                    raise RunError("another has acted")
                time.sleep(0.01)
                return change.act(Rotate(angle=1))

        answers = together(*[act_if_nobody_has] * 4)
        assert sum(isinstance(answer, RunError) for answer in answers) == 3
        assert store.load(run_id).seq == 2


@pytest.mark.parametrize("runs", [1, 8])
def test_eight_threads_with_fifty_actions_each_are_all_served(tmp_path: Path, runs: int) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_ids = [store.create().run_id for _ in range(runs)]

        def act_often(run_id: str) -> int:
            return len([store.act(run_id, Rotate(angle=1)) for _ in range(50)])

        answers = together(*[partial(act_often, run_ids[thread % runs]) for thread in range(8)])
        assert answers == [50] * 8
        for run_id in run_ids:
            assert len(store.load(run_id).actions) == 400 // runs
            assert numbers_are_gapless(store, run_id)


def test_calls_with_one_request_id_at_once_are_carried_out_once(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as first, DirectStore.in_folder(tmp_path) as second:
        request = "00000000-0000-4000-8000-000000000001"
        opened = together(*[partial(store.create, request_id=request) for store in (first, second) * 2])
        assert isinstance(opened[0], RunView)
        assert opened == [opened[0]] * 4
        run_id, request = opened[0].run_id, "00000000-0000-4000-8000-000000000002"
        acted = together(
            *[partial(store.act, run_id, Rotate(angle=1), request) for store in (first, second) * 2]
        )
        assert acted == [first.load(run_id)] * 4
        assert first.load(run_id).seq == 2


def test_the_budget_holds_against_callers_in_a_race(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as first, DirectStore.in_folder(tmp_path) as second:
        run_id = first.create(sequence="cat", frames=3, budget=1).run_id
        first.save(run_id, 1)
        answers = together(*[lambda each=each: each.save(run_id, 2) for each in (first, second)])
        assert sum(isinstance(answer, RunError) for answer in answers) == 1
        assert first.load(run_id) == second.load(run_id)


def test_a_number_taken_by_another_writer_is_refused_and_can_be_tried_again(tmp_path: Path) -> None:
    """Where a database locks neither file nor row the primary key decides; here its refusal is forced once."""
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        with closing(sqlite3.connect(tmp_path / DATABASE_NAME)) as other, other:
            other.execute(
                "CREATE TRIGGER slip BEFORE INSERT ON folding_events "
                "BEGIN SELECT RAISE(ABORT, 'UNIQUE constraint failed'); END"
            )
        with pytest.raises(RunError, match="changed by another call at the same moment; try again"):
            store.act(run_id, Rotate(angle=1))
        assert store.load(run_id).seq == 1
        with closing(sqlite3.connect(tmp_path / DATABASE_NAME)) as other, other:
            other.execute("DROP TRIGGER slip")
        assert store.act(run_id, Rotate(angle=1)).seq == 2


EARLIER_TABLE = """
CREATE TABLE folding_events (
    run_id VARCHAR(40) NOT NULL, seq INTEGER NOT NULL, format INTEGER NOT NULL, time VARCHAR(40) NOT NULL,
    kind VARCHAR(16) NOT NULL, payload TEXT NOT NULL, PRIMARY KEY (run_id, seq)
)
"""
EARLIER_EVENTS = [
    (
        "20260101-000000-aaaaaaaaaa",
        1,
        1,
        "2026-01-01T00:00:00+00:00",
        "opened",
        (
            '{"sequence":null,"frames":0,"sheet":[1.0,1.0],"front_color":"white","back_color":"white",'
            '"fingerprint":null,"budget":null}'
        ),
    ),
    (
        "20260101-000000-aaaaaaaaaa",
        2,
        1,
        "2026-01-01T00:00:01+00:00",
        "acted",
        '{"action":{"action":"rotate","angle":30.0}}',
    ),
]


def write_earlier_database(folder: Path) -> str:
    """The database of a version without request ids, with a run of one action; the run's id."""
    folder.mkdir(exist_ok=True)
    connection = sqlite3.connect(folder / DATABASE_NAME)
    with connection:
        connection.execute(EARLIER_TABLE)
        connection.executemany("INSERT INTO folding_events VALUES (?, ?, ?, ?, ?, ?)", EARLIER_EVENTS)
    connection.close()
    return EARLIER_EVENTS[0][0]


def test_a_database_of_the_version_before_is_taken_over_as_it_is(tmp_path: Path) -> None:
    run_id = write_earlier_database(tmp_path)
    request = "00000000-0000-4000-8000-000000000001"
    for _ in range(2):
        with DirectStore.in_folder(tmp_path) as store:
            assert store.load(run_id).actions[:1] == (Rotate(angle=30),)
            assert store.act(run_id, Rotate(angle=60), request).seq == 3
    connection = sqlite3.connect(tmp_path / DATABASE_NAME)
    rows = connection.execute(
        "SELECT run_id, seq, format, time, kind, payload FROM folding_events"
    ).fetchall()
    connection.close()
    assert rows[:2] == EARLIER_EVENTS


def test_the_version_before_goes_on_writing_to_a_database_taken_over(tmp_path: Path) -> None:
    run_id = write_earlier_database(tmp_path)
    with DirectStore.in_folder(tmp_path) as store:
        store.load(run_id)
        columns = "run_id, seq, format, time, kind, payload"
        for seq in (3, 4):
            tamper(
                tmp_path,
                f"INSERT INTO folding_events ({columns}) "  # noqa: S608 - a number of the test's own
                f"SELECT run_id, {seq}, format, time, kind, payload FROM folding_events WHERE seq = 2",
            )
        assert store.load(run_id).actions == (Rotate(angle=30),) * 3


def test_a_database_of_the_version_before_may_be_taken_over_by_many_at_once(tmp_path: Path) -> None:
    run_id = write_earlier_database(tmp_path)
    children = [start_child(tmp_path, run_id, 2) for _ in range(4)]
    for child in children:
        child.communicate()
    assert [child.returncode for child in children] == [0] * 4
    with DirectStore.in_folder(tmp_path) as store:
        assert store.load(run_id).seq == 10


def test_stores_on_one_database_see_each_other_at_once(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as first, DirectStore.in_folder(tmp_path) as second:
        run_id = first.create().run_id
        for angle in range(3):
            assert second.act(run_id, Rotate(angle=angle)) == first.load(run_id)
            assert first.undo(run_id) == second.load(run_id)


def test_a_run_of_another_data_folder_is_unknown(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path / "a") as here, DirectStore.in_folder(tmp_path / "b") as there:
        run_id = there.create().run_id
        with pytest.raises(RunError, match=f"there is no run '{run_id}' in this data folder; call open_run"):
            here.load(run_id)


def one_sentence(refusal: pytest.ExceptionInfo[RunError]) -> str:
    text = str(refusal.value)
    assert "\n" not in text
    assert len(text) < 400
    return text


def test_a_file_that_is_no_database_is_named_and_left_alone(tmp_path: Path) -> None:
    (tmp_path / DATABASE_NAME).write_text("not a database " * 100)
    with pytest.raises(RunError, match="file is not a database") as refusal:
        DirectStore.in_folder(tmp_path)
    assert DATABASE_NAME in one_sentence(refusal)
    assert (tmp_path / DATABASE_NAME).read_text() == "not a database " * 100


def test_a_database_with_other_tables_of_our_name_is_refused(tmp_path: Path) -> None:
    connection = sqlite3.connect(tmp_path / DATABASE_NAME)
    connection.execute("CREATE TABLE folding_events (something TEXT)")
    connection.close()
    with DirectStore.in_folder(tmp_path) as store, pytest.raises(RunError, match="cannot be used") as refusal:
        store.create()
    one_sentence(refusal)


def test_a_read_only_database_is_refused(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        view = store.create()
    url = f"sqlite:///file:{tmp_path / DATABASE_NAME}?mode=ro&uri=true"
    with pytest.raises(RunError, match="readonly database") as refusal, DirectStore(url) as store:
        store.act(view.run_id, Rotate(angle=1))
    one_sentence(refusal)


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_read_only_folder_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(RunError, match="unable to open database file"):
        DirectStore.in_folder(tmp_path)


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
        DirectStore(url)
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
        ("UPDATE folding_events SET format = 3 WHERE seq = 2", "in format 3, and this server reads up to 2"),
        ("DELETE FROM folding_events", "there is no run"),
    ],
)
def test_a_record_changed_by_hand_is_refused(tmp_path: Path, statement: str, words: str) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        for angle in range(2):
            store.act(run_id, Rotate(angle=angle))
    tamper(tmp_path, statement)
    with DirectStore.in_folder(tmp_path) as store, pytest.raises(RunError, match=words) as refusal:
        store.load(run_id)
    one_sentence(refusal)


def test_a_kept_view_is_not_believed_when_its_events_are_gone(tmp_path: Path) -> None:
    with DirectStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        tamper(tmp_path, "DELETE FROM folding_events")
        with pytest.raises(RunError, match="there is no run"):
            store.act(run_id, Rotate(angle=1))
