"""The store on a database that locks rows and not files.

``postgresql`` says how the server starts, or where another is named.
"""

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from uuid import uuid4

import pytest
from direct_store import DirectStore
from folding_schemas.actions import Rotate
from folding_server.errors import RunError
from folding_server.store.schema import EVENTS, REQUESTS, bring_up_to_date
from folding_server.store.views import RunView
from postgresql import database
from sqlalchemy import create_engine, inspect
from sqlalchemy.dialects import postgresql
from sqlalchemy.schema import CreateColumn, CreateIndex


def test_the_new_column_and_its_index_are_plain_sql() -> None:
    dialect = postgresql.dialect()
    column = CreateColumn(EVENTS.c.request_id).compile(dialect=dialect)
    assert str(column).strip() == "request_id VARCHAR(36)"
    index = str(CreateIndex(REQUESTS).compile(dialect=dialect))
    assert index == "CREATE UNIQUE INDEX folding_events_requests ON folding_events (request_id)"


@pytest.fixture
def url() -> Iterator[str]:
    """An empty database."""
    with database() as url:
        yield url


@pytest.fixture
def stores(url: str) -> Iterator[tuple[DirectStore, DirectStore]]:
    """Two stores on an empty database, as two servers have them."""
    with DirectStore(url) as first, DirectStore(url) as second:
        yield first, second


def test_threads_of_two_servers_lose_and_repeat_nothing(stores: tuple[DirectStore, DirectStore]) -> None:
    run_id = stores[0].create().run_id

    def act_often(number: int) -> list[int]:
        return [stores[number % 2].act(run_id, Rotate(angle=1), str(uuid4())).seq for _ in range(25)]

    with ThreadPoolExecutor(8) as pool:
        seen = [seq for answer in pool.map(act_often, range(8)) for seq in answer]
    assert sorted(seen) == list(range(2, 202))
    assert stores[0].load(run_id) == stores[1].load(run_id)


def test_one_request_at_two_servers_is_carried_out_once(stores: tuple[DirectStore, DirectStore]) -> None:
    opening, acting = str(uuid4()), str(uuid4())
    barrier = threading.Barrier(8)

    def ask(number: int) -> tuple[RunView, RunView]:
        store = stores[number % 2]
        barrier.wait()
        opened = store.create(request_id=opening)
        return opened, store.act(opened.run_id, Rotate(angle=1), acting)

    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(ask, range(8)))
    assert answers == [answers[0]] * 8
    assert len(stores[0].list_runs()) == 1
    assert stores[1].load(answers[0][0].run_id).seq == 2


def test_a_refusal_takes_the_event_back(stores: tuple[DirectStore, DirectStore]) -> None:
    run_id = stores[0].create().run_id
    with pytest.raises(RunError, match="no action to undo"):
        stores[0].undo(run_id)
    assert stores[0].load(run_id).seq == 1


def test_the_table_of_the_version_before_is_taken_over_by_many_at_once(
    url: str,
) -> None:
    with DirectStore(url) as store:
        run_id = store.act(store.create().run_id, Rotate(angle=1)).run_id
    engine = create_engine(url)
    with engine.begin() as connection:
        connection.exec_driver_sql("DROP TABLE folding_version, folding_runs, folding_vision")
        connection.exec_driver_sql("ALTER TABLE folding_events DROP COLUMN request_id")
    barrier = threading.Barrier(4)

    def open_and_act(_number: int) -> int:
        barrier.wait()
        with DirectStore(url) as store:
            return store.act(run_id, Rotate(angle=1), str(uuid4())).seq

    with ThreadPoolExecutor(4) as pool:
        assert sorted(pool.map(open_and_act, range(4))) == [3, 4, 5, 6]
    with engine.connect() as connection:
        assert [index["name"] for index in inspect(connection).get_indexes("folding_events")] == [
            REQUESTS.name
        ]
    engine.dispose()


def test_what_is_up_to_date_is_left_alone_while_another_writes(
    url: str, stores: tuple[DirectStore, DirectStore]
) -> None:
    """A server starts without waiting for one that is in the middle of a change."""
    engine = create_engine(url, connect_args={"options": "-c lock_timeout=1000"})
    with stores[0].change(stores[0].create().run_id) as change, engine.begin() as connection:
        change.act(Rotate(angle=1))
        bring_up_to_date(connection)
    engine.dispose()
