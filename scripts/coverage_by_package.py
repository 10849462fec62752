"""Lines and branches that the tests run, for each package, with the reference data and without it.

    scripts/coverage [--jobs N] [ARGUMENTS OF PYTEST]

Prints one JSON document: percentages with and without, and by how many points they fall. Exits with 1 if a package
falls by more than it may. What subprocesses of the tests run is not measured.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("folding_schemas", "folding_prompts", "folding_server", "folding_client")
MOST_FALL = 2.0
"""By how many points a package may fall without the reference data."""
TESTS_FAILED = 1
"""The exit code of pytest if it ran all tests and some failed."""
Counts = Mapping[str, Counter[str]]
"""For each package, how many statements and branches it has and how many were run."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure twice, print the comparison, and say whether a package falls too far."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--jobs", default="auto", help="tests at a time, as pytest-xdist takes it")
    options, for_pytest = parser.parse_known_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        empty = Path(folder) / "empty"
        empty.mkdir()
        measured = {
            "with": measure(Path(folder), options.jobs, for_pytest, {"FOLDING_REQUIRE_REFERENCE": "1"}),
            "without": measure(
                Path(folder), options.jobs, for_pytest, {"FOLDING_REFERENCE_DATA": str(empty)}
            ),
        }
    compared = {package: compare(measured, package) for package in sorted(measured["with"])}
    json.dump(compared, sys.stdout, indent=1)
    sys.stdout.write("\n")
    return int(any(kind["fall"] > MOST_FALL for package in compared.values() for kind in package.values()))


def measure(folder: Path, jobs: str, for_pytest: Sequence[str], environment: Mapping[str, str]) -> Counts:
    """Run the tests once and count what they run. SystemExit if they cannot be run to the end."""
    report = folder / "coverage.json"
    command = [
        *(sys.executable, "-m", "pytest", "-n", jobs),
        *(f"--cov={package}" for package in PACKAGES),
        *("--cov-branch", f"--cov-report=json:{report}", *for_pytest),
    ]
    settings = {**os.environ, "COVERAGE_FILE": str(folder / "coverage"), **environment}
    done = subprocess.run(command, cwd=ROOT, env=settings, stdout=sys.stderr, check=False)
    if done.returncode == TESTS_FAILED:
        sys.stderr.write("coverage: some tests failed, so what they would have run after that is missing\n")
    elif done.returncode:
        sys.exit(f"coverage: pytest ended with {done.returncode} and could not run the tests")
    return counted(json.loads(report.read_text(encoding="utf-8"))["files"])


def counted(files: Mapping[str, Any]) -> Counts:
    """The counts of coverage's report, added up for each package."""
    counts: dict[str, Counter[str]] = {}
    for name, file in files.items():
        summary = file["summary"]
        counts.setdefault(package_of(Path(name)), Counter()).update(
            lines=summary["num_statements"],
            lines_run=summary["covered_lines"],
            branches=summary["num_branches"],
            branches_run=summary["covered_branches"],
        )
    return counts


def package_of(file: Path) -> str:
    """The package of a file: of the server and the client the folder in it, such as ``folding_server.vision``."""
    parts = file.parts[next(i for i, part in enumerate(file.parts) if part in PACKAGES) :]
    deep = parts[0] in {"folding_server", "folding_client"} and len(parts) > 2
    return ".".join(parts[:2]) if deep else parts[0]


def compare(measured: Mapping[str, Counts], package: str) -> dict[str, dict[str, float]]:
    """Percentages of lines and branches with and without the reference data, and the fall in points."""
    compared = {}
    for kind in ("lines", "branches"):
        parts = {name: percentage(counts[package], kind) for name, counts in measured.items()}
        compared[kind] = {**parts, "fall": round(parts["with"] - parts["without"], 2)}
    return compared


def percentage(counts: Counter[str], kind: str) -> float:
    """How many percent of a kind were run; 100 where there is nothing to run."""
    return round(100 * counts[f"{kind}_run"] / counts[kind], 2) if counts[kind] else 100.0


if __name__ == "__main__":
    sys.exit(main())
