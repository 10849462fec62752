"""What the solver weighs, photo by photo, with what was true: the data that its weights and confidence are fitted on.

    python benchmarks/reconstruction/evidence_collection.py --levels 2 3 --seeds 41 42 [--programs NAME ...] -o FILE.jsonl
    python benchmarks/reconstruction/evidence_collection.py --tutorials -o FILE.jsonl

Every transition starts from the true state before it, so that one mistake does not spoil what follows. A line of the file
is a transition: all plans that were weighed, with the value of every term of evidence, and whether each leads to the true
state; of the best few also what the comparison with the photo says, and of the first the signs that its confidence is judged by. Seeds below 100 only: those above are for reports.
"""

import argparse
import json
import multiprocessing
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import corpus
import studio
from exactness import exactness, same_side_up
from folding_server.frames.sequences import load_sequence
from folding_server.photographer.replaying import keyframe_papers
from folding_server.simulator import Paper
from folding_server.vision.any_camera import compare_with_photo
from folding_server.vision.seeing import SequenceObserver, see_sequence
from folding_server.vision.solver.confidence import signs
from folding_server.vision.solver.plan import Plan
from folding_server.vision.solver.propose import explained
from scoring import action_class

PLANS_KEPT = 12
"""Plans of a transition that are written, the best."""
COMPARED = 3
"""Of these, so many states are held against the photo as compare_to_frame does."""


@dataclass(frozen=True)
class Task:
    """One sequence to look at: a level of 0 is a ray-traced one."""

    name: str
    level: int
    seed: int


def main(arguments: Sequence[str] | None = None) -> None:
    """Collect what the command line asks for, sequence by sequence."""
    options = _options(arguments)
    tasks = _tasks(options)
    spawn = multiprocessing.get_context("spawn")
    with (
        options.out.open("a", encoding="utf-8") as file,
        ProcessPoolExecutor(options.jobs, mp_context=spawn, max_tasks_per_child=1) as pool,
    ):
        futures = {pool.submit(collected, task): task for task in tasks}
        for done, future in enumerate(as_completed(futures), start=1):
            rows = future.result()
            file.writelines(json.dumps(row) + "\n" for row in rows)
            file.flush()
            right = sum(row["plans"][0]["right"] for row in rows)
            sys.stderr.write(f"{done}/{len(tasks)} {futures[future]}: {right} of {len(rows)}\n")


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--levels", type=int, nargs="*", default=[], help="levels of the photographer")
    parser.add_argument("--seeds", type=int, nargs="*", default=[1], help="seeds, 1 to 99")
    parser.add_argument("--programs", nargs="+", metavar="NAME", help="only these")
    parser.add_argument("--tutorials", action="store_true", help="the ray-traced photos framed anew as well")
    parser.add_argument("--jobs", type=int, default=1, help="sequences at a time")
    parser.add_argument("-o", "--out", type=Path, required=True, help="the file to add lines to")
    options = parser.parse_args(arguments)
    if kept := [seed for seed in options.seeds if not 0 < seed < 100]:
        parser.error(f"the seed {kept[0]} is not for fitting; give seeds from 1 to 99")
    return options


def _tasks(options: argparse.Namespace) -> list[Task]:
    names = options.programs or list(corpus.programs())
    tasks = [Task(name, level, seed) for seed in options.seeds for level in options.levels for name in names]
    return tasks + [Task(name, 0, 0) for name in corpus.rendered(corpus.TUTORIALS) if options.tutorials]


def collected(task: Task) -> list[dict[str, Any]]:
    """One row for each transition of a sequence."""
    if task.level == 0:
        subject = corpus.rendered(corpus.TUTORIALS)[task.name]
    else:
        folder = studio.photographed(
            corpus.programs()[task.name], seed=task.seed, level=task.level, folder=studio.CACHE
        )
        subject = corpus.Subject(task.name, folder, studio.folded_truth(folder), corpus.TOLERANCE)
    observer = see_sequence(load_sequence(subject.folder))
    papers = keyframe_papers(subject.truth)
    rows = []
    for frame, step in enumerate(subject.truth.steps, start=2):
        plans = explained(papers[frame - 2], observer, frame)
        rows.append(
            {
                **asdict(task),
                "frame": frame,
                "true": list(action_class(step)),
                "signs": signs(plans),
                "plans": list(
                    _rows(plans[:PLANS_KEPT], papers[frame - 1], observer, frame, subject.tolerance)
                ),
            }
        )
    return rows


def _rows(
    plans: Sequence[Plan], truth: Paper, observer: SequenceObserver, frame: int, tolerance: float
) -> Iterator[dict[str, Any]]:
    """Plans of a transition, the best first, as rows."""
    for rank, plan in enumerate(plans):
        right = exactness(truth, plan.paper, tolerance).holds(tolerance) and same_side_up(truth, plan.paper)
        compared = _compared(plan, observer, frame) if rank < COMPARED else None
        yield {
            "class": plan.action_class,
            "actions": list(action_class(plan.actions)),
            "right": right,
            "score": plan.score,
            "evidence": plan.evidence.values,
            "compared": compared,
        }


def _compared(plan: Plan, observer: SequenceObserver, frame: int) -> dict[str, Any]:
    """What compare_to_frame measures of the state that a plan leads to."""
    found = compare_with_photo(plan.paper, observer, frame)
    match = found.match
    return {
        "verdict": match.verdict,
        "agreement": match.agreement,
        "outline": match.outline_distance,
        "worst": match.outline_worst,
        "lines": match.lines,
        "missing": match.longest_missing,
        "widest": max((d.width for d in match.discrepancies), default=0.0),
        "hidden": match.hidden,
        "cut": match.cut,
        "clear": found.seen.paper_confidence,
        "own_camera": found.estimate is not None,
    }


if __name__ == "__main__":
    main()
