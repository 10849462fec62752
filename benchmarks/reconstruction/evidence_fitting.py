"""Fit the weights of evidence, and how far a proposal can be trusted, on what evidence_collection.py wrote.

    python benchmarks/reconstruction/evidence_fitting.py FILE.jsonl [FILE.jsonl ...] [--spread S] [--write-confidence]

The weights: of the plans of one transition one is right; how likely each is, is taken to be proportional to the exponential of its
score (conditional logit, McFadden 1974), and the weights make the right ones as likely as can be, none farther from what it
was than its prior allows: a factor of e^S either way is one standard deviation. A term that no transition tells
anything of keeps its weight. The trust: logistic regression of "the best proposal is right" on what can be known without the
truth. Figures are given for programs left out, a fifth at a time; --write-confidence puts the second into the solver's file; weights are put there by hand.
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
from folding_server.vision.solver.confidence import COEFFICIENTS_FILE
from scipy.optimize import minimize

SPREAD = 0.5
"""Standard deviation of the logarithm of a weight about what it was: people's guesses are right to within a factor of two."""
FOLDS = 5
"""Parts into which programs are divided to be left out in turn."""
TRUSTED = 0.8
"""Confidence from which a step is not called doubtful."""
SIGNS = ("lead", "unexplained", "inner_lines", "free_line", "own_camera", "own_camera_free_line", "unseen")
"""What the confidence is judged by, see folding_server.vision.solver.confidence."""
USUAL_SHARPNESS = 400.0
"""Odds grow e-fold per 1/400 of the paper: twice the noise of agreement between two photos of one state. One e-fold either way is
one standard deviation.
"""
FIXED = ("agreement", "folded_beside", "look_ahead")
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


def fitted(data: Sequence[Choice], before: Floats, spread: float) -> tuple[Floats, float]:
    """The weights (terms,) and the sharpness: the factor by which scores become logarithms of odds."""
    free = np.array([name not in FIXED for name in terms()])
    start = np.zeros(1 + int(free.sum()))
    start[0] = np.log(USUAL_SHARPNESS)

    def weights(x: Floats) -> Floats:
        scaled = before.copy()
        scaled[free] *= np.exp(x[1:])
        return scaled

    def cost(x: Floats) -> tuple[float, Floats]:
        sharp, w = float(np.exp(x[0])), weights(x)
        total = float((x[1:] ** 2).sum() / (2 * spread**2) + (x[0] - start[0]) ** 2 / 2)
        slope = np.concatenate([x[:1] - start[0], x[1:] / spread**2])
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

    best = minimize(cost, start, jac=True, method="L-BFGS-B")
    return weights(best.x), float(np.exp(best.x[0]))


def first_right(data: Sequence[Choice], w: Floats) -> float:
    """The share of transitions whose best plan is right."""
    return float(np.mean([choice.right[int((choice.values @ w).argmax())] for choice in data]))


def left_out(data: Sequence[Choice], before: Floats, spread: float) -> tuple[float, float]:
    """The share of right first plans with the weights as they were, and fitted without the program in question."""
    programs = sorted({choice.program for choice in data})
    hits = []
    for part in range(FOLDS):
        held = set(programs[part::FOLDS])
        rest = [choice for choice in data if choice.program not in held]
        w, _ = fitted(rest, before, spread)
        hits += [c.right[int((c.values @ w).argmax())] for c in data if c.program in held]
    return first_right(data, before), float(np.mean(hits))


def trust_data(rows: Sequence[dict[str, Any]]) -> tuple[list[str], Floats, npt.NDArray[np.bool_]]:
    """For each transition its program, the signs (transitions, signs) of its best plan, and whether that one is right."""
    values = [[row["signs"][name] for name in SIGNS] for row in rows]
    right = [row["plans"][0]["right"] for row in rows]
    return [row["name"] for row in rows], np.array(values), np.array(right)


def trusted(signs: Floats, right: npt.NDArray[np.bool_]) -> Floats:
    """The constant and the coefficients of a logistic regression, signs scaled to their spread and held to a normal prior.

    A lead speaks for a plan, all else against it.
    """
    spread = signs.std(axis=0) + 1e-9
    scaled = np.column_stack([np.ones(len(signs)), signs / spread])
    wanted = right.astype(np.float64)

    def cost(x: Floats) -> tuple[float, Floats]:
        logit = scaled @ x
        total = float(np.logaddexp(0, logit).sum() - wanted @ logit + (x[1:] ** 2).sum() / 8)
        chance = 1 / (1 + np.exp(-logit))
        return total, scaled.T @ (chance - wanted) + np.concatenate([[0.0], x[1:] / 4])

    signed = [(None, None), (0, None), *[(None, 0)] * (len(SIGNS) - 1)]
    found = minimize(cost, np.zeros(scaled.shape[1]), jac=True, method="L-BFGS-B", bounds=signed).x
    return np.concatenate([found[:1], found[1:] / spread])


def trust_left_out(
    programs: Sequence[str], signs: Floats, right: npt.NDArray[np.bool_]
) -> npt.NDArray[np.float64]:
    """The confidence in each transition by a regression without its program."""
    known = sorted(set(programs))
    chance = np.zeros(len(right))
    for part in range(FOLDS):
        held = np.array([name in set(known[part::FOLDS]) for name in programs])
        if held.any() and not held.all():
            x = trusted(signs[~held], right[~held])
            chance[held] = 1 / (1 + np.exp(-(x[0] + signs[held] @ x[1:])))
    return chance


def reliability(chance: Floats, right: npt.NDArray[np.bool_]) -> list[dict[str, float]]:
    """Ten bins of confidence: how many transitions, what was promised, what came true."""
    bins = np.minimum((10 * chance).astype(int), 9)
    return [
        {
            "from": b / 10,
            "transitions": int((bins == b).sum()),
            "promised": float(chance[bins == b].mean()),
            "right": float(right[bins == b].mean()),
        }
        for b in range(10)
        if (bins == b).any()
    ]


def matches(rows: Sequence[dict[str, Any]], chance: Floats) -> dict[str, float]:
    """Of best plans that the comparison calls a MATCH: how many, how many are wrong, and how many of those that are trusted."""
    verdicts = np.array([row["plans"][0]["compared"]["verdict"] == "MATCH" for row in rows])
    right = np.array([row["plans"][0]["right"] for row in rows])
    sure = verdicts & (chance >= TRUSTED)
    return {
        "match": int(verdicts.sum()),
        "match_wrong": int((verdicts & ~right).sum()),
        "trusted_match": int(sure.sum()),
        "trusted_match_wrong": int((sure & ~right).sum()),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Fit, and say what it brings."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--spread", type=float, default=SPREAD, help="how freely weights move, see above")
    parser.add_argument(
        "--write-confidence", action="store_true", help="put the confidence into the solver's file"
    )
    options = parser.parse_args(arguments)
    rows = read(options.files)
    data = choices(rows)
    before = np.array([term.weight for term in terms().values()])
    after, sharp = fitted(data, before, options.spread)
    held_before, held_after = left_out(data, before, options.spread)
    programs, signs, right = trust_data(rows)
    chance = trust_left_out(programs, signs, right)
    found = trusted(signs, right)
    report = {
        "transitions": len(rows),
        "best_plan_right": float(right.mean()),
        "choices": len(data),
        "right_first": {"before": held_before, "left_out": held_after, "fitted": first_right(data, after)},
        "sharpness": sharp,
        "weights": {
            name: {"before": float(old), "after": float(new)}
            for name, old, new in zip(terms(), before, after, strict=True)
        },
        "confidence": dict(zip(("constant", *SIGNS), found.tolist(), strict=True)),
        "reliability_left_out": reliability(chance, right),
        "matches": matches(rows, chance),
    }
    if options.write_confidence:
        COEFFICIENTS_FILE.write_text(_confidence_text(found, rows, options.files), encoding="utf-8")
    json.dump(report, sys.stdout, indent=1)


def _confidence_text(found: Floats, rows: Sequence[dict[str, Any]], files: Sequence[Path]) -> str:
    """The file of coefficients."""
    sequences = {(row["name"], row["level"], row["seed"]) for row in rows}
    names = ", ".join(path.stem for path in files)
    head = (
        f"# Fitted by benchmarks/reconstruction/evidence_fitting.py on {len(rows)} transitions of {len(sequences)} "
        f"sequences ({names}).\n# Log odds per unit of each sign, see confidence.py.\n\n[coefficients]\n"
    )
    return head + "".join(
        f"{name} = {value:.6g}\n" for name, value in zip(("constant", *SIGNS), found.tolist(), strict=True)
    )


if __name__ == "__main__":
    main()
