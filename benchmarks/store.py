"""Measure what a call to the event store costs: ``python benchmarks/store.py`` prints one JSON document.

A run of ``--events`` events in a SQLite file (WAL, synchronous = FULL) is loaded and acted on with the
store's kept views and, in the same process and alternating with it, by a store that has forgotten them. All
times are in milliseconds; ``bare commit`` is one equally durable SQLite insert on an open connection, for
comparison.
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
from folding_server.store.run_store import RunStore
from folding_server.store.views import RunView

ACTIONS_PER_FRAME = 20


def main() -> None:
    """Run the benchmark and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--events", type=int, default=2000, help="events in the run (default 2000)")
    parser.add_argument("--calls", type=int, default=40, help="calls measured of each kind (default 40)")
    parser.add_argument("--data", type=Path, help="measure in this folder (default: a temporary one)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.data) as folder:
        figures = measure(Path(folder), options.events, options.calls)
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
