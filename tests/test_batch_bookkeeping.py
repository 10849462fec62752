"""Index, queue, ceiling and table of a batch: with made-up runs, since they know nothing of how a run is done."""

import asyncio
import io
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from folding_client.batch.batch_budget import BatchBudget, RunWatch
from folding_client.batch.batch_entry import BatchEntry
from folding_client.batch.batch_index import INDEX_FILE, BatchIndex, BatchSums, BatchTask
from folding_client.batch.batch_table import BatchTable
from folding_client.batch.conditions import Condition, conditions_of
from folding_client.batch.scheduling import BatchLimits, BatchQueue, Listener
from folding_client.batch.sequence_lists import absolute_folders, shard_of
from folding_client.interrupts import UsageError
from folding_client.settings import Settings
from paths import ROOT
from rich.console import Console

HERE = [Condition(Settings())]


@dataclass
class MadeUp:
    """Work on runs that fails as often as it is told to, and costs as much; ``worked`` is by sequence."""

    fails: dict[str, int] = field(default_factory=dict)
    cost: float = 0.0
    worked: Counter[str] = field(default_factory=Counter)
    at_once: int = 0
    most_at_once: int = 0

    async def __call__(self, task: BatchTask, watch: RunWatch) -> BatchEntry:
        name = Path(task.sequence).name
        self.worked[name] += 1
        self.at_once += 1
        self.most_at_once = max(self.at_once, self.most_at_once)
        await asyncio.sleep(0)
        self.at_once -= 1
        status = "failed" if self.worked[name] <= self.fails.get(name, 0) else "complete"
        watch.spent(task.tokens + 10, task.cost + self.cost)
        return BatchEntry(name, status, "", 2, 2, 1.0, task.folder, tokens=watch.tokens, cost=watch.cost)


@contextmanager
def queue_of(
    out: Path, names: str, budget: BatchBudget | None = None, gone: str = "", listener: Listener | None = None
) -> Iterator[BatchQueue]:
    with BatchIndex(out) as index:
        index.add([Path("/corpus", name) for name in names], HERE)
        yield BatchQueue(
            index,
            budget or BatchBudget(),
            listener or Listener(),
            lambda task: Path(task.sequence).name not in gone,
        )


def work_through(queue: BatchQueue, work: MadeUp, *, jobs: int = 1, tries: int = 1) -> dict[str, int]:
    asyncio.run(queue.work_through(work, BatchLimits(jobs, tries)))
    return {status: count for status, count in queue.sums.counts.items() if count}


def test_what_failed_is_no_success_and_is_tried_again_by_the_next_batch(tmp_path: Path) -> None:
    work = MadeUp(fails={"b": 1})
    with queue_of(tmp_path, "abc") as queue:
        assert work_through(queue, work) == {"complete": 2, "failed": 1}
    with queue_of(tmp_path, "abc") as queue:
        assert work_through(queue, work) == {"complete": 3}
    assert work.worked == {"a": 1, "b": 2, "c": 1}


def test_a_batch_tries_what_fails_as_often_as_it_is_told(tmp_path: Path) -> None:
    work = MadeUp(fails={"b": 1, "c": 9})
    with queue_of(tmp_path, "abcd") as queue:
        assert work_through(queue, work, tries=3) == {"complete": 3, "failed": 1}
    assert work.worked == {"a": 1, "b": 2, "c": 3, "d": 1}


def test_so_many_runs_are_worked_on_at_a_time(tmp_path: Path) -> None:
    work = MadeUp()
    with queue_of(tmp_path, "abcdefg") as queue:
        work_through(queue, work, jobs=3)
    assert work.most_at_once == 3


def test_a_run_whose_folder_is_gone_is_done_again(tmp_path: Path) -> None:
    work = MadeUp()
    with queue_of(tmp_path, "ab") as queue:
        work_through(queue, work)
    with queue_of(tmp_path, "ab", gone="b") as queue:
        assert work_through(queue, work) == {"complete": 2}
    assert work.worked == {"a": 1, "b": 2}


def test_the_ceiling_holds_over_all_runs_and_all_times_and_the_rest_is_left_to_do(tmp_path: Path) -> None:
    work = MadeUp(cost=1.0)
    for most, spent, complete in ((2.5, 3.0, 3), (2.5, 3.0, 3), (4.5, 5.0, 5), (None, 6.0, 6)):
        budget = BatchBudget(most)
        with queue_of(tmp_path, "abcdef", budget) as queue:
            assert work_through(queue, work)["complete"] == complete
            assert (budget.spent, queue.sums.cost) == (spent, spent)
    assert set(work.worked.values()) == {1}


def test_a_retry_adds_to_the_sums_what_it_cost_itself(tmp_path: Path) -> None:
    budget = BatchBudget()
    with queue_of(tmp_path, "a", budget) as queue:
        work_through(queue, MadeUp(fails={"a": 2}, cost=1.0), tries=3)
        assert (queue.sums.cost, queue.sums.tokens, budget.spent) == (3.0, 30, 3.0)
    with queue_of(tmp_path, "a") as queue:
        assert (queue.sums.cost, queue.sums.tokens) == (3.0, 30)


def test_a_cancelled_batch_leaves_what_was_under_way_to_the_next(tmp_path: Path) -> None:
    at_b = asyncio.Event()

    at_b = asyncio.Event()

    class Hangs(MadeUp):
        async def __call__(self, task: BatchTask, watch: RunWatch) -> BatchEntry:
            if task.sequence.endswith("b"):
                at_b.set()
                await asyncio.sleep(60)
            return await super().__call__(task, watch)

    async def cancelled(queue: BatchQueue) -> None:
        batch = asyncio.ensure_future(queue.work_through(Hangs(), BatchLimits()))
        await at_b.wait()
        batch.cancel()
        with pytest.raises(asyncio.CancelledError):
            await batch

    with queue_of(tmp_path, "abc") as queue:
        asyncio.run(cancelled(queue))
    work = MadeUp()
    with queue_of(tmp_path, "abc") as queue:
        assert work_through(queue, work) == {"complete": 3}
    assert set(work.worked) == {"b", "c"}


def test_two_batches_do_not_work_in_one_folder(tmp_path: Path) -> None:
    with BatchIndex(tmp_path), pytest.raises(UsageError, match="Another batch works in"):
        BatchIndex(tmp_path)
    with BatchIndex(tmp_path):
        pass


def test_a_file_that_is_no_index_is_refused_with_what_to_do(tmp_path: Path) -> None:
    (tmp_path / INDEX_FILE).write_text("not a database, but long enough to look at " * 10)
    with pytest.raises(UsageError, match="remove it, and the next batch makes it anew"):
        BatchIndex(tmp_path)


@pytest.mark.parametrize("names", ["aba", "a" * 2])
def test_two_sequences_of_one_name_are_refused_and_nothing_is_planned(tmp_path: Path, names: str) -> None:
    folders = [Path(f"/corpus/{number}/{name}") for number, name in enumerate(names)]
    with BatchIndex(tmp_path) as index:
        with pytest.raises(UsageError, match="two sequences named a; .* rename one"):
            index.add(folders, HERE)
        assert list(index.entries()) == []


def test_another_batch_in_the_folder_leaves_the_runs_of_the_first_alone(tmp_path: Path) -> None:
    with queue_of(tmp_path, "ab") as queue:
        work_through(queue, MadeUp())
    work = MadeUp()
    with queue_of(tmp_path, "bc") as queue:
        assert work_through(queue, work) == {"complete": 2}
    assert work.worked == {"c": 1}


def test_the_parts_of_a_corpus_have_every_sequence_once() -> None:
    corpus = [Path(f"/corpus/{number}") for number in range(200)]
    parts = [list(absolute_folders(corpus, shard_of(f"{number}/3"))) for number in (1, 2, 3)]
    assert sorted(path for part in parts for path in part) == sorted(corpus)
    assert min(map(len, parts)) > 40


@pytest.mark.parametrize("text", ["0/3", "4/3", "3", "a/b", "1/0"])
def test_what_is_no_part_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="give a part and the number of parts, such as 3/16"):
        shard_of(text)


def test_conditions_are_models_by_variants_by_seeds_without_those_that_would_be_the_same() -> None:
    models = ["geometric", "random", "scripted:some file.json"]
    found = conditions_of(Settings(), models, ["agent", "vlm-s"], [1, 2])
    assert [condition.folder for condition in found] == [
        "geometric",
        "random_seed-1",
        "random_seed-2",
        "scripted-some-file.json_seed-1",
        "scripted-some-file.json_seed-2",
        "scripted-some-file.json_vlm-s_seed-1",
        "scripted-some-file.json_vlm-s_seed-2",
    ]
    assert found[1].settings.seed == 1
    assert conditions_of(Settings(seed=4), [], [], []) == [Condition(Settings(seed=4))]


def test_models_whose_runs_would_share_a_folder_are_refused() -> None:
    with pytest.raises(UsageError, match="would share the folder scripted-a-b"):
        conditions_of(Settings(), ["scripted:a b", "scripted:a-b"], [], [])


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_the_table_says_what_runs_is_done_and_spent_and_how_long_the_rest_takes() -> None:
    clock, out = Clock(), io.StringIO()
    table = BatchTable(Console(file=out, width=100), clock)
    budget = BatchBudget(5.0)
    sums = BatchSums(Counter({"waiting": 8, "running": 1, "complete": 1}), tokens=1000)
    table.planned(sums, budget)
    watch = RunWatch(1, "one", budget)
    table.begun(watch)
    watch.step(3, 9, 2)
    watch.spent(2345, 0.5)
    clock.now = 60.0
    table.ended(BatchEntry("zero", "complete", "", 2, 2, 60.0, "zero"))
    console = Console(file=io.StringIO(), width=100)
    console.print(table.drawn())
    assert isinstance(console.file, io.StringIO)
    head, row, line = console.file.getvalue().splitlines()
    assert head.split() == ["run", "frames", "tokens", "cost", "time"]
    assert row.split() == ["one", "2/9", "2,345", "$0.5000", "1:00"]
    assert (
        line.strip()
        == "1 of 10 runs complete, 1 running, 8 waiting; 3,345 tokens, $0.5000 of $5; about 9:00 left"
    )
    assert out.getvalue() == "zero: complete, 2 of 2 frames, 60.0 s\n", "off a terminal, a line a run"


def test_a_thousand_made_up_sequences_are_each_done_once_although_the_batch_is_killed() -> None:
    words = [sys.executable, str(ROOT / "benchmarks" / "scale.py"), "--sequences", "1000", "--kills", "1"]
    found = json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
    ledger = found["ledger"]
    assert ledger["complete_twice"] == 0
    assert ledger["complete_once"] == found["index"]["complete"]
    assert ledger["never_complete"] == found["index"].get("failed", 0) < 10
    assert ledger["failed_tries"] > 5
    assert found["to_the_ceiling"]["counts"]["stopped"] > 0
    assert 0 <= found["overspent_dollars"] < 0.05
    assert found["complete_when_killed"][0] < 1000
