"""Fold random programs and check every state: ``python benchmarks/sweep.py --programs 10000 --folds 8 --seed 0``.

Every action either leaves a paper on which all validators pass, or is refused with a sentence that names an edge,
crease, vertex or face, and leaves the paper as it was. Anything else is a failure, reported with the shortest program
that still shows it. Prints one JSON document.
"""

import argparse
import json
import re
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from multiprocessing import Pool
from pathlib import Path
from random import Random

from folding_schemas.actions import Action, Unfold
from folding_server.errors import ActionRefused
from folding_server.geometry.line import Point
from folding_server.simulator import Paper, apply, folded_state, new_paper
from folding_server.simulator.validity import violations
from random_programs import Plan, between_folds, folded_edges, next_fold

NAMED = re.compile(r"\[-?\d+, -?\d+\]|\b(face|fold|edge|vertex|vertices|joins) \d+", re.IGNORECASE)
SHEETS = ((1.0, 1.0),) * 4 + ((1.0, 2**0.5), (2.35, 1.0))
"""Squares, and now and then A4 or a dollar bill."""
DEEPEST = 1500
"""Faces beyond which a program is not continued: the time goes into more programs instead."""


@dataclass
class Run:
    """What became of one program; ``failure`` is (kind, detail) of the first thing that went wrong."""

    sheet: Point = (1.0, 1.0)
    actions: list[Action] = field(default_factory=list)
    places: list[tuple[Point, ...]] = field(default_factory=list)
    refused: Counter[str] = field(default_factory=Counter)
    faces: int = 1
    failure: tuple[str, str] | None = None


def run_program(seed: int, folds: int, index: int) -> Run:
    """Draw and fold one program. The draw depends on the seed and the index only."""
    random = Random(f"{seed}/{index}")
    run = Run(random.choice(SHEETS))
    paper = new_paper(run.sheet)
    for _ in range(folds):
        for plan in (between_folds(random, paper), next_fold(random, paper)):
            paper = follow(plan, paper, run)
            if run.failure or len(paper.faces) > DEEPEST:
                return run
    return run


def follow(plan: Plan, paper: Paper, run: Run) -> Paper:
    """The paper after a plan's actions, up to the first that is refused or fails."""
    action = next(plan, None)
    while action is not None:
        run.actions.append(action)
        run.places.append(named_places(paper, action))
        after, run.failure, refusal = checked(paper, action)
        if after is None:
            if refusal:
                run.refused[in_general(action, refusal)] += 1
            return paper
        paper, run.faces = after, len(after.faces)
        if run.failure:
            return paper
        try:
            action = plan.send(paper)
        except StopIteration:
            return paper
    return paper


def checked(paper: Paper, action: Action) -> tuple[Paper | None, tuple[str, str] | None, str]:
    """The paper after an action (None if there is none), what is wrong with that, if anything, and a proper refusal."""
    before = fingerprint(paper)
    try:
        after = apply(paper, action)
        found = violations(after)
        folded_state(after)
    except ActionRefused as refusal:
        if not NAMED.search(str(refusal)) and (not isinstance(action, Unfold) or folded_edges(paper)):
            return None, ("refusal names nothing", str(refusal)), ""
        return None, None if fingerprint(paper) == before else ("paper changed", str(refusal)), str(refusal)
    except Exception as error:  # noqa: BLE001 - an internal error is what the sweep looks for
        where = error.__traceback__
        while where and where.tb_next:
            where = where.tb_next
        line = f"{Path(where.tb_frame.f_code.co_filename).name}:{where.tb_lineno}" if where else "?"
        return None, (f"{type(error).__name__} at {line}", str(error)), ""
    if fingerprint(paper) != before:
        return after, ("paper changed", repr(action)), ""
    return after, (found[0].kind, "; ".join(map(str, found[:3]))) if found else None, ""


def in_general(action: Action, refusal: str) -> str:
    """What is refused and why without the numbers, so that refusals can be counted by kind."""
    return f"{action.action}: " + re.sub(r"[-+]?\d[\d.e-]*(, #)*", "#", refusal)[:70]


def fingerprint(paper: Paper) -> tuple[object, ...]:
    """What must not change when another paper is made of this one."""
    return (
        tuple(paper.vertices_coords.items()),
        tuple(paper.faces.items()),
        tuple(paper.isometries.items()),
        paper.order,
        tuple(paper.creases.items()),
    )


def named_places(paper: Paper, action: Action) -> tuple[Point, ...]:
    """Where on the sheet the vertices of an action lie, so that it can be repeated when ids have changed."""
    edge = getattr(action, "edge", None)
    return tuple(paper.vertices_coords[v] for v in edge or () if v in paper.vertices_coords)


def shortest(run: Run) -> list[Action]:
    """A program that fails in the same way with no action to spare."""
    assert run.failure, "only a run that failed can be shortened"
    kept = list(zip(run.actions, run.places, strict=True))
    best, smaller = run.actions, True
    while smaller:
        smaller = False
        for k in reversed(range(len(kept) - 1)):
            actions = again(run.sheet, [*kept[:k], *kept[k + 1 :]], run.failure[0])
            if actions is not None:
                kept, best, smaller = [*kept[:k], *kept[k + 1 :]], actions, True
    return best


def again(sheet: Point, kept: list[tuple[Action, tuple[Point, ...]]], kind: str) -> list[Action] | None:
    """The actions with vertices found by their places, if their run ends in a failure of that kind."""
    paper, actions = new_paper(sheet), []
    for action, places in kept:
        ids = [nearest(paper, place) for place in places]
        if None in ids:
            return None
        if len(ids) == 2:
            actions.append(action.model_copy(update={"edge": tuple(ids)}))
        else:
            actions.append(action)
        after, failure, _ = checked(paper, actions[-1])
        if failure:
            return actions if failure[0] == kind else None
        paper = after or paper
    return None


def nearest(paper: Paper, place: Point) -> int | None:
    """The vertex at a place on the sheet."""
    distance, vertex = min(
        (abs(x - place[0]) + abs(y - place[1]), v) for v, (x, y) in paper.vertices_coords.items()
    )
    return vertex if distance < 1e-9 else None


def sweep(programs: int, folds: int, seed: int, jobs: int, first: int = 0) -> Iterator[tuple[int, Run]]:
    """Run programs ``first`` and on, in processes; yields (index, run) in order."""
    indices = range(first, first + programs)
    with Pool(jobs) as pool:
        yield from zip(
            indices, pool.imap(partial(run_program, seed, folds), indices, chunksize=4), strict=True
        )


def main() -> int:
    """Parse the command line, sweep, print the summary; 1 if anything failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", type=int, default=10_000)
    parser.add_argument("--folds", type=int, default=8)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--first", type=int, default=0, help="index of the first program")
    parser.add_argument(
        "--show", type=int, default=4, help="failing programs of each kind to shorten and print"
    )
    options = parser.parse_args()
    started, failing = time.perf_counter(), []
    failures: Counter[str] = Counter()
    count: Counter[str] = Counter()
    refused: Counter[str] = Counter()
    for index, run in sweep(options.programs, options.folds, options.seed, options.jobs, options.first):
        count.update(programs=1, actions=len(run.actions), refused=run.refused.total(), faces=run.faces)
        refused.update(run.refused)
        if run.failure:
            failures[run.failure[0]] += 1
            if failures[run.failure[0]] <= options.show:
                failing.append(
                    {
                        "seed": options.seed,
                        "index": index,
                        "kind": run.failure[0],
                        "detail": run.failure[1],
                        "sheet": run.sheet,
                        "program": [a.model_dump(mode="json") for a in shortest(run)],
                    }
                )
        if count["programs"] % 500 == 0:
            print(f"{count['programs']} programs, {sum(failures.values())} failures", file=sys.stderr)
    print(
        json.dumps(
            {
                "programs": count["programs"],
                "actions": count["actions"],
                "refused_share": round(count["refused"] / max(1, count["actions"]), 4),
                "mean_faces": round(count["faces"] / max(1, count["programs"]), 1),
                "refused": dict(refused.most_common()),
                "failures": dict(failures),
                "seconds": round(time.perf_counter() - started, 1),
                "failing": failing,
            },
            indent=1,
        )
    )
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
