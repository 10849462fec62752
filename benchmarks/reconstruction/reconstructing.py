"""Two ways to reconstruct a sequence: the solver alone, greedily, or the whole of ``foldingagent run``."""

import json
import resource
import subprocess
import sys
import time
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from folding_schemas.actions import Action, Program
from folding_server.errors import FoldingError
from folding_server.frames.sequences import load_sequence
from folding_server.simulator import new_paper
from folding_server.vision.seeing import SequenceObserver, see_sequence
from folding_server.vision.solver import propose, revised

LONGEST_RUN = 3600.0
"""Seconds after which a run is given up."""


@dataclass(frozen=True)
class Reconstruction:
    """What was found.

    ``seconds`` has one entry per transition worked on; ``opening_seconds`` came before the first.
    ``memory_mb`` is the peak of the largest process; ``reason`` says why it is not ``completed``.
    """

    steps: tuple[tuple[Action, ...], ...]
    seconds: tuple[float, ...]
    opening_seconds: float
    memory_mb: float
    completed: bool
    reason: str = ""


def reconstruct(folder: Path, mode: str) -> Reconstruction:
    """Reconstruct the sequence in a folder; ``mode`` is solver or run."""
    return run_agent(folder) if mode == "run" else solve(folder)


def solve(folder: Path) -> Reconstruction:
    """The best proposal for each transition, one after the other."""
    started = time.perf_counter()
    steps: list[tuple[Action, ...]] = []
    seconds: list[float] = []
    opening, reason = 0.0, ""
    try:
        sequence = load_sequence(folder)
        observer = see_sequence(sequence)
        opening = time.perf_counter() - started
        _follow(observer, sequence.frame_count, steps, seconds)
    except FoldingError as error:
        reason = str(error)
    return Reconstruction(tuple(steps), tuple(seconds), opening, _own_peak(), not reason, reason)


def _follow(
    observer: SequenceObserver, frames: int, steps: list[tuple[Action, ...]], seconds: list[float]
) -> None:
    """Append the actions and the seconds of every transition."""
    paper = new_paper()
    for frame in range(2, frames + 1):
        started = time.perf_counter()
        best = propose(paper, observer, frame, steps=tuple(steps))[0]
        seconds.append(time.perf_counter() - started)
        steps.append(best.actions)
        paper = best.paper
    steps[:] = revised(tuple(steps), observer)


def run_agent(folder: Path) -> Reconstruction:
    """``foldingagent run`` with the geometric model and a server over stdio, as a user would start it."""
    with TemporaryDirectory(prefix="foldingagent-run-") as kept:
        out = Path(kept) / "run"
        given = ["run", str(folder), "--model", "geometric", "--out", str(out), "--json"]
        try:
            done = subprocess.run(
                [sys.executable, "-m", "folding_client", *given],
                capture_output=True,
                text=True,
                timeout=LONGEST_RUN,
                check=False,
            )
            reason = (
                "" if done.returncode == 0 else (done.stderr.strip() or "no reason given").splitlines()[-1]
            )
        except subprocess.TimeoutExpired:
            reason = f"given up after {LONGEST_RUN:.0f} s"
        return _recorded_run(out, reason)


def _recorded_run(out: Path, reason: str) -> Reconstruction:
    """What a run folder says was found."""
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    program = Program()
    if (out / "program.json").exists():
        program = Program.model_validate_json((out / "program.json").read_text(encoding="utf-8"))
    opening, seconds = step_seconds(out / "events.jsonl")
    return Reconstruction(program.steps, seconds, opening, peak, not reason, reason)


def step_seconds(events: Path) -> tuple[float, tuple[float, ...]]:
    """Seconds before the first transition, and for each transition in order of frames, from a run's events.

    Work on a frame that was interrupted to mend an earlier one counts where it was done.
    """
    spent: dict[int, float] = defaultdict(float)
    frame, since = 1, 0.0
    lines = events.read_text(encoding="utf-8").splitlines() if events.exists() else []
    for event in map(json.loads, lines):
        if event["kind"] in ("step_started", "step_over"):
            spent[frame] += event["elapsed"] - since
            frame, since = event["frame"], event["elapsed"]
    return spent.pop(1, 0.0), tuple(spent[frame] for frame in sorted(spent))


def _own_peak() -> float:
    """The peak memory of this process in megabytes; that of a parent it was started from does not count."""
    status = Path("/proc/self/status")
    if status.exists():
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
