"""Deciding foldability beside Flat-Folder: a clone that the person names runs in node, one pattern after the other.

Both are asked for one layer order, of the same files, each in a process of its own, and take turns. What each needs to start and to
load is not counted.
"""

import json
import subprocess
import sys
import time
from math import ceil
from pathlib import Path
from signal import SIGKILL, SIGXCPU
from statistics import median
from typing import Any

DRIVER = Path(__file__).with_suffix(".mjs")
FACES = (500, 6000)
"""Faces of the patterns that are compared, from and to."""
OUT_OF_TIME = {-SIGXCPU, -SIGKILL}
"""How a process ends that has used up its processor time."""


def patterns_of(clone: Path, every: int) -> list[tuple[int, Path]]:
    """The examples of a clone with so many faces as are compared, by number of faces, each so many-th of them."""
    found = []
    for file in (clone / "examples").rglob("*.fold"):
        faces = len(json.loads(file.read_text(encoding="utf-8")).get("faces_vertices", ()))
        if FACES[0] <= faces <= FACES[1]:
            found.append((faces, file))
    return sorted(found)[::every]


def measured_by_flat_folder(clone: Path, file: Path, seconds: float, limit: str = "1") -> dict[str, Any]:
    """What Flat-Folder found and how long it took; its time is the limit, in processor seconds, where it did not end."""
    command = [
        "node",
        "--max-old-space-size=6000",
        str(DRIVER),
        str(clone.resolve()),
        limit,
        str(file.resolve()),
    ]
    command = ["bash", "-c", f'ulimit -t {ceil(seconds)} && exec "$0" "$@"', *command]
    started = time.perf_counter()
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode in OUT_OF_TIME:
        return {
            "states": None,
            "refused": "out of time",
            "seconds": time.perf_counter() - started,
            "cpu": seconds,
        }
    lines = [line for line in run.stdout.splitlines() if line.startswith('{"flat_folder"')]
    if not lines:
        return {"states": None, "refused": run.stderr.strip()[-100:], "seconds": None, "cpu": None}
    found: dict[str, Any] = json.loads(lines[-1])
    return found


def measured_by_us(file: Path, cap: int = 1) -> dict[str, Any]:
    """The same of our own, in a process of its own."""
    command = [sys.executable, str(Path(__file__)), str(file), str(cap)]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    found: dict[str, Any] = json.loads(run.stdout)
    return found


def side_by_side(clone: Path, every: int, seconds: float) -> dict[str, Any]:
    """Every compared pattern with both times and their ratio, and what the ratios come to.

    Where Flat-Folder did not end in time the ratio is at most what is given. Patterns that it refuses are listed and not counted.
    """
    rows: list[dict[str, Any]] = []
    for faces, file in patterns_of(clone, every):
        theirs, ours = measured_by_flat_folder(clone, file, seconds), measured_by_us(file)
        counted = theirs["states"] is not None or theirs["refused"] == "out of time"
        ratio = round(ours["cpu"] / theirs["cpu"], 3) if counted else None
        rows.append(
            {"pattern": file.stem, "faces": faces, "ratio": ratio, "ours": ours, "flat_folder": theirs}
        )
        sys.stderr.write(
            f"{faces} faces: {ours['cpu']:.1f} s, Flat-Folder {theirs['cpu']} s ({theirs['refused']})\n"
        )
    ratios: list[float] = [row["ratio"] for row in rows if row["ratio"] is not None]
    return {
        "clone": str(clone),
        "patterns": rows,
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
