"""How often the verdict on a state is right: true states and wrong ones against photographs. Prints JSON.

    python benchmarks/verdicts.py --levels 1 2 3 --seeds 100 101 [--programs NAME ...] [--rows]

Every frame of every photographed program is compared with the state that it shows, and with its neighbours: the
state before, the state after, the fold moved by 0.01, 0.02 and 0.04 of the sheet, the same line folding other
layers, and a flip in place of what was done. A wrong state is *visible* if a perfect label image of the true
one differs from it in more than 1.5 % of the paper after the best small motion; others no outline can tell.
Seeds below 100 are for choosing thresholds, figures that are reported anywhere use seeds from 100 on.
"""

import argparse
import json
import sys
import tempfile
import time
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from multiprocessing import Pool
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from folding_schemas.actions import Action, Flip, Fold, Program
from folding_server.errors import ActionRefused, PhotoError
from folding_server.frames.sequences import load_sequence
from folding_server.geometry.line import Line
from folding_server.interchange.programs import load_program
from folding_server.photographer import photograph
from folding_server.photographer.replaying import keyframe_papers
from folding_server.simulator import Paper, apply
from folding_server.simulator.fold import fold_line
from folding_server.vision.comparison import compare
from folding_server.vision.labels import as_one_colour
from folding_server.vision.raster import draw_paper
from folding_server.vision.registration.paper_alignment import align_paper
from folding_server.vision.registration.scene import Scene
from folding_server.vision.seeing import Observation, see_sequence
from folding_server.vision.solver.movable_layers import MovableLayers, MovingSet
from folding_server.vision.solver.realise import realise

HERE = Path(__file__).resolve().parent
FOLDERS = (HERE / "reconstruction" / "programs", HERE.parent / "examples" / "programs")
SHIFTS = (0.01, 0.02, 0.04)
"""Sheet units by which a fold is moved."""
VISIBLE = 0.985
"""A wrong state whose drawing agrees with the true one's by less is visible."""
TRUE = "true"


@dataclass(frozen=True)
class Row:
    """One comparison; ``likeness`` is the agreement with a perfect label image of the true state."""

    program: str
    level: int
    seed: int
    frame: int
    kind: str
    likeness: float
    verdict: str
    agreement: float
    lines: float
    widest: float
    longest_missing: float
    outline_worst: float
    seconds: float


def main() -> None:
    """Compare what the command line asks for."""
    options = _options()
    known = programs()
    tasks = [
        (known[name], level, seed)
        for name in options.programs or known
        for level in options.levels
        for seed in options.seeds
    ]
    rows: list[Row] = []
    refused: list[str] = []
    with Pool(options.jobs, maxtasksperchild=4) as pool:
        for found, refusal in pool.imap(partial(_measured, most=options.frames), tasks):
            rows += found
            refused += [refusal] if refusal else []
            sys.stderr.write(f"{len(rows)} comparisons\n")
    document: dict[str, object] = {
        "settings": _settings(options),
        "refused": refused,
        "levels": by_level(rows),
    }
    if options.rows:
        document["rows"] = [asdict(row) for row in rows]
    json.dump(document, sys.stdout, indent=1)
    sys.stdout.write("\n")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--levels", nargs="+", type=int, choices=(1, 2, 3), default=[1, 2, 3])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1], help="development: 1 to 99")
    parser.add_argument(
        "--programs", nargs="+", metavar="NAME", choices=sorted(programs()), help="only these"
    )
    parser.add_argument("--frames", type=int, default=8, help="at most so many frames of each sequence")
    parser.add_argument("--jobs", type=int, default=1, help="sequences at a time")
    parser.add_argument("--rows", action="store_true", help="print every comparison too")
    return parser.parse_args()


def _settings(options: argparse.Namespace) -> dict[str, Any]:
    return {"levels": options.levels, "seeds": options.seeds, "programs": options.programs or "all"}


def programs() -> dict[str, Program]:
    """The benchmark's programs and the examples', by name."""
    paths = sorted(path for folder in FOLDERS for path in folder.glob("*.json"))
    return {path.stem: load_program(path.read_text(encoding="utf-8")) for path in paths}


def _measured(task: tuple[Program, int, int], most: int) -> tuple[list[Row], str]:
    """All comparisons for one photographed program, or the sentence with which its photos were refused."""
    program, level, seed = task
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        try:
            photograph(program, folder, zlib.crc32(f"{program.name}:{seed}".encode()), level)
            return list(_compared(folder, program.name, level, seed, most)), ""
        except PhotoError as error:
            return [], f"{program.name}, level {level}, seed {seed}: {error}"


def _compared(folder: Path, name: str, level: int, seed: int, most: int) -> Iterator[Row]:
    """Every state that competes for each of at most so many frames, evenly spaced, after the first."""
    folded = load_program((folder / "program.json").read_text(encoding="utf-8"))
    papers, steps = keyframe_papers(folded), folded.steps
    observer = see_sequence(load_sequence(folder))
    for index in sorted({round(i) for i in np.linspace(1, len(papers) - 1, min(most, len(papers) - 1))}):
        seen = observer.frame(index + 1)
        ideal = _ideal(papers[index], seen)
        for kind, paper in candidates(papers, steps, index):
            started = time.perf_counter()
            match = compare(paper, seen)
            seconds = time.perf_counter() - started
            likeness = 1.0 if kind == TRUE else align_paper(paper, ideal, seen.scales).agreement
            yield Row(
                name,
                level,
                seed,
                index + 1,
                kind,
                round(likeness, 4),
                match.verdict,
                round(match.agreement, 4),
                round(match.lines, 3),
                round(max((d.width for d in match.discrepancies), default=0.0), 4),
                round(match.longest_missing, 3),
                round(match.outline_worst, 4),
                round(seconds, 3),
            )


def _after(paper: Paper, actions: Sequence[Action]) -> Paper:
    for action in actions:
        paper = apply(paper, action)
    return paper


def _ideal(truth: Paper, seen: Observation) -> Scene:
    """A perfect label image of the true state where the photo shows it, nothing hidden."""
    motion = align_paper(truth, Scene(seen.grid, seen.labels, seen.two_coloured), seen.scales).motion
    labels = draw_paper(truth, seen.grid, motion)
    return Scene(seen.grid, labels if seen.two_coloured else as_one_colour(labels), seen.two_coloured)


def candidates(
    papers: list[Paper], steps: Sequence[Sequence[Action]], index: int
) -> Iterator[tuple[str, Paper]]:
    """The true state of a frame, counted from 0, and its wrong neighbours, with what is wrong with each."""
    before = papers[index - 1]
    yield TRUE, papers[index]
    yield "state before", before
    if index + 1 < len(papers):
        yield "state after", papers[index + 1]
    if not any(isinstance(action, Flip) for action in steps[index - 1]):
        yield "flipped", apply(before, Flip(axis="x"))
    last = steps[index - 1][-1]
    if isinstance(last, Fold):
        yield from _other_folds(_after(before, steps[index - 1][:-1]), last)


def _other_folds(paper: Paper, action: Fold) -> Iterator[tuple[str, Paper]]:
    """Folds along parallels of a fold's line, and along the line itself with other layers."""
    line, leaves = fold_line(paper, action.edge, action.direction), MovableLayers(paper)
    moved = frozenset(
        f for f, t in apply(paper, action).isometries.items() if t != paper.isometries.get(f, t)
    )
    sets = list(leaves.moving_sets(line))
    if not sets:
        return
    truth = max(sets, key=lambda found: len(found.faces & moved) - len(found.faces - moved))
    for shift in SHIFTS:
        beside = leaves.moving_from(Line(line.nx, line.ny, line.offset + shift), truth.seed)
        if beside is not None and beside.faces == truth.faces:
            yield from _first(f"fold moved by {shift}", paper, beside)
    for other in sets:
        if other.faces != truth.faces:
            yield from _first("other layers", paper, other)


def _first(kind: str, paper: Paper, moving: MovingSet) -> Iterator[tuple[str, Paper]]:
    """The state that one predicted fold leads to, if any actions make it."""
    try:
        made = realise(paper, moving, exact=True)
    except ActionRefused:
        return
    if made:
        yield kind, made[0][1]


def by_level(rows: Sequence[Row]) -> dict[str, Any]:
    """For each level and kind of state how the verdicts went."""
    return {
        str(level): {
            kind: _summary([r for r in rows if (r.level, r.kind) == (level, kind)], kind)
            for kind in dict.fromkeys(r.kind for r in rows)
            if any((r.level, r.kind) == (level, kind) for r in rows)
        }
        for level in sorted({r.level for r in rows})
    }


def _summary(rows: list[Row], kind: str) -> dict[str, Any]:
    """Shares of verdicts, for wrong states among the visible ones too, and how the agreement is distributed."""
    low, middle, high = (
        round(float(q), 4) for q in np.quantile([r.agreement for r in rows], (0.02, 0.5, 0.98))
    )
    summary: dict[str, Any] = {"states": len(rows), "match": _share(rows, "MATCH")}
    if kind != TRUE:
        visible = [r for r in rows if r.likeness < VISIBLE]
        summary |= {"visible": len(visible), "visible_match": _share(visible, "MATCH")}
    return summary | {
        "extreme_divergence": _share(rows, "EXTREME DIVERGENCE"),
        "agreement": {"q02": low, "median": middle, "q98": high},
        "seconds_median": round(median(r.seconds for r in rows), 3),
    }


def _share(rows: list[Row], verdict: str) -> float | None:
    """The share of a verdict, None of none."""
    return round(sum(r.verdict == verdict for r in rows) / len(rows), 4) if rows else None


if __name__ == "__main__":
    main()
