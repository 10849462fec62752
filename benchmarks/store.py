"""Measure what a call to the event store costs: ``python benchmarks/store.py`` prints one JSON document.

A run of ``--events`` events in a SQLite file (WAL, synced before each answer) is loaded and acted on with the
store's kept views and, in the same process and alternating with it, by a store that has forgotten them. All
times are in milliseconds; ``bare commit`` is one equally durable SQLite insert on an open connection, for
comparison. Opening the database and listing a page of its runs are measured with a few and with ``--runs`` runs stored.
"""

import argparse
import json
import sqlite3
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from uuid import uuid4

from folding_schemas.actions import Rotate
from folding_server.store.database import DATABASE_NAME
from folding_server.store.run_store import RunStore
from folding_server.store.views import RunView

ACTIONS_PER_FRAME = 20
FEW_RUNS = 10
PAGE = 50
"""Runs in a page of the list."""


def main() -> None:
    """Run the benchmark and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--events", type=int, default=2000, help="events in the run (default 2000)")
    parser.add_argument("--calls", type=int, default=40, help="calls measured of each kind (default 40)")
    parser.add_argument("--runs", type=int, default=10_000, help="runs stored for the list (default 10000)")
    parser.add_argument("--data", type=Path, help="measure in this folder (default: a temporary one)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.data) as folder:
        figures = measure(Path(folder), options.events, options.calls)
        for runs in (FEW_RUNS, options.runs):
            figures[f"milliseconds with {runs} runs"] = listing(Path(folder) / str(runs), runs, options.calls)
    json.dump(figures, sys.stdout, indent=2)
    sys.stdout.write("\n")


def measure(folder: Path, events: int, calls: int) -> dict[str, object]:
    """Times in milliseconds of the store's calls on a run of this many events."""
    with (
        RunStore.in_folder(folder) as store,
        RunStore.in_folder(folder) as forgetful,
        closing(bare_table(folder / "bare.sqlite3")) as bare,
    ):
        view = long_run(store, events)
        samples: dict[str, list[float]] = {}
        for _ in range(calls):
            for name, call in calls_on(store, forgetful, view.run_id, bare).items():
                samples.setdefault(name, []).append(milliseconds(call))
        return {
            "events": events,
            "calls": calls,
            "milliseconds": {name: summary(times) for name, times in samples.items()},
        }


def listing(folder: Path, runs: int, calls: int) -> dict[str, dict[str, float]]:
    """Times in milliseconds of opening a database with this many runs, of four owners, and of listing its newest and oldest."""
    with RunStore.in_folder(folder) as store:
        oldest = store.create(owner="owner0").run_id
    fill(folder / DATABASE_NAME, oldest, runs - 1)
    samples: dict[str, list[float]] = {}
    for _ in range(calls):
        samples.setdefault("open", []).append(milliseconds(lambda: RunStore.in_folder(folder).close()))
        with RunStore.in_folder(folder) as store:
            for name, call in listings(store).items():
                samples.setdefault(name, []).append(milliseconds(call))
    return {name: summary(times) for name, times in samples.items()}


def listings(store: RunStore) -> dict[str, Callable[[], object]]:
    """The lists to measure, by name."""
    last = store.list_runs()[-2].run_id
    return {
        "newest of all": lambda: store.list_runs(None, PAGE),
        "newest of an owner": lambda: store.list_runs("owner0", PAGE),
        "oldest of all": lambda: store.list_runs(None, PAGE, last),
        "create": lambda: store.create(owner="owner0"),
    }


def copy_id(number: int) -> str:
    """The id of a copy of a run; ids sort as their numbers do."""
    return "20990101-000000-" + f"{number:010d}".translate(str.maketrans("0123456789", "abcdefghij"))


def fill(database: Path, run_id: str, copies: int) -> None:
    """Add copies of a run under other ids, opened later, by four owners in turn."""
    connection = sqlite3.connect(database)
    numbered = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < ?) INSERT INTO"
    opened = "copy_id(i)"
    time_of = "strftime('%Y-%m-%dT%H:%M:%S.000000+00:00', '2099-01-01', i || ' seconds')"
    with closing(connection), connection:
        connection.create_function("copy_id", 1, copy_id)
        connection.execute(
            f"{numbered} folding_events SELECT {opened}, seq, format, {time_of}, kind, payload, NULL "  # noqa: S608
            "FROM n, folding_events WHERE run_id = ?",
            (copies, run_id),
        )
        connection.execute(
            f"{numbered} folding_runs SELECT {opened}, 'owner' || (i % 4), sequence, frames, {time_of}, {time_of}, "  # noqa: S608
            "events, saved, bytes FROM n, folding_runs WHERE run_id = ?",
            (copies, run_id),
        )


def long_run(store: RunStore, events: int) -> RunView:
    """A free fold with at least this many events: a checkpoint after every so many actions, some restored."""
    view = store.create()
    while view.seq < events:
        for _ in range(ACTIONS_PER_FRAME):
            view = turned(store, view.run_id, view.seq)
        with store.change(view.run_id) as change:
            view = change.save(view.base + 1)
        if view.base % ACTIONS_PER_FRAME == 0:
            with store.change(view.run_id) as change:
                view = change.restore(1)
    return view


def turned(store: RunStore, run_id: str, angle: float, request_id: str | None = None) -> RunView:
    """The run after one more action."""
    with store.change(run_id, request_id) as change:
        return change.act(Rotate(angle=angle))


def calls_on(
    store: RunStore, forgetful: RunStore, run_id: str, bare: sqlite3.Connection
) -> dict[str, Callable[[], object]]:
    """The calls to compare, by name."""
    return {
        "load, cached": lambda: store.load(run_id),
        "load, uncached": lambda: forget(forgetful).load(run_id),
        "act, cached": lambda: turned(store, run_id, 1),
        "act, cached, with a request id": lambda: turned(store, run_id, 1, str(uuid4())),
        "act, uncached": lambda: turned(forget(forgetful), run_id, 1),
        "bare commit": lambda: bare_commit(bare),
    }


def forget(store: RunStore) -> RunStore:
    """The store without any kept view."""
    store.forget()
    return store


def bare_table(path: Path) -> sqlite3.Connection:
    """A connection to a new table of one column, as durable as the store's."""
    connection = sqlite3.connect(path)
    connection.executescript("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; CREATE TABLE t (x TEXT)")
    return connection


def bare_commit(connection: sqlite3.Connection) -> None:
    """Insert one row and commit."""
    with connection:
        connection.execute("INSERT INTO t VALUES ('x')")


def milliseconds(call: Callable[[], object]) -> float:
    """How long the call takes."""
    begin = time.perf_counter()
    call()
    return (time.perf_counter() - begin) * 1000


def summary(times: list[float]) -> dict[str, float]:
    """Median and 95th percentile."""
    return {
        "median": round(statistics.median(times), 3),
        "p95": round(statistics.quantiles(times, n=20)[-1], 3),
    }


if __name__ == "__main__":
    main()
