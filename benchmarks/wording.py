"""Refold random programs from their words and print JSON: python benchmarks/wording.py [--programs N] [--folds N] [--seed N].

Each program is drawn by random_programs.py, near-degenerate folds and points among them. Its steps are said in English, the text
is read back and folded, and the state after every line is compared with that of the program: the same faces on the sheet, in the
same places but for a shift on the table, the same side up, in the same order. ``said_otherwise`` are steps for which no saying
leads to the state; they are the failures beside ``refolded_otherwise``. ``axioms`` counts how folds were said, and
``marked_on_sheet`` those for which only points of the unfolded sheet would do.
"""

import argparse
import json
import time
from collections import Counter
from collections.abc import Iterator
from random import Random

from folding_schemas.actions import Action, Program
from folding_server.errors import ActionRefused
from folding_server.instructions.moves import Lesson, lesson_of
from folding_server.simulator import Paper, apply, new_paper
from folding_server.wording.describing import SaidMove, say
from folding_server.wording.reading import read_line
from folding_server.wording.refolding import refold
from folding_server.wording.repeats import with_repeats
from folding_server.wording.said import OnSheet, SaidFold
from folding_server.wording.same_state import shift_between
from folding_server.wording.sentences import Sentences
from random_programs import Plan, between_folds, next_fold

MOST_FACES = 60
"""Programs end at so many faces: nobody folds more from words."""


def random_program(seed: int, folds: int) -> Program:
    """A program of up to so many folds; what is refused is left out."""
    random = Random(seed)
    paper, steps = new_paper(), list[tuple[Action, ...]]()
    for _ in range(folds):
        for plan in (between_folds(random, paper), next_fold(random, paper)):
            paper, done = followed(plan, paper)
            steps += [done] if done else []
        if len(paper.faces) > MOST_FACES:
            break
    return Program(name=f"random {seed}", steps=tuple(steps))


def followed(plan: Plan, paper: Paper) -> tuple[Paper, tuple[Action, ...]]:
    """The paper after a plan's actions, up to the first that is refused, and the actions."""
    done: list[Action] = []
    action = next(plan, None)
    while action is not None:
        try:
            paper = apply(paper, action)
            done.append(action)
            action = plan.send(paper)
        except (ActionRefused, StopIteration):
            break
    return paper, tuple(done)


def refolded(told: list[SaidMove], lesson: Lesson) -> Iterator[bool]:
    """For each move whether the paper folded from its words is in the state of the program."""
    paper = new_paper(lesson.program.sheet)
    for move, said in zip(lesson.moves, told, strict=True):
        read = read_line(Sentences("en").say(said.said))
        assert read is not None
        _, paper = refold(paper, read)
        yield shift_between(move.after, paper) is not None


def is_refolded(program: Program) -> tuple[bool, Counter[str]]:
    """Whether a program is the same when it is folded from its words, and what was counted on the way."""
    counts: Counter[str] = Counter()
    lesson = with_repeats(lesson_of(program))
    told = say(lesson)
    counts["moves"] = len(told)
    for each in told:
        if isinstance(each.said, SaidFold):
            counts[f"axiom {each.said.axiom}"] += 1
            counts["repeated"] += each.said.repeat
            counts["marked_on_sheet"] += any(isinstance(mark, OnSheet) for mark in each.said.marks)
        counts["said_otherwise"] += not each.exact
    if counts["said_otherwise"]:
        return False, counts
    right = all(refolded(told, lesson))
    counts["refolded_otherwise"] += not right
    return right, counts


def main() -> None:
    """Print what was counted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", type=int, default=1000)
    parser.add_argument("--folds", type=int, default=6)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    counts: Counter[str] = Counter()
    failed, start = list[int](), time.perf_counter()
    for seed in range(options.seed, options.seed + options.programs):
        right, found = is_refolded(random_program(seed, options.folds))
        counts += found
        failed += [] if right else [seed]
    print(
        json.dumps(
            {
                "programs": options.programs,
                "same": options.programs - len(failed),
                "failed_seeds": failed[:20],
                **{name: counts[name] for name in sorted(counts)},
                "seconds": round(time.perf_counter() - start, 1),
            },
            indent=1,
        )
    )


if __name__ == "__main__":
    main()
