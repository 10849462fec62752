"""How long a photograph takes and how large it is, by level. Prints JSON.

Seconds per frame by the clock and of the processor, kilobytes.

    python benchmarks/photographer.py [PROGRAM.json ...] [--seed N]
"""

import argparse
import json
import sys
import time
from pathlib import Path
from statistics import mean
from tempfile import TemporaryDirectory
from typing import Any

from folding_schemas.actions import Program
from folding_server.photographer import photograph
from folding_server.photographer.levels import LEVELS

DEFAULT = Path(__file__).parent / "reconstruction" / "programs"
NAMES = ("cup", "fan", "samurai_hat")


def measured(program: Program, seed: int, level: int) -> dict[str, float]:
    """Seconds per frame, the largest photo and the size of the truth of one program."""
    with TemporaryDirectory() as folder:
        start, busy = time.perf_counter(), time.process_time()
        frames = photograph(program, Path(folder), seed, level).frames
        seconds, busy = time.perf_counter() - start, time.process_time() - busy
        photos = [path.stat().st_size for path in Path(folder, "frames").iterdir()]
        truth = Path(folder, "truth.json").stat().st_size
    return {
        "seconds": seconds / frames,
        "cpu": busy / frames,
        "photo_kb": max(photos) / 1000,
        "truth_kb": truth / 1000,
    }


def main() -> None:
    """Photograph the programs at every level and print what it took."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("programs", nargs="*", type=Path, default=[DEFAULT / f"{n}.json" for n in NAMES])
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    programs = [Program.model_validate_json(path.read_text(encoding="utf-8")) for path in options.programs]
    answer: dict[str, Any] = {"programs": [program.name for program in programs], "levels": {}}
    for level in LEVELS:
        rows = [measured(program, options.seed, level) for program in programs]
        answer["levels"][level] = {
            "seconds_per_frame": round(mean(row["seconds"] for row in rows), 3),
            "cpu_seconds_per_frame": round(mean(row["cpu"] for row in rows), 3),
            "largest_photo_kb": round(max(row["photo_kb"] for row in rows), 1),
            "largest_truth_kb": round(max(row["truth_kb"] for row in rows), 1),
        }
    json.dump(answer, sys.stdout, indent=1)
    sys.stdout.write("\n")


if __name__ == "__main__":
    main()
