"""What fitting creases to all photos adds to a program of which only the folds are known, not how precisely they were made. Prints JSON.

    python benchmarks/reconstruction/refinement.py --level 4 [--seed S] [--programs NAME ...] [--cache CACHE]

Each program is photographed as hands carry it out, a little beside its landmarks at levels 3 and 4 and exactly at levels 1
and 2. The program as it is written is then refined by the photos. Before and after: the distance of the farthest vertex
from its true place and whether the result is exact (`exactness.py`); `gain`, `moved` and `told` are what the refinement
says of itself. At levels 1 and 2 nothing should be told.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

from corpus import programs
from exactness import exactness
from folding_schemas.actions import Program
from folding_server.errors import FoldingError
from folding_server.frames.sequences import load_sequence
from folding_server.photographer.replaying import keyframe_papers
from folding_server.vision.seeing import see_sequence
from folding_server.vision.solver import refined
from studio import CACHE, folded_truth, photographed


def measured(program: Program, folder: Path) -> dict[str, Any]:
    """How far a program is from the truth that its photos show, as it is written and refined."""
    truth = keyframe_papers(folded_truth(folder))[-1]
    started = time.perf_counter()
    found = refined(program.steps, see_sequence(load_sequence(folder)))
    seconds = time.perf_counter() - started
    before = exactness(truth, keyframe_papers(program)[-1])
    after = exactness(truth, found.paper)
    return {
        "frames": len(program.steps) + 1,
        "told": found.told,
        "gain": round(found.gain, 1),
        "moved": round(found.moved, 4),
        "farthest": {"written": round(before.farthest, 4), "refined": round(after.farthest, 4)},
        "exact": {"written": before.holds(), "refined": after.holds()},
        "seconds_per_frame": round(seconds / len(program.steps), 3),
    }


def main() -> int:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n", maxsplit=1)[0])
    parser.add_argument("--level", type=int, choices=(1, 2, 3, 4), default=4)
    parser.add_argument("--seed", type=int, default=41)
    parser.add_argument("--programs", nargs="+", metavar="NAME")
    parser.add_argument("--cache", type=Path, default=CACHE)
    given = parser.parse_args()
    known = programs()
    rows: dict[str, Any] = {}
    for name in given.programs or known:
        folder = photographed(known[name], seed=given.seed, level=given.level, folder=given.cache)
        try:
            rows[name] = measured(known[name], folder)
        except FoldingError as error:
            rows[name] = {"refused": str(error)}
        print(f"{name}: {rows[name]}", file=sys.stderr)
    done = [row for row in rows.values() if "told" in row]
    kept = [row["exact"]["refined" if row["told"] else "written"] for row in done]
    summary = {
        "programs": len(done),
        "told": sum(row["told"] for row in done),
        "exact_written": sum(row["exact"]["written"] for row in done),
        "exact_kept": sum(kept),
    }
    print(json.dumps({"level": given.level, "seed": given.seed, **summary, "each": rows}, indent=1))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
