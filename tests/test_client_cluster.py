"""Batches on a Dask cluster: workers in this process, and the folding server that the other tests use."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from client_runs import PLANTED_KEY, events, program, sequence, settings
from client_runs import save as says_save
from distributed import Client, LocalCluster
from folding_client.batch import cluster
from folding_client.batch.batch_entry import BatchEntry
from folding_client.batch.batch_index import BatchIndex
from folding_client.batch.cluster import run_on_cluster, work_on_cluster
from folding_client.batch.conditions import Condition
from folding_client.batch.runner import Batch, planned_batch
from folding_client.batch.scheduling import Listener
from folding_client.interrupts import UsageError
from folding_client.record.event_log import EventLog, read_events
from folding_client.record.folder import RunFolder
from providers.base import Says
from providers.openai import OpenAI
from test_client_commands import TURN, command, save, script


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """The address of a cluster with two workers."""
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0", protocol="tcp"
    ) as local:
        yield str(local.scheduler_address)


def test_workers_reconstruct_a_batch_and_skip_what_is_finished(tmp_path: Path, scheduler: str) -> None:
    model = script(tmp_path, [save(1)], [TURN, save(2)])
    heard: list[BatchEntry] = []

    class Hears(Listener):
        def ended(self, line: BatchEntry) -> None:
            heard.append(line)

    def batch() -> list[BatchEntry]:
        sequences = [sequence(2), sequence(3)]
        return asyncio.run(run_on_cluster(scheduler, sequences, tmp_path, settings(model=model), Hears()))

    assert [line.status for line in batch()] == ["complete", "stopped"]
    assert {line.sequence for line in heard} == {sequence(2).name, sequence(3).name}
    assert program(tmp_path / sequence(2).name) == [[{"action": "rotate", "angle": 45.0}]]
    script(tmp_path, [save(1)], [TURN, save(2)], [TURN, save(3)])
    assert [line.status for line in batch()] == ["skipped", "complete"]
    about = json.loads((tmp_path / sequence(3).name / "run.json").read_text())
    assert about["settings"]["given"].keys() == {"model", "server_url", "retries"}


def test_an_interrupt_ends_the_runs_on_the_workers_and_leaves_them_resumable(
    tmp_path: Path, scheduler: str
) -> None:
    model = script(tmp_path, [save(1)], [TURN], *[[{"tool": "render_current", "arguments": {}}]] * 2000)
    run = tmp_path / sequence(2).name

    async def interrupted() -> None:
        batch = asyncio.ensure_future(
            run_on_cluster(scheduler, [sequence(2)], tmp_path, settings(model=model), Listener())
        )
        while not (run / "events.jsonl").exists() or "rotate" not in (run / "events.jsonl").read_text():
            assert not batch.done()
            await asyncio.sleep(0.05)
        batch.cancel()
        with pytest.raises(asyncio.CancelledError):
            await batch

    asyncio.run(interrupted())
    assert json.loads((run / "run.json").read_text())["outcome"]["status"] == "interrupted"
    assert events(run)[-1]["kind"] == "ended"
    script(tmp_path, [save(1)], [TURN, save(2)])
    (line,) = asyncio.run(
        run_on_cluster(scheduler, [sequence(2)], tmp_path, settings(model=model), Listener())
    )
    assert line.status == "complete"


def test_the_command_takes_the_address_of_a_scheduler(tmp_path: Path, scheduler: str) -> None:
    model = script(tmp_path, [save(1)], [TURN, save(2)])
    words = [
        "batch",
        sequence(2),
        "--model",
        model,
        "--out",
        tmp_path / "runs",
        "--dask",
        scheduler,
        "--json",
    ]
    done = command(*words, "--server-url", str(settings().server_url))
    assert done.returncode == 0, done.stderr
    assert [line["status"] for line in json.loads(done.stdout)] == ["complete"]
    refused = command(*words, "--jobs", "2")
    assert refused.returncode == 2
    assert "--jobs is for work in this process" in refused.stderr


def test_workers_without_the_project_are_a_line_that_says_so(
    tmp_path: Path, scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def work_without_the_project(*_: object) -> BatchEntry:
        raise ModuleNotFoundError("No module named 'folding_client'")

    monkeypatch.setattr(cluster, "work_on", work_without_the_project)
    batch = run_on_cluster(scheduler, [sequence(2), sequence(3)], tmp_path, settings(), Listener())
    lines = asyncio.run(batch)
    assert [line.status for line in lines] == ["failed", "failed"]
    assert "No module named 'folding_client'" in lines[0].reason
    assert "this version of the project" in lines[0].reason


def test_a_scheduler_that_does_not_answer_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "CLUSTER_SECONDS", 0.5)
    for address in ("tcp://127.0.0.1:9", "nowhere://at-all"):
        refused = command("batch", sequence(2), "--out", tmp_path, "--dask", address)
        assert refused.returncode == 2
        assert refused.stderr == (
            f"No Dask scheduler answers at {address}; name the address that it printed, such as tcp://HOST:8786.\n"
        )


def test_two_processes_do_not_work_on_one_run(tmp_path: Path) -> None:
    first, second = RunFolder(tmp_path), RunFolder(tmp_path)
    first.create()
    log = EventLog(first.events)
    log.append("opened")
    for begin in (second.create, second.hold):
        with pytest.raises(UsageError, match="Another process works on the run"):
            begin()
    log.close()
    assert [event["seq"] for event in read_events(first.events)] == [1], "it is refused before it writes"
    first.release()
    second.hold()
    again = EventLog(second.events)
    assert again.append("resumed")["seq"] == 2
    again.close()
    second.release()


def test_a_run_that_ended_meanwhile_is_not_begun_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The other process holds the folder when this one looks, and has written its run when this one holds it."""
    first, second = RunFolder(tmp_path / "run"), RunFolder(tmp_path / "run")
    first.create()
    first.events.write_text("all that was done\n")

    def end_and_hold() -> None:
        first.write_json("run.json", {"format": 1})
        first.release()
        RunFolder.hold(second)

    monkeypatch.setattr(second, "hold", end_and_hold)
    with pytest.raises(UsageError, match="holds a run already"):
        second.create()
    assert first.events.read_text() == "all that was done\n"
    first.hold()
    first.release()


HOLDER = """
import sys, time
from pathlib import Path
from folding_client.interrupts import UsageError
from folding_client.record.folder import RunFolder

folder = RunFolder(Path(sys.argv[1]))
while time.time() < float(sys.argv[2]):
    pass
try:
    folder.create()
except UsageError as refusal:
    print(refusal)
else:
    folder.events.write_text("opened\\n")
    print("mine", flush=True)
    sys.stdin.read()
"""


def test_of_processes_started_together_on_one_folder_one_wins(tmp_path: Path) -> None:
    run = tmp_path / "run"
    words = [sys.executable, "-c", HOLDER, str(run), str(time.time() + 1.5)]
    started = [
        subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) for _ in range(3)
    ]
    lines = [process.stdout.readline() for process in started if process.stdout]
    refusal = f"Another process works on the run in {run}; wait until it has ended.\n"
    assert sorted(lines) == sorted(["mine\n", refusal, refusal])
    assert (run / "events.jsonl").read_text() == "opened\n"
    winner = started[lines.index("mine\n")]
    winner.kill()
    for process in started:
        process.communicate()
    after = RunFolder(run)
    after.hold()
    after.release()


@pytest.mark.slow
def test_a_worker_that_dies_loses_nothing_that_was_saved(tmp_path: Path) -> None:
    looks = [[{"tool": "render_current", "arguments": {}}]] * 40
    model = script(tmp_path, [save(1)], [TURN, save(2)], *looks, [TURN, save(3)])
    run = tmp_path / sequence(3).name

    async def work() -> list[BatchEntry]:
        async with LocalCluster(
            n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0", asynchronous=True
        ) as local:
            batch = asyncio.ensure_future(
                run_on_cluster(
                    local.scheduler_address, [sequence(3)], tmp_path, settings(model=model), Listener()
                )
            )
            while (
                not (run / "events.jsonl").exists()
                or "render_current" not in (run / "events.jsonl").read_text()
            ):
                assert not batch.done()
                await asyncio.sleep(0.02)
            (nanny,) = local.workers.values()
            os.kill(nanny.pid, signal.SIGKILL)
            return await batch

    (line,) = asyncio.run(work())
    assert line.status == "complete"
    kinds = [event["kind"] for event in events(run) if event["kind"] in ("opened", "resumed", "ended")]
    assert kinds == ["opened", "resumed", "ended"]
    assert [len(step) for step in program(run)] == [1, 1]


@pytest.mark.slow
def test_of_a_batch_whose_worker_is_killed_nothing_is_lost_and_nothing_done_twice(tmp_path: Path) -> None:
    looks = [[{"tool": "render_current", "arguments": {}}]] * 25
    model = script(tmp_path, [save(1)], [TURN, save(2)], *looks, [TURN, save(3)], [TURN, save(4)], *looks)
    sequences = [sequence(frames) for frames in (2, 3, 4)]
    third = tmp_path / sequence(4).name

    async def work() -> list[BatchEntry]:
        async with LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0", asynchronous=True
        ) as local:
            batch = asyncio.ensure_future(
                run_on_cluster(
                    local.scheduler_address, sequences, tmp_path, settings(model=model), Listener()
                )
            )
            while not _is_looking(third):
                assert not batch.done()
                await asyncio.sleep(0.02)
            holders = await _workers_at_work(local.scheduler_address)
            os.kill(holders[-1], signal.SIGKILL)
            return await batch

    lines = asyncio.run(work())
    assert [line.status for line in lines] == ["complete"] * 3
    for folder in (tmp_path / each.name for each in sequences):
        kinds = [event["kind"] for event in events(folder, "opened", "resumed", "ended")]
        assert kinds.count("opened") == kinds.count("ended") == 1
        saved = [event["frame"] for event in events(folder, "step_over")]
        assert saved == sorted(set(saved)), "no frame was saved twice"
        assert len(program(folder)) == saved[-1] - 1
    with BatchIndex(tmp_path) as index:
        index.add(sequences, [Condition(settings(model=model))])
        assert index.sums().counts == {"complete": 3}
        assert [task.tries for task, _ in index.entries()] == [1, 1, 1]


def _is_looking(run: Path) -> bool:
    file = run / "events.jsonl"
    return file.exists() and "render_current" in file.read_text()


async def _workers_at_work(address: str) -> list[int]:
    """The processes of the workers of a cluster that have a task."""
    async with Client(address, asynchronous=True) as client:
        busy = await client.processing()
        told = (await client.scheduler.identity())["workers"]
        pids = await client.run(os.getpid)
    assert set(busy) <= set(told)
    return [pids[worker] for worker, tasks in busy.items() if tasks]


def test_on_a_cluster_the_ceiling_of_cost_stops_every_run_before_its_next_query(
    tmp_path: Path, scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", PLANTED_KEY)
    monkeypatch.setattr(cluster, "POLL_SECONDS", 0.05)
    model = "litellm/openai/gpt-4o"
    looks = [Says(calls=[("get_current_state", {})])] * 60
    with OpenAI(says_save(1), *looks) as provider:
        given = settings(model=model, api_base=provider.url)
        batch = Batch([sequence(2)], [Condition(given)], tmp_path, most_cost=0.01)
        with planned_batch(batch, Listener()) as planned:
            asyncio.run(work_on_cluster(scheduler, planned))
            (line,) = planned.entries()
    assert line.status == "stopped"
    assert "The limit of $0.01 for the whole batch is reached" in line.reason
    assert line.cost is not None and 0.01 <= line.cost < 0.15
    assert planned.budget.spent == pytest.approx(line.cost)
