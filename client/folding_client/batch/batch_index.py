"""The index of a batch: one SQLite row a run, beside the run folders.

The run folders are the truth, the index is what makes a batch of a million cheap: what is done and what is left, and the sums,
are read once when it begins and kept in memory from then on. It can be removed: the next batch makes it anew from the
run folders as it comes to them.
"""

import json
import sqlite3
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Self

from folding_client.batch.batch_entry import BatchEntry
from folding_client.batch.conditions import Condition
from folding_client.interrupts import UsageError

INDEX_FILE = "batch.sqlite"
_FORMAT = 1
_CHUNK = 1000
"""Rows that are written or read at a time: memory stays flat, and a chunk takes some milliseconds."""
_TABLES = """
CREATE TABLE IF NOT EXISTS runs (
    number INTEGER PRIMARY KEY, folder TEXT NOT NULL UNIQUE, sequence TEXT NOT NULL, condition INTEGER NOT NULL,
    made_by TEXT NOT NULL, plan INTEGER NOT NULL, status TEXT NOT NULL DEFAULT 'waiting', tries INTEGER NOT NULL DEFAULT 0,
    begun INTEGER NOT NULL DEFAULT 0,
    tokens INTEGER NOT NULL DEFAULT 0, cost REAL, entry TEXT
) STRICT
"""
_PLAN_ROW = """
INSERT INTO runs (folder, sequence, condition, made_by, plan) VALUES (?, ?, ?, ?, ?)
ON CONFLICT (folder) DO UPDATE SET
    sequence = excluded.sequence, condition = excluded.condition, plan = excluded.plan, made_by = excluded.made_by,
    status = CASE WHEN made_by = excluded.made_by AND status = 'complete' THEN 'complete' ELSE 'waiting' END
WHERE plan != excluded.plan
"""


@dataclass(frozen=True)
class BatchTask:
    """One run of a batch: ``folder`` is the run's, below that of the batch; ``tries``, ``tokens`` and ``cost`` are those so far,
    ``begun`` is the plan in which it was worked on last.
    """

    number: int
    folder: str
    sequence: str
    condition: int
    status: str
    tries: int = 0
    tokens: int = 0
    cost: float = 0.0
    begun: int = 0


_TASK = "number, folder, sequence, condition, status, tries, tokens, COALESCE(cost, 0.0), begun"


@dataclass
class BatchSums:
    """What the runs of a batch came to so far: how many of each status, tokens, US dollars."""

    counts: Counter[str]
    tokens: int = 0
    cost: float = 0.0

    @property
    def runs(self) -> int:
        """All runs of the batch."""
        return self.counts.total()


class BatchIndex:
    """The index in the folder of a batch, which this process has to itself. A context manager. UsageError if another
    process works there, or the file is no index.
    """

    def __init__(self, out: Path) -> None:
        from filelock import FileLock, Timeout

        self._out = out
        self._lock = FileLock(out / ".batch.lock", blocking=False, thread_local=False)
        try:
            out.mkdir(parents=True, exist_ok=True)
            self._lock.acquire()
        except Timeout as error:
            message = f"Another batch works in {out}; wait until it has ended, or choose another --out."
            raise UsageError(message) from error
        except OSError as error:
            message = f"Cannot use {out} as the folder of a batch: {error.strerror}. Name another with --out."
            raise UsageError(message) from error
        try:
            self._database = self._opened(out / INDEX_FILE)
        except BaseException:
            self._lock.release()
            raise
        self.plan = self._next_plan()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._database.close()
        self._lock.release()

    def add(self, sequences: Iterable[Path], conditions: Sequence[Condition]) -> int:
        """Plan every sequence under every condition, in this order; what other batches planned stays as it is. Answers how
        many runs there are. UsageError if two would share a folder.
        """
        rows = (
            (str(Path(each.folder, sequence.name)), str(sequence), number, each.made_by, self.plan)
            for sequence in sequences
            for number, each in enumerate(conditions)
        )
        count = 0
        with self._transaction() as database:
            while chunk := list(islice(rows, _CHUNK)):
                done = database.executemany(_PLAN_ROW, chunk).rowcount
                if done != len(chunk):
                    raise self._twice(chunk)
                count += done
        return count

    def tasks(self, statuses: frozenset[str]) -> Iterator[BatchTask]:
        """The runs of this batch with these statuses, as they stand when they are come to."""
        marks = ", ".join("?" * len(statuses))
        query = (
            f"SELECT {_TASK} FROM runs "  # noqa: S608 - question marks alone are put in
            f"WHERE number > ? AND plan = ? AND status IN ({marks}) ORDER BY number LIMIT {_CHUNK}"
        )
        last = 0
        while rows := self._database.execute(query, (last, self.plan, *sorted(statuses))).fetchall():
            last = rows[-1][0]
            yield from (BatchTask(*row) for row in rows)

    def begun(self, task: BatchTask) -> None:
        """A run is being worked on."""
        self._database.execute(
            "UPDATE runs SET status = 'running', tries = tries + 1, begun = plan WHERE number = ?",
            (task.number,),
        )

    def ended(self, task: BatchTask, entry: BatchEntry) -> None:
        """A run ended so; its tokens and cost are those of all times that it was worked on."""
        status = "complete" if entry.is_done else entry.status
        self._database.execute(
            "UPDATE runs SET status = ?, tokens = ?, cost = ?, entry = ? WHERE number = ?",
            (status, entry.tokens, entry.cost, json.dumps(vars(entry)), task.number),
        )

    def was_begun(self, task: BatchTask) -> bool:
        """Whether a run was worked on in this batch."""
        return task.begun == self.plan

    def again(self, task: BatchTask) -> None:
        """A run that was complete is not there any more."""
        self._database.execute("UPDATE runs SET status = 'waiting' WHERE number = ?", (task.number,))

    def sums(self) -> BatchSums:
        """What the runs of this batch came to: one look at every row."""
        rows = self._database.execute(
            "SELECT status, COUNT(*), SUM(tokens), TOTAL(cost) FROM runs WHERE plan = ? GROUP BY status",
            (self.plan,),
        ).fetchall()
        counts = Counter({status: count for status, count, _, _ in rows})
        return BatchSums(counts, sum(row[2] for row in rows), sum(row[3] for row in rows))

    def entries(self) -> Iterator[tuple[BatchTask, BatchEntry | None]]:
        """The runs of this batch, each with how it ended last, None if it never did."""
        query = (
            f"SELECT {_TASK}, entry FROM runs "  # noqa: S608 - constants of our own
            f"WHERE number > ? AND plan = ? ORDER BY number LIMIT {_CHUNK}"
        )
        last = 0
        while rows := self._database.execute(query, (last, self.plan)).fetchall():
            last = rows[-1][0]
            for *task, text in rows:
                yield BatchTask(*task), None if text is None else _entry(json.loads(text))

    def _opened(self, file: Path) -> sqlite3.Connection:
        database = sqlite3.connect(file, isolation_level=None)
        try:
            (found,) = database.execute("PRAGMA user_version").fetchone()
            if found not in {0, _FORMAT}:
                raise sqlite3.DatabaseError
            database.execute("PRAGMA journal_mode = WAL")
            database.execute("PRAGMA synchronous = NORMAL")
            database.execute(_TABLES)
            database.execute(f"PRAGMA user_version = {_FORMAT}")
        except sqlite3.DatabaseError as error:
            database.close()
            message = (
                f"{file} is not a batch index of format {_FORMAT}; remove it, and the next batch makes it anew from the "
                "run folders."
            )
            raise UsageError(message) from error
        return database

    def _next_plan(self) -> int:
        (last,) = self._database.execute("SELECT COALESCE(MAX(plan), 0) FROM runs").fetchone()
        return int(last) + 1

    def _twice(self, chunk: Sequence[tuple[Any, ...]]) -> UsageError:
        """Which sequence of a chunk has a folder that another of this batch has."""
        folders = Counter(row[0] for row in chunk)
        there = "SELECT 1 FROM runs WHERE folder = ? AND plan = ? AND sequence != ?"
        twice = next(
            row[1]
            for row in chunk
            if folders[row[0]] > 1 or self._database.execute(there, (row[0], self.plan, row[1])).fetchone()
        )
        message = f"The batch has two sequences named {Path(twice).name}; their runs would share a folder, so rename one."
        return UsageError(message)

    @contextmanager
    def _transaction(self) -> Iterator[sqlite3.Connection]:
        self._database.execute("BEGIN")
        try:
            yield self._database
        except BaseException:
            self._database.execute("ROLLBACK")
            raise
        self._database.execute("COMMIT")


def _entry(data: dict[str, Any]) -> BatchEntry:
    known = {name: value for name, value in data.items() if name in BatchEntry.__dataclass_fields__}
    return BatchEntry(**known | {"doubtful": tuple(data["doubtful"])})
