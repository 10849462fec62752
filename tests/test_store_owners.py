"""Whose runs are whose, how they are listed, and how much an owner may have; on SQLite and on PostgreSQL."""

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from uuid import uuid4

import pytest
from direct_store import DirectStore
from folding_schemas.actions import Rotate
from folding_server.errors import ActionRefused, FoldingError, RunError
from folding_server.store.limits import OwnerLimits, parse_limits
from postgresql import empty_database


@pytest.fixture(params=["sqlite", "postgresql"])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """An empty database of either kind."""
    with empty_database(request.param, tmp_path) as made:
        yield made


@pytest.fixture
def store(url: str) -> Iterator[DirectStore]:
    with DirectStore(url) as opened:
        yield opened


def test_a_run_is_there_for_its_owner_and_for_whoever_is_nobody(store: DirectStore) -> None:
    run_id = store.create(owner="ada").run_id
    for _ in range(2):
        store.require_owner(run_id, "ada")
        store.require_owner(run_id, None)
        with pytest.raises(RunError, match=f"there is no run '{run_id}'"):
            store.require_owner(run_id, "bob")


def test_a_run_that_is_nobodys_is_no_owners(store: DirectStore) -> None:
    run_id = store.create().run_id
    store.require_owner(run_id, None)
    with pytest.raises(RunError, match=f"there is no run '{run_id}'"):
        store.require_owner(run_id, "ada")


def test_anothers_request_id_answers_nothing_of_the_run_it_opened(store: DirectStore) -> None:
    request = str(uuid4())
    opened = store.create(owner="ada", request_id=request)
    assert store.create(owner="ada", request_id=request) == opened
    for other in ("bob", None):
        with pytest.raises(RunError, match="was used by an earlier call") as refusal:
            store.create(owner=other, request_id=request)
        assert opened.run_id not in str(refusal.value)


def test_pages_of_runs_go_from_the_newest_to_the_oldest_and_miss_none(store: DirectStore) -> None:
    opened = [store.create(owner="ada" if number % 3 else "bob").run_id for number in range(30)]
    store.act(opened[0], Rotate(angle=1))
    for owner, expected in (
        (None, opened),
        ("ada", [each for number, each in enumerate(opened) if number % 3]),
        ("carol", []),
    ):
        found: list[str] = []
        while page := store.list_runs(owner, 7, found[-1] if found else None):
            assert len(page) <= 7
            found += [run.run_id for run in page]
        assert found == expected[::-1]


def test_a_page_after_a_run_of_another_is_refused(store: DirectStore) -> None:
    run_id = store.create(owner="bob").run_id
    for unknown in (run_id, "nonsense"):
        with pytest.raises(RunError, match=f"there is no run '{unknown}'"):
            store.list_runs("ada", 10, unknown)


def test_runs_of_a_sequence_as_it_was_are_found_whosever_they_are(store: DirectStore) -> None:
    fingerprint, other = "a1" * 32, "b2" * 32
    assert not store.has_runs("cat", fingerprint)
    store.create(sequence="cat", frames=3, fingerprint=fingerprint, owner="ada")
    assert store.has_runs("cat", fingerprint)
    assert not store.has_runs("cat", other)
    assert not store.has_runs("hat", fingerprint)


def test_a_list_tells_how_far_each_run_is(store: DirectStore) -> None:
    run_id = store.create(sequence="cat", frames=3, owner="ada").run_id
    store.save(run_id, 1)
    store.act(run_id, Rotate(angle=1))
    view = store.save(run_id, 2)
    (told,) = store.list_runs("ada")
    assert (told.sequence, told.frames, told.saved, told.events) == ("cat", 3, 2, 4)
    assert (told.opened, told.changed, told.owner) == (view.opened, view.changed, "ada")


def test_a_refused_change_leaves_the_list_as_it_was(store: DirectStore) -> None:
    run_id = store.create().run_id
    before = store.list_runs()

    def act_and_fail() -> None:
        with store.change(run_id) as change:
            change.act(Rotate(angle=1))
            raise ActionRefused

    with pytest.raises(ActionRefused):
        act_and_fail()
    assert store.list_runs() == before


def test_an_owner_opens_as_many_runs_as_allowed(url: str) -> None:
    with DirectStore(url, OwnerLimits(runs=2)) as store:
        request = str(uuid4())
        first = store.create(owner="ada", request_id=request)
        store.create(owner="ada")
        with pytest.raises(
            RunError, match="ada has 2 runs, and this server keeps at most 2 for an owner; go on"
        ):
            store.create(owner="ada")
        assert store.create(owner="ada", request_id=request) == first
        assert store.act(first.run_id, Rotate(angle=1)).seq == 2
        store.create(owner="bob")
        assert [store.create().seq for _ in range(3)] == [1] * 3


def test_the_limit_on_runs_holds_for_openings_at_once(url: str) -> None:
    with DirectStore(url, OwnerLimits(runs=3)) as first, DirectStore(url, OwnerLimits(runs=3)) as second:
        barrier = threading.Barrier(8)

        def opened(number: int) -> bool:
            barrier.wait()
            try:
                (first, second)[number % 2].create(owner="ada")
            except RunError:
                return False
            return True

        with ThreadPoolExecutor(8) as pool:
            assert sum(pool.map(opened, range(8))) == 3
        assert len(second.list_runs("ada")) == 3


def test_an_owner_whose_runs_take_up_what_is_allowed_records_nothing_more(url: str) -> None:
    with DirectStore(url, OwnerLimits(bytes=2000)) as store:
        run_id, request = store.create(owner="ada").run_id, str(uuid4())
        saved = store.save(run_id, 2, notes="é" * 1000, request_id=request)
        for refused in (lambda: store.act(run_id, Rotate(angle=1)), lambda: store.create(owner="ada")):
            with pytest.raises(
                RunError, match=r"the runs of ada take up 0\.002\d* MB, and .* at most 0\.002 MB"
            ):
                refused()
        assert store.load(run_id) == saved
        assert store.save(run_id, 2, notes="é" * 1000, request_id=request) == saved
        others = store.create(owner="bob").run_id
        assert store.act(others, Rotate(angle=1)).seq == 2


def test_vision_seconds_add_up_for_each_owner(url: str) -> None:
    with DirectStore(url, OwnerLimits(vision_seconds=10)) as store:
        for _ in range(3):
            store.check_vision("ada")
            store.add_vision("ada", 4)
        with pytest.raises(
            RunError, match="computed 12 seconds for ada today, and this server allows 10 a day"
        ):
            store.check_vision("ada")
        store.check_vision("bob")


def test_vision_seconds_counted_at_once_are_all_counted(url: str) -> None:
    with DirectStore(url) as first, DirectStore(url, OwnerLimits(vision_seconds=8)) as second:
        barrier = threading.Barrier(8)

        def count(number: int) -> None:
            barrier.wait()
            (first, second)[number % 2].add_vision("ada", 1)

        with ThreadPoolExecutor(8) as pool:
            list(pool.map(count, range(8)))
        with pytest.raises(RunError, match="8 seconds for ada"):
            second.check_vision("ada")


def test_limits_are_read_from_what_the_command_is_given() -> None:
    assert parse_limits([]) == OwnerLimits()
    given = ["runs=100", "megabytes=0.5", "vision-seconds=600", "vision-at-once=1", "vision-waiting=0"]
    assert parse_limits(given) == OwnerLimits(
        runs=100, bytes=500_000, vision_seconds=600, vision_at_once=1, vision_waiting=0
    )


@pytest.mark.parametrize(
    "text",
    [
        "runs",
        "runs=",
        "runs=1.5",
        "runs=-1",
        "megabytes=inf",
        "megabytes=1e305",
        "vision-seconds=nan",
        "vision-at-once=0",
        "vision-waiting=1.5",
        "hats=1",
    ],
)
def test_a_limit_that_is_none_is_refused_in_one_sentence(text: str) -> None:
    with pytest.raises(
        FoldingError,
        match=f"The limit '{text}' is not possible; give runs, megabytes, vision-seconds, vision-at-once or vision-waiting",
    ):
        parse_limits([text])


def test_a_run_id_that_is_no_text_of_unicode_is_unknown_to_owners_too(store: DirectStore) -> None:
    for call in (
        lambda: store.require_owner("x\udfffy", "alice"),
        lambda: store.list_runs("alice", 10, "x\udfffy"),
    ):
        with pytest.raises(RunError, match="there is no run"):
            call()
