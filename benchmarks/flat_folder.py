"""Deciding foldability beside Flat-Folder: a clone that the person names runs in node, one pattern after the other.

Both are asked for one layer order, of the same files, each in a process of its own, and take turns. What each needs to start and to
load is not counted. Each pattern is a line of the file of results as soon as it is measured.
"""

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from signal import SIGKILL, SIGXCPU
from statistics import median
from typing import Any

DRIVER = Path(__file__).with_suffix(".mjs")
FACES = (500, 6000)
"""Faces of the patterns that are compared, from and to."""
OUT_OF_TIME = "out of time"
STOPPED = {-SIGXCPU, -SIGKILL}
"""How a process ends that has used up its processor time."""


def patterns_of(clone: Path, every: int) -> list[tuple[int, Path]]:
    """The examples of a clone with so many faces as are compared, by number of faces, each so many-th of them."""
    found = []
    for file in (clone / "examples").rglob("*.fold"):
        faces = len(json.loads(file.read_text(encoding="utf-8")).get("faces_vertices", ()))
        if FACES[0] <= faces <= FACES[1]:
            found.append((faces, file))
    return sorted(found)[::every]


def limited(command: list[str], seconds: float) -> "subprocess.CompletedProcess[str]":
    """A command run to its end, or until it has used so many processor seconds."""
    command = ["bash", "-c", f'ulimit -t {ceil(seconds)} && exec "$0" "$@"', *command]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def out_of_time(seconds: float, wall: float) -> dict[str, Any]:
    """What is noted of a process that did not end within its processor seconds: these count as its time."""
    return {"states": None, "refused": OUT_OF_TIME, "seconds": wall, "cpu": seconds}


def measured_by_flat_folder(clone: Path, file: Path, seconds: float, limit: str = "1") -> dict[str, Any]:
    """What Flat-Folder found and how long it took; its time is the limit, in processor seconds, where it did not end."""
    command = ["node", "--max-old-space-size=6000", str(DRIVER), str(clone.resolve()), limit]
    started = time.perf_counter()
    run = limited([*command, str(file.resolve())], seconds)
    if run.returncode in STOPPED:
        return out_of_time(seconds, time.perf_counter() - started)
    lines = [line for line in run.stdout.splitlines() if line.startswith('{"flat_folder"')]
    if not lines:
        return {"states": None, "refused": run.stderr.strip()[-100:], "seconds": None, "cpu": None}
    found: dict[str, Any] = json.loads(lines[-1])
    return found


def measured_by_us(file: Path, seconds: float, cap: int = 1) -> dict[str, Any]:
    """The same of our own, in a process of its own."""
    started = time.perf_counter()
    run = limited([sys.executable, str(Path(__file__)), str(file), str(cap)], seconds)
    if run.returncode in STOPPED:
        return out_of_time(seconds, time.perf_counter() - started)
    found: dict[str, Any] = json.loads(run.stdout)
    return found


def differ(ours: dict[str, Any], theirs: dict[str, Any]) -> bool:
    """Whether both found something, and not the same."""
    return None not in {ours["states"], theirs["states"]} and ours["states"] != theirs["states"]


def ratio_of(ours: dict[str, Any], theirs: dict[str, Any]) -> float | None:
    """Our processor seconds over Flat-Folder's; at most so much where Flat-Folder did not end, at least where ours did not.

    None where Flat-Folder refuses the pattern, where neither ended, and where both did and found different things.
    """
    if theirs["states"] is None and theirs["refused"] != OUT_OF_TIME:
        return None
    if theirs["states"] == ours["states"] is None or differ(ours, theirs):
        return None
    return round(float(ours["cpu"] / theirs["cpu"]), 3)


def kept_rows(results: Path | None) -> dict[str, dict[str, Any]]:
    """What a file of results holds, by pattern; of several lines about one the last counts."""
    lines = results.read_text(encoding="utf-8").splitlines() if results and results.exists() else []
    return {row["pattern"]: row for row in map(json.loads, lines)}


@dataclass(frozen=True)
class SideBySide:
    """What is compared, and how.

    ``clone``       of Flat-Folder
    ``every``       each so many-th of its examples
    ``seconds``     processor seconds that each side may take for one
    ``results``     file with one JSON line a pattern; what is there is not measured again
    ``ours_again``  of what is there, Flat-Folder's part stays and ours is measured again
    """

    clone: Path
    every: int = 1
    seconds: float = 600
    results: Path | None = None
    ours_again: bool = False

    def row(self, faces: int, file: Path, kept: dict[str, Any] | None) -> dict[str, Any]:
        """What both found in one pattern."""
        theirs = kept["flat_folder"] if kept else measured_by_flat_folder(self.clone, file, self.seconds)
        ours = measured_by_us(file, self.seconds)
        row = {"pattern": file.stem, "faces": faces, "ratio": ratio_of(ours, theirs)}
        sys.stderr.write(
            f"{faces} faces: {ours['cpu']:.1f} s, Flat-Folder {theirs['cpu']} s ({theirs['refused']})\n"
        )
        return {**row, "ours": ours, "flat_folder": theirs}

    def rows(self) -> Iterator[dict[str, Any]]:
        """Each pattern, noted in the file of results as soon as it is measured."""
        kept = kept_rows(self.results)
        for faces, file in patterns_of(self.clone, self.every):
            row = kept.get(file.stem)
            if row is None or self.ours_again:
                row = self.row(faces, file, row)
                if self.results:
                    with self.results.open("a", encoding="utf-8") as lines:
                        lines.write(json.dumps(row) + "\n")
            yield row


def side_by_side(comparison: SideBySide) -> dict[str, Any]:
    """Every compared pattern with both times and their ratio, and what the ratios come to.

    Patterns that Flat-Folder refuses, that neither settles in time, or of which both find something else, are listed and not counted.
    """
    rows = list(comparison.rows())
    found = [ratio_of(row["ours"], row["flat_folder"]) for row in rows]
    ratios = [ratio for ratio in found if ratio is not None]
    return {
        "clone": str(comparison.clone),
        "patterns": rows,
        "differ": [row["pattern"] for row in rows if differ(row["ours"], row["flat_folder"])],
        "compared": len(ratios),
        "median_ratio": round(median(ratios), 3) if ratios else None,
        "largest_ratio": max(ratios, default=None),
    }


def main() -> None:
    """Check one file and print the verdict and the time, without starting and loading."""
    from folding_server.interchange.fold_reading import read_crease_pattern
    from folding_server.simulator.foldability import check_pattern

    text = Path(sys.argv[1]).read_text(encoding="utf-8")
    started, cpu = time.perf_counter(), time.process_time()
    report = check_pattern(read_crease_pattern(text), int(sys.argv[2]))
    used = {"seconds": time.perf_counter() - started, "cpu": time.process_time() - cpu}
    states = {"foldable": report.foldable, "states": str(report.states), "capped": report.capped}
    sys.stdout.write(json.dumps({**states, **used}) + "\n")


if __name__ == "__main__":
    main()
