"""A batch of made-up sequences through the real bookkeeping: index, queue, retries, ceiling of cost, table.

    python benchmarks/scale.py                            a million sequences, some minutes
    python benchmarks/scale.py --sequences 1000 --kills 1

What is made up is the work on a sequence: how long it takes, what it costs and whether it fails are drawn from what was
measured (MEASURED), and time is virtual: the event loop's clock jumps to whatever comes next. A run leaves its mark in
a ledger, as a real one does in its folder. The batch is stopped by a ceiling of cost once, and its process killed (SIGKILL) at
random moments, and begun again until all is done. Then the ledger is counted: every sequence complete once, none twice.

JSON: the counts, seconds and bytes a sequence of the bookkeeping alone, memory (VmRSS, in MB) as the batch went on, the virtual time.
"""

import argparse
import json
import os
import resource
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from io import StringIO
from pathlib import Path
from random import Random
from typing import Any

from folding_client.batch.batch_budget import BatchBudget, RunWatch
from folding_client.batch.batch_entry import BatchEntry
from folding_client.batch.batch_index import INDEX_FILE, BatchIndex, BatchTask
from folding_client.batch.batch_table import BatchTable
from folding_client.batch.conditions import Condition
from folding_client.batch.scheduling import BatchLimits, BatchQueue
from folding_client.settings import Settings
from rich.console import Console
from virtual_time import run_in_virtual_time

MEASURED: Mapping[str, float] = {
    "seconds_median": 146.0,
    "seconds_sigma": 0.51,
    "failing": 0.02,
    "always_failing": 0.0005,
    "dollars": 0.01,
}
"""A run of the geometric model (docs/scale.md): seconds are log-normal by median and sigma. No run failed there, and it costs
nothing, so that the shares of runs that fail once or always, and dollars, are assumptions that put the bookkeeping to work."""
LEDGER = "ledger"
JOBS = 256
TRIES = 3
CEILING_AT = 0.3
"""The share of all costs at which the batch is stopped for the first time."""
DRAWN_EVERY = 2000
"""Runs between two times that the table is drawn: the virtual batch ends thousands of runs a second, and a terminal is drawn
four times a second."""
_SPREAD = 0.6180339887498949
"""The golden ratio less 1: its multiples, less whole numbers, are spread evenly."""
SAMPLES = 20
"""Times that memory is looked at in one process."""


class Ledger:
    """What the made-up runs left behind: a line for each try that ended, written at once, before the batch is told of it.

    A real run says in its folder that it is complete, before the batch knows; so does a line here.
    """

    def __init__(self, path: Path, count: int) -> None:
        self._log = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        self._complete = bytearray(count)
        for number, complete in lines_of(path):
            self._complete[number] |= complete

    def is_complete(self, number: int) -> bool:
        """Whether the sequence was done."""
        return bool(self._complete[number])

    def ended(self, number: int, *, complete: bool) -> None:
        """A try ended."""
        os.write(self._log, f"{number} {'c' if complete else 'f'}\n".encode())
        self._complete[number] |= complete


def lines_of(path: Path) -> Iterator[tuple[int, bool]]:
    """The tries in a ledger: the sequence, and whether it was complete then."""
    with path.open(encoding="ascii") as log:
        for line in log:
            number, _, how = line.strip().partition(" ")
            yield int(number), how == "c"


def sequences(count: int) -> Iterator[Path]:
    """Folders that are not there, one by one."""
    return (Path(f"/corpus/{number:07}") for number in range(count))


class MadeUpWork:
    """A run that takes virtual time. What happens to a sequence is drawn from its number and the try alone."""

    def __init__(self, ledger: Ledger, budget: BatchBudget) -> None:
        self._ledger = ledger
        self._budget = budget
        self.asked = 0

    async def __call__(self, task: BatchTask, watch: RunWatch) -> BatchEntry:
        """One run, stopped before its query if the batch is at its limit."""
        import asyncio

        number = int(task.sequence.rpartition("/")[2])
        if self._ledger.is_complete(number):
            return self._entry(task, "skipped", MEASURED["dollars"])
        chance = Random(number * 1000 + task.tries)
        seconds = chance.lognormvariate(0, MEASURED["seconds_sigma"]) * MEASURED["seconds_median"]
        await asyncio.sleep(seconds)
        if self._budget.is_reached:
            return self._entry(task, "stopped", None)
        self.asked += 1
        always = number * _SPREAD % 1.0 < MEASURED["always_failing"]
        fails = always or chance.random() < MEASURED["failing"]
        self._ledger.ended(number, complete=not fails)
        cost = (watch.cost or 0.0) + MEASURED["dollars"]
        return self._entry(task, "failed" if fails else "complete", cost, seconds)

    def _entry(self, task: BatchTask, status: str, cost: float | None, seconds: float = 0.0) -> BatchEntry:
        frames = 0 if status in {"failed", "stopped"} else 12
        name = task.sequence.rpartition("/")[2]
        return BatchEntry(
            name,
            status,
            "",
            frames,
            12,
            seconds,
            task.folder,
            11,
            11,
            (),
            2000,
            cost,
            "geometric",
            "agent",
            0,
        )


class Drawn(BatchTable):
    """The batch's table on a terminal that nobody sees, drawn as often as a person would see it."""

    def __init__(self, sample: Path) -> None:
        super().__init__(Console(file=StringIO(), force_terminal=True, width=120))
        self._sample = sample
        self._ended = self._next = 0

    def planned(self, sums: Any, budget: BatchBudget) -> None:  # noqa: ANN401 - as the table has it
        """No drawing by a clock: runs that end draw it."""
        self._sums, self._budget = sums, budget
        self._ends.append(self._clock())

    def ended(self, line: BatchEntry) -> None:  # noqa: ARG002
        """Draw now and then, and look at memory."""
        self._ends.append(self._clock())
        self._ended += 1
        if self._ended % DRAWN_EVERY == 1:
            self._console.file = StringIO()
            self._console.print(self.drawn())
        if self._ended >= self._next:
            self._next += max(self._sums.runs // SAMPLES, 1)
            with self._sample.open("a", encoding="utf-8") as file:
                file.write(f"{self._sums.counts['complete']} {resident()}\n")


def resident() -> float:
    """MB of memory that this process has now."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return round(pages * resource.getpagesize() / 1e6, 1)


def work_once(home: Path, count: int, ceiling: float | None) -> dict[str, Any]:
    """Begin the batch, or go on with it, until it is done or at its ceiling."""
    started = time.perf_counter()
    conditions = [Condition(Settings())]
    ledger = Ledger(home / LEDGER, count)
    with BatchIndex(home / "runs") as index:
        index.add(sequences(count), conditions)
        planned = time.perf_counter()
        budget = BatchBudget(ceiling)
        table = Drawn(home / "memory")
        queue = BatchQueue(index, budget, table, lambda task: ledger.is_complete(_number(task)))
        work = MadeUpWork(ledger, budget)
        took = run_in_virtual_time(queue.work_through(work, BatchLimits(JOBS, TRIES)))
        return {
            "planning_seconds": round(planned - started, 2),
            "working_seconds": round(time.perf_counter() - planned, 2),
            "virtual_seconds": round(took["seconds"]),
            "counts": dict(queue.sums.counts),
            "spent": round(budget.spent, 2),
            "done_now": work.asked,
            "peak_mb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3, 1),
            "summary": table.summary,
        }


def measure(home: Path, count: int, kills: int, seed: int) -> dict[str, Any]:
    """The whole story: to the ceiling, then killed so many times, then to the end, then once more."""
    ceiling = CEILING_AT * MEASURED["dollars"] * count
    stopped = _child(home, count, ceiling)
    killed = [_killed(home, count, Random(f"{seed} {number}")) for number in range(kills)]
    done = _child(home, count, None)
    again = _child(home, count, None)
    files = sum(file.stat().st_size for file in (home / "runs").glob(f"{INDEX_FILE}*"))
    sums = {
        "sequences": count,
        "to_the_ceiling": stopped,
        "overspent_dollars": round(stopped["spent"] - ceiling, 2),
        "complete_when_killed": killed,
        "to_the_end": done,
        "begun_again_when_all_was_done": again,
        "index_bytes_a_sequence": round(files / count),
        "ledger": counted(home, count),
        "index": _index_counts(home),
        "memory_mb": [float(line.split()[1]) for line in (home / "memory").read_text().splitlines()],
    }
    working = stopped["working_seconds"] + done["working_seconds"]
    tries = stopped["done_now"] + done["done_now"]
    return {**sums, "microseconds_a_try": round(1e6 * working / max(tries, 1))}


def counted(home: Path, count: int) -> dict[str, int]:
    """What the ledger says of the sequences: complete once, complete more often, never; and tries that failed."""
    done = bytearray(count)
    failed = 0
    for number, complete in lines_of(home / LEDGER):
        done[number] += complete
        failed += not complete
    once = done.count(1)
    never = done.count(0)
    return {
        "complete_once": once,
        "complete_twice": count - once - never,
        "never_complete": never,
        "failed_tries": failed,
    }


def _index_counts(home: Path) -> dict[str, int]:
    with sqlite3.connect(home / "runs" / INDEX_FILE) as database:
        return dict(database.execute("SELECT status, COUNT(*) FROM runs GROUP BY status").fetchall())


def _command(home: Path, count: int, ceiling: float | None) -> list[str]:
    words = [sys.executable, __file__, "--home", str(home), "--sequences", str(count), "--once"]
    return words if ceiling is None else [*words, "--ceiling", str(ceiling)]


def _child(home: Path, count: int, ceiling: float | None) -> dict[str, Any]:
    done = subprocess.run(_command(home, count, ceiling), capture_output=True, text=True, check=True)
    told: dict[str, Any] = json.loads(done.stdout)
    return told


def _killed(home: Path, count: int, chance: Random) -> int:
    """Begin again, and kill the process after a random share of what is left; answers how many are complete then."""
    left = counted(home, count)["never_complete"]
    goal = count - left + int(left * chance.uniform(0.2, 0.6))
    log = home / LEDGER
    start = log.stat().st_size
    per_line = start / max(sum(1 for _ in log.open(encoding="ascii")), 1)
    enough = start + (goal - (count - left)) * per_line
    with subprocess.Popen(
        _command(home, count, None), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as child:
        while child.poll() is None and log.stat().st_size < enough:
            time.sleep(0.01)
        child.send_signal(signal.SIGKILL)
    return counted(home, count)["complete_once"]


def _number(task: BatchTask) -> int:
    """The number of a made-up sequence, which its name ends in."""
    return int(task.sequence.rpartition("/")[2])


def main() -> None:
    """Print the JSON."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sequences", type=int, default=1_000_000)
    parser.add_argument("--kills", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--home", type=Path, help="where index and ledger go; a temporary folder if left out")
    parser.add_argument("--once", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--ceiling", type=float, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.once:
        print(json.dumps(work_once(given.home, given.sequences, given.ceiling)))
        return
    with tempfile.TemporaryDirectory() as home:
        place = given.home or Path(home)
        place.mkdir(parents=True, exist_ok=True)
        print(json.dumps(measure(place, given.sequences, given.kills, given.seed), indent=1))


if __name__ == "__main__":
    main()
