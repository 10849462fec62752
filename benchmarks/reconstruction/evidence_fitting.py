"""Fit the weights of evidence, and how far a proposal can be trusted, on what evidence_collection.py wrote.

    python benchmarks/reconstruction/evidence_fitting.py FILE.jsonl [FILE.jsonl ...] [--write] [--json]

The weights: of the plans of one transition one is right; how likely each is, is taken to be proportional to the exponential of its
score (conditional logit, McFadden 1974), and the weights make the right ones as likely as can be, none farther from what it
was than its prior allows: a factor of e^SPREAD either way is one standard deviation. A term that no transition tells
anything of keeps its weight. The trust: logistic regression of "the best proposal is right" on what can be known without the
truth. Figures are given for programs left out, a fifth at a time; --write puts both into the solver's files.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from folding_server.vision.evidence import terms
from scipy.optimize import minimize

SPREAD = 0.5
"""Standard deviation of the logarithm of a weight about what it was: people's guesses are right to within a factor of two."""
FOLDS = 5
"""Parts into which programs are divided to be left out in turn."""
FIXED = ("agreement", "look_ahead")
"""Terms that are in the unit of the score itself."""
Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Choice:
    """One transition: the values (plans, terms) of its plans and which of them are right."""

    program: str
    values: Floats
    right: npt.NDArray[np.bool_]


def read(files: Sequence[Path]) -> list[dict[str, Any]]:
    """The transitions of some files."""
    return [json.loads(line) for file in files for line in file.read_text(encoding="utf-8").splitlines()]


def choices(rows: Sequence[dict[str, Any]]) -> list[Choice]:
    """The transitions of which a right plan was among those weighed."""
    names = list(terms())
    found = []
    for row in rows:
        right = np.array([plan["right"] for plan in row["plans"]])
        if right.any() and not right.all():
            values = [[plan["evidence"].get(name, 0.0) for name in names] for plan in row["plans"]]
            found.append(Choice(row["name"], np.array(values), right))
    return found


def fitted(data: Sequence[Choice], before: Floats) -> tuple[Floats, float]:
    """The weights (terms,) and the sharpness: the factor by which scores become logarithms of odds."""
    free = np.array([name not in FIXED for name in terms()])

    def weights(x: Floats) -> Floats:
        scaled = before.copy()
        scaled[free] *= np.exp(x[1:])
        return scaled

    def cost(x: Floats) -> tuple[float, Floats]:
        sharp, w = float(np.exp(x[0])), weights(x)
        total, slope = float((x[1:] ** 2).sum() / (2 * SPREAD**2)), np.concatenate([[0.0], x[1:] / SPREAD**2])
        for choice in data:
            scores = choice.values @ w
            odds = sharp * (scores - scores.max())
            odds -= np.log(np.exp(odds).sum())
            share = np.exp(odds)
            good = share * choice.right
            total -= float(np.log(good.sum() + 1e-12))
            pull = share - good / (good.sum() + 1e-12)
            slope[0] += sharp * float(pull @ scores)
            slope[1:] += sharp * (pull @ choice.values)[free] * w[free]
        return total, slope

    start = np.zeros(1 + int(free.sum()))
    start[0] = np.log(300.0)
    best = minimize(cost, start, jac=True, method="L-BFGS-B")
    return weights(best.x), float(np.exp(best.x[0]))


def first_right(data: Sequence[Choice], w: Floats) -> float:
    """The share of transitions whose best plan is right."""
    return float(np.mean([choice.right[int((choice.values @ w).argmax())] for choice in data]))


def left_out(data: Sequence[Choice], before: Floats) -> tuple[float, float]:
    """The share of right first plans with the weights as they were, and fitted without the program in question."""
    programs = sorted({choice.program for choice in data})
    hits = []
    for part in range(FOLDS):
        held = set(programs[part::FOLDS])
        rest = [choice for choice in data if choice.program not in held]
        w, _ = fitted(rest, before)
        hits += [c.right[int((c.values @ w).argmax())] for c in data if c.program in held]
    return first_right(data, before), float(np.mean(hits))


def main(arguments: Sequence[str] | None = None) -> None:
    """Fit, and say what it brings."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", type=Path, nargs="+")
    options = parser.parse_args(arguments)
    data = choices(read(options.files))
    before = np.array([term.weight for term in terms().values()])
    after, sharp = fitted(data, before)
    held_before, held_after = left_out(data, before)
    report = {
        "transitions": len(data),
        "right_first": {"before": held_before, "left_out": held_after, "fitted": first_right(data, after)},
        "sharpness": sharp,
        "weights": {
            name: {"before": float(old), "after": float(new)}
            for name, old, new in zip(terms(), before, after, strict=True)
        },
    }
    json.dump(report, sys.stdout, indent=1)


if __name__ == "__main__":
    main()
