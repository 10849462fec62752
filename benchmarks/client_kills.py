"""Kill the client in the middle of its work, again and again: ``python benchmarks/client_kills.py --kills 100`` prints JSON.

A run is started and killed with SIGKILL, resumed and killed, until it is complete; then the next one is started, until
there were as many kills as asked for. Every second kill comes at a random moment, the others between a call to the server and
its answer. Each complete run is compared with one that nobody disturbed: the same program, somebody on record for every
frame, an answer to every call that changes the run, no line missing, and a replay that answers the same. Exits with 1 where
that is not so. The moments depend on the machine, and on ``--seed``.
"""

import argparse
import asyncio
import json
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from folding_client.record.event_log import gaps, read_events
from folding_client.record.replay import replay_run

LONGEST_SECONDS = 4.0
"""The latest moment of a random kill, after the first event of a process."""
MOST_CALLS = 40
"""The kill between a call and its answer comes at one of so many first calls of a process."""
POLL_SECONDS = 0.0005
"""Between two looks at the log."""
SCRIPT = "script"
"""Stands for a script of the sequence's own program."""
SEQUENCE = Path(__file__).resolve().parent.parent / "examples" / "cat"


@dataclass(frozen=True)
class KillPlan:
    """What is run and how often it is killed; at a call, among so many first ``calls`` of a process."""

    sequence: Path
    model: str
    kills: int
    seed: int
    calls: int = MOST_CALLS


@dataclass
class KillReport:
    """How it went: kills, those that fell between a call and its answer, runs that were completed, and faults."""

    kills: int = 0
    in_flight: int = 0
    runs: int = 0
    calls: int = 0
    faults: list[str] = field(default_factory=list)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100, help="how often (default 100)")
    parser.add_argument("--seed", type=int, default=0, help="of the moments (default 0)")
    parser.add_argument(
        "--model",
        default=SCRIPT,
        help=f"the model of the runs (default {SCRIPT}: a script of the true program)",
    )
    parser.add_argument("--frames", type=int, default=9, help="how many frames of the sequence (default 9)")
    parser.add_argument("--sequence", type=Path, default=SEQUENCE, help="a sequence (default: the cat)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        sequence = first_frames(options.sequence, home / options.sequence.name, options.frames)
        model = (
            script_of(options.sequence, home, options.frames) if options.model == SCRIPT else options.model
        )
        report = kill_often(KillPlan(sequence, model, options.kills, options.seed), home / "runs")
    json.dump(vars(report), sys.stdout, indent=2)
    sys.stdout.write("\n")
    sys.exit(1 if report.faults else 0)


def script_of(sequence: Path, home: Path, frames: int) -> str:
    """A model that does what the program of a sequence says, and looks at the paper after every action."""
    steps = json.loads((sequence / "program.json").read_text())["steps"][: frames - 1]
    replies: list[list[dict[str, Any]]] = [[_call("save_checkpoint", frame=1)]]
    for frame, step in enumerate(steps, start=2):
        for action in step:
            name, arguments = (
                action["action"],
                {key: value for key, value in action.items() if key != "action"},
            )
            replies.append([_call(name, **arguments), _call("render_current")])
        replies.append([_call("save_checkpoint", frame=frame)])
    (home / "script.json").write_text(json.dumps([{"calls": calls} for calls in replies]))
    return f"scripted:{home / 'script.json'}"


def _call(tool: str, **arguments: Any) -> dict[str, Any]:
    return {"tool": tool, "arguments": arguments}


def first_frames(source: Path, folder: Path, frames: int) -> Path:
    """The first frames of a sequence as a sequence of its own."""
    manifest = json.loads((source / "keyframes.json").read_text())
    folder.mkdir(parents=True)
    shutil.copytree(source / "frames", folder / "frames")
    shortened = manifest | {"keyframes": manifest["keyframes"][:frames]}
    (folder / "keyframes.json").write_text(json.dumps(shortened))
    return folder


def kill_often(plan: KillPlan, home: Path) -> KillReport:
    """Run, kill and resume, and compare every complete run with an undisturbed one. Tells on stderr how far it is."""
    report = KillReport()
    undisturbed = home / "undisturbed"
    _command(plan, undisturbed).wait()
    expected = _program(undisturbed)
    while report.kills < plan.kills:
        run = home / f"run{report.runs + 1}"
        while not _work(plan, run, report):
            pass
        report.runs += 1
        report.faults += [f"{run.name}: {fault}" for fault in faults_in(run, expected)]
        sys.stderr.write(f"client kills: {report.kills} of {plan.kills}, {len(report.faults)} faults\n")
    return report


def _work(plan: KillPlan, run: Path, report: KillReport) -> bool:
    """Start or resume a run and kill it, or let it end once there were enough kills; whether it is complete."""
    rng = random.Random(f"{plan.seed}/{report.kills}/{report.runs}")
    before = _size(run)
    with _command(plan, run) as process:
        if report.kills < plan.kills:
            aimed = report.kills % 2 == 1
            moment = _at_a_call(run, rng.randrange(plan.calls)) if aimed else _after_a_while(run, before, rng)
            while process.poll() is None and not next(moment):
                time.sleep(POLL_SECONDS)
            if process.poll() is None:
                process.kill()
                report.kills += 1
        process.wait()
    events = list(read_events(run / "events.jsonl")) if _size(run) else []
    report.in_flight += process.returncode < 0 and bool(events) and events[-1]["kind"] == "call"
    if process.returncode >= 0:
        report.calls += sum(event["kind"] == "result" for event in events)
    return process.returncode >= 0


def _at_a_call(run: Path, wanted: int) -> Iterator[bool]:
    """True when a call of a process has no answer yet: so many as are ``wanted`` are let pass."""
    passed, last = 0, _size(run)
    while True:
        size, line = _size(run), _last_line(run)
        is_call = size > last and b'"kind": "call"' in line
        passed += is_call
        last = size
        yield is_call and passed > wanted


def _after_a_while(run: Path, before: int, rng: random.Random) -> Iterator[bool]:
    """True when so much time has passed since the first event of a process."""
    wait = rng.uniform(0, LONGEST_SECONDS)
    while _size(run) == before:
        yield False
    end = time.monotonic() + wait
    while True:
        yield time.monotonic() > end


def _size(run: Path) -> int:
    try:
        return (run / "events.jsonl").stat().st_size
    except FileNotFoundError:
        return 0


def _last_line(run: Path) -> bytes:
    try:
        with (run / "events.jsonl").open("rb") as file:
            file.seek(max(0, _size(run) - 4096))
            return file.read().rstrip(b"\n").rpartition(b"\n")[2]
    except FileNotFoundError:
        return b""


def _command(plan: KillPlan, run: Path) -> "subprocess.Popen[bytes]":
    """The command that begins a run, or goes on with one that has begun."""
    anew = ["run", str(plan.sequence), "--model", plan.model, "--out", str(run)]
    words = ["run", "--resume", str(run)] if (run / "run.json").exists() else anew
    quiet = subprocess.DEVNULL
    return subprocess.Popen([sys.executable, "-m", "folding_client", *words], stdout=quiet, stderr=quiet)


def _program(run: Path) -> Any:
    return json.loads((run / "program.json").read_text())["steps"]


def faults_in(run: Path, expected: Any) -> list[str]:
    """The first thing that is not as in an undisturbed run, if anything is."""
    about = json.loads((run / "run.json").read_text())
    events = list(read_events(run / "events.jsonl"))
    checks: tuple[tuple[Callable[[], object], str], ...] = (
        (lambda: about["outcome"]["status"] == "complete", f"it ended {about['outcome']['status']}"),
        (lambda: _program(run) == expected, "another program"),
        (
            lambda: set(map(int, about["decided"])) >= set(range(2, about["outcome"]["frames"] + 1)),
            "undecided frames",
        ),
        (lambda: not list(gaps(events)), "lines are missing"),
        (lambda: not _unanswered(events), "a change without an answer"),
        (lambda: not asyncio.run(replay_run(run)).differences, "a replay that differs"),
    )
    return next(([fault] for holds, fault in checks if not holds()), [])


def _unanswered(events: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The changes of the run after which no answer comes."""
    following = [*events[1:], None]
    kinds = {"server_lost", "server_restarted", "resumed"}
    return [
        event
        for event, after in zip(events, following, strict=True)
        if event["kind"] == "call"
        and event["request_id"]
        and (after is None or after["kind"] not in {"result", *kinds})
    ]


if __name__ == "__main__":
    main()
