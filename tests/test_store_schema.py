"""Versions of the store's tables: new ones, earlier ones that are brought up to date, later ones that are refused."""

import subprocess
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest
from alembic.config import Config
from alembic.script import ScriptDirectory
from direct_store import DirectStore
from folding_schemas.actions import Rotate
from folding_server.errors import RunError
from folding_server.store.schema import REVISIONS, VERSION
from postgresql import empty_database
from sqlalchemy import Engine, create_engine, inspect

OPENED = (
    '{"sequence":"cat","frames":3,"sheet":[1.0,1.0],"front_color":"white","back_color":"white",'
    '"fingerprint":"abc","budget":5}'
)
EARLIER_TABLE = """
CREATE TABLE folding_events (
    run_id VARCHAR(40) NOT NULL, seq INTEGER NOT NULL, format INTEGER NOT NULL, time VARCHAR(40) NOT NULL,
    kind VARCHAR(16) NOT NULL, payload TEXT NOT NULL, PRIMARY KEY (run_id, seq)
)
"""
REQUEST_IDS = (
    "ALTER TABLE folding_events ADD COLUMN request_id VARCHAR(36)",
    "CREATE UNIQUE INDEX folding_events_requests ON folding_events (request_id)",
)
EARLIER = {REVISIONS[0]: (EARLIER_TABLE,), REVISIONS[1]: (EARLIER_TABLE, *REQUEST_IDS)}
"""How the versions that did not say their version made their tables."""

RUN, SECOND_RUN = "20260101-000000-aaaaaaaaaa", "20260101-000001-aaaaaaaaaa"
EVENTS = [
    (RUN, 1, "2026-01-01T00:00:00+00:00", "opened", OPENED),
    (RUN, 2, "2026-01-01T00:00:01.500000+00:00", "saved", '{"frame":1,"notes":null}'),
    (RUN, 3, "2026-01-01T00:00:02+00:00", "saved", '{"frame":2,"notes":"größer"}'),
    (SECOND_RUN, 1, "2026-01-01T00:00:01+00:00", "opened", OPENED),
]


@pytest.fixture(params=["sqlite", "postgresql"])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """An empty database of either kind."""
    with empty_database(request.param, tmp_path) as made:
        yield made


def write(url: str, *statements: str) -> None:
    """Carry out statements behind the store's back."""
    engine = create_engine(url)
    with engine.begin() as connection:
        for statement in statements:
            connection.exec_driver_sql(statement)
    engine.dispose()


def insertion(run_id: str, seq: int, time: str, kind: str, payload: str) -> str:
    """How the first version records an event."""
    values = f"('{run_id}', {seq}, 1, '{time}', '{kind}', '{payload}')"
    columns = "run_id, seq, format, time, kind, payload"
    return f"INSERT INTO folding_events ({columns}) VALUES {values}"  # noqa: S608 - the test's own


def tables(url: str) -> dict[str, object]:
    """Columns, keys and indexes of all tables."""
    engine = create_engine(url)
    try:
        return described(engine)
    finally:
        engine.dispose()


def described(engine: Engine) -> dict[str, object]:
    found = inspect(engine)
    return {
        table: (
            [
                (column["name"], str(column["type"]), column["nullable"])
                for column in found.get_columns(table)
            ],
            found.get_pk_constraint(table)["constrained_columns"],
            sorted(
                (str(each["name"]), each["column_names"], each["unique"]) for each in found.get_indexes(table)
            ),
        )
        for table in sorted(found.get_table_names())
    }


def version_of(url: str) -> list[str]:
    engine = create_engine(url)
    with engine.connect() as connection:
        found = [str(row[0]) for row in connection.exec_driver_sql("SELECT version_num FROM folding_version")]
    engine.dispose()
    return found


def test_alembic_knows_the_same_versions() -> None:
    settings = Config()
    settings.set_main_option("script_location", "folding_server.store:migrations")
    steps = ScriptDirectory.from_config(settings).walk_revisions()
    assert tuple(step.revision for step in steps) == REVISIONS[::-1]


@pytest.mark.parametrize("version", EARLIER)
def test_what_earlier_versions_made_becomes_what_is_made_anew(url: str, version: str) -> None:
    write(url, *EARLIER[version])
    before = tables(url)
    DirectStore(url).close()
    changed = tables(url)
    assert changed != before
    assert version_of(url) == [VERSION]
    write(url, *[f"DROP TABLE {table}" for table in changed])
    DirectStore(url).close()
    assert tables(url) == changed
    assert version_of(url) == [VERSION]


@pytest.mark.parametrize("version", EARLIER)
def test_runs_of_earlier_versions_are_listed_and_go_on(url: str, version: str) -> None:
    write(url, *EARLIER[version], *[insertion(*event) for event in EVENTS])
    with DirectStore(url) as store:
        second, first = store.list_runs()
        assert (first.run_id, second.run_id) == (RUN, SECOND_RUN)
        assert (first.sequence, first.frames, first.saved, first.events, first.owner) == (
            "cat",
            3,
            2,
            3,
            None,
        )
        assert first.opened == datetime(2026, 1, 1, tzinfo=UTC)
        assert first.changed == datetime(2026, 1, 1, 0, 0, 2, tzinfo=UTC)
        assert (second.saved, second.events) == (0, 1)
        assert store.load(RUN).checkpoints[2].notes == "größer"
        store.act(RUN, Rotate(angle=1))
        assert store.list_runs()[1].events == 4


def test_a_run_that_an_earlier_server_opens_later_is_listed_from_its_next_change_on(url: str) -> None:
    with DirectStore(url) as store:
        write(url, insertion(*EVENTS[0]), insertion(*EVENTS[1]))
        assert store.list_runs() == []
        store.save(RUN, 2)
        (listed,) = store.list_runs()
    assert (listed.run_id, listed.events, listed.saved) == (RUN, 3, 2)


@pytest.mark.parametrize("payload", ["{", "[]", "{}"])
def test_a_damaged_record_does_not_keep_the_others_from_being_brought_up_to_date(
    url: str, payload: str
) -> None:
    damaged = (SECOND_RUN, 1, EVENTS[0][2], "opened", payload)
    write(url, EARLIER_TABLE, *[insertion(*event) for event in (*EVENTS[:3], damaged)])
    with DirectStore(url) as store:
        assert [run.run_id for run in store.list_runs()] == [RUN]
        with pytest.raises(RunError, match="damaged at event 1"):
            store.load(SECOND_RUN)


def test_a_database_that_cannot_be_brought_up_to_date_stays_as_it_was(url: str) -> None:
    write(url, EARLIER_TABLE, insertion(*EVENTS[0]), "CREATE TABLE folding_runs (other TEXT)")
    before = tables(url)
    with pytest.raises(RunError, match="folding_runs.*already exists"):
        DirectStore(url)
    assert tables(url) == before


def test_the_tables_of_a_later_version_are_refused(url: str) -> None:
    DirectStore(url).close()
    write(url, "UPDATE folding_version SET version_num = '0999'")
    with pytest.raises(
        RunError, match=f"tables of version 0999, and this server knows versions up to {VERSION}; use a"
    ):
        DirectStore(url)


LOADED = """
import sys
from pathlib import Path
from folding_server.store.run_store import RunStore
for _ in range(2):
    RunStore.in_folder(Path(sys.argv[1])).close()
print("alembic" in sys.modules)
"""


def test_alembic_is_loaded_for_earlier_versions_alone(tmp_path: Path) -> None:
    def loads_it(folder: Path) -> str:
        command = [sys.executable, "-c", LOADED, str(folder)]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()

    (tmp_path / "earlier").mkdir()
    write(f"sqlite:///{tmp_path / 'earlier' / 'runs.sqlite3'}", EARLIER_TABLE)
    assert [loads_it(tmp_path / "new"), loads_it(tmp_path / "earlier")] == ["False", "True"]
