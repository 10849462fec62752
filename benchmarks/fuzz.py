"""Send a server malformed and hostile calls: ``python benchmarks/fuzz.py --calls 20000 --seed 1`` prints JSON.

Four of five go to a server process over HTTP with tokens, the others over stdio, in the protocol of 2026-07-28 and in
those before. Values are of the wrong kind, huge, deep, not numbers, half characters, paths, names of a megabyte; tools,
methods, addresses, prompts, cursors and request ids are unknown; run ids are other owners'; JSON is broken, bodies are cut
or too large, headers lie. Every answer has to be a typed error, one sentence, or a true answer, without a path of the
machine. At the end the processes live, their memory has not grown, a run of another owner is what it was, nothing was
logged that is a fault of the server's own, and a program folds as ever. Exits with 1 where that is not so.
"""

import argparse
import json
import random
import re
import subprocess
import sys
import tempfile
from collections import Counter
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fuzz_http import HttpTarget, http_target
from fuzz_stdio import StdioTarget, stdio_target

STDIO_SHARE = 5
"""One of so many calls goes over stdio."""
SAMPLES = 10
"""How often memory is looked at on the way."""
MOST_GROWTH = 40.0
"""Megabytes by which a process may grow in the second half of the calls; in the first it loads what it needs and fills its caches."""
FEWEST_CALLS = 2000
"""With fewer calls memory is told and not judged: loading OpenCV once is more than that."""
SHOWN_FAULTS = 40
ROOT = Path(__file__).resolve().parent.parent
SEQUENCES = ROOT / "examples"

Target = HttpTarget | StdioTarget


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--calls", type=int, default=20_000, help="calls in all (default 20000)")
    parser.add_argument("--seed", type=int, default=0, help="of the calls (default 0)")
    options = parser.parse_args()
    reports = fuzz(options.calls, options.seed)
    json.dump({"seed": options.seed, **reports}, sys.stdout, indent=2)
    sys.stdout.write("\n")
    sys.exit(1 if any(report["faults"] for report in reports.values()) else 0)


def fuzz(calls: int, seed: int) -> dict[str, dict[str, Any]]:
    """A report for each process: over HTTP, over stdio now and over stdio as it was."""
    stdio = calls // STDIO_SHARE
    with tempfile.TemporaryDirectory() as folder:
        at = Path(folder)
        places = (folder, str(Path.home()), str(ROOT), sys.prefix, sys.base_prefix)
        return {
            "http": _fuzzed(
                http_target(at, SEQUENCES, at / "http.log", places), at / "http.log", calls - stdio, seed
            ),
        } | {
            name: _fuzzed(stdio_target(at, SEQUENCES, at / name, places, modern), at / name, stdio // 2, seed)
            for name, modern in (("stdio", True), ("stdio with sessions", False))
        }


def _fuzzed(opened: AbstractContextManager[Target], log: Path, calls: int, seed: int) -> dict[str, Any]:
    """What comes of the calls to one process."""
    report = Report()
    with opened as target:
        for number in range(calls):
            kind, answer, fault = target.call(random.Random(f"{seed}/{number}"), number)
            report.add(kind, answer, fault and f"call {number}: {fault}")
            if number % max(calls // SAMPLES, 1) == 0:
                report.megabytes.append(_megabytes(target.process.pid))
                sys.stderr.write(f"fuzz: {number} of {calls}, {len(report.faults)} faults\n")
        report.megabytes.append(_megabytes(target.process.pid))
        report.faults += target.faults_at_the_end()
    if calls >= FEWEST_CALLS and report.growth > MOST_GROWTH:
        report.faults.append(f"memory has grown: {report.megabytes} MB")
    report.faults += [f"logged {times} times: {error}" for error, times in _logged(log).items()]
    return report.figures()


def _logged(log: Path) -> Counter[str]:
    """The errors that a process logged with a traceback, by their last line: faults of its own."""
    blocks = re.split(r"^Traceback .*$", log.read_text(errors="replace"), flags=re.MULTILINE)[1:]
    return Counter(
        next((line for line in block.splitlines() if line[:1].strip()), "?")[:300] for block in blocks
    )


@dataclass
class Report:
    """What came of the calls to one process."""

    kinds: Counter[str] = field(default_factory=Counter)
    answers: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)
    megabytes: list[float] = field(default_factory=list)

    @property
    def growth(self) -> float:
        """By how much memory has grown in the second half of the calls."""
        return self.megabytes[-1] - self.megabytes[len(self.megabytes) // 2]

    def add(self, kind: str, answer: str, fault: str | None) -> None:
        """Count a call."""
        self.kinds[kind] += 1
        self.answers[answer] += 1
        if fault:
            self.faults.append(fault)

    def figures(self) -> dict[str, Any]:
        """As JSON."""
        return {
            "calls": self.kinds.total(),
            "kinds": dict(sorted(self.kinds.items())),
            "answers": dict(sorted(self.answers.items())),
            "megabytes": self.megabytes,
            "number of faults": len(self.faults),
            "faults": self.faults[:SHOWN_FAULTS],
        }


def _megabytes(process: int) -> float:
    """The memory that a process has in RAM."""
    command = ["ps", "-o", "rss=", "-p", str(process)]
    told = subprocess.run(command, capture_output=True, text=True, check=False).stdout
    return round(int(told or 0) / 1000, 1)


if __name__ == "__main__":
    main()
