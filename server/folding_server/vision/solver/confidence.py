"""How likely it is that the best explanation of a photo is the right one: logistic regression on what can be known without the truth.

The coefficients, with where they come from, are in ``confidence.toml`` beside this file; they are fitted by
``benchmarks/reconstruction/evidence_fitting.py``.
"""

import tomllib
from collections.abc import Mapping, Sequence
from functools import cache
from math import exp
from pathlib import Path

from folding_server.vision.solver.plan import Plan

COEFFICIENTS_FILE = Path(__file__).with_name("confidence.toml")
WIDEST_LEAD = 0.05
"""Shares of the paper: a lead over the rivals says no more from here on."""


def signs(plans: Sequence[Plan]) -> dict[str, float]:
    """What the confidence in the first of some plans, best first, is judged by: its lead over the best plan that leads to another
    state, what it leaves unexplained, lines that contradict it, whether its line is free, whether the camera is its own, and both.
    """
    best = plans[0]
    rivals = [plan for plan in plans[1:] if leads_elsewhere(plan, best)]
    lead = best.score - max((plan.score for plan in rivals), default=best.score - WIDEST_LEAD)
    return {
        "lead": min(lead, WIDEST_LEAD),
        "unexplained": 1 - best.agreement,
        "inner_lines": best.noted.inner_lines + best.noted.own_camera_inner_lines,
        "free_line": best.noted.free_line,
        "own_camera": best.noted.own_camera,
        "own_camera_free_line": best.noted.own_camera * best.noted.free_line,
        "unseen": max(best.noted.unseen_fold, best.noted.unseen_turn),
    }


def leads_elsewhere(plan: Plan, other: Plan) -> bool:
    """Whether two plans from one state lead to different ones: turns make no difference, nor does the axis of a flip."""
    if plan.creases or other.creases:
        return True
    flips = [sum(action.action == "flip" for action in each.actions) % 2 for each in (plan, other)]
    return flips[0] != flips[1]


def confidence(plans: Sequence[Plan]) -> float:
    """The probability, 0 to 1, that the first of some plans, best first, leads to the right state."""
    known = coefficients()
    logit = known["constant"] + sum(known[name] * value for name, value in signs(plans).items())
    return 1 / (1 + exp(-logit))


@cache
def coefficients() -> Mapping[str, float]:
    """The constant, and the coefficient of each sign."""
    table = tomllib.loads(COEFFICIENTS_FILE.read_text(encoding="utf-8"))
    return {name: float(value) for name, value in table["coefficients"].items()}
