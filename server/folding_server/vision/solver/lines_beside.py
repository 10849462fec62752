"""Nobody folds exactly where they aim: a fold along a landmark is judged by the best of the lines that lie a little beside it.

A free line explains more than the landmark it was aimed at, and costs more. Judged one by one, the right fold would count as the worse
of both, and a wrong one that fits by chance as more than it; and the line would be taken that one photo happens to show.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from folding_server.geometry.line import Point
from folding_server.geometry.point_batch import hausdorff_distance
from folding_server.simulator.paper import Paper
from folding_server.vision.solver.plan import Plan, best_first

FOLDED_BESIDE = 0.0075
"""Standard deviation, in sheet units, of how far a crease ends beside the landmark it was aimed at."""
FARTHEST_BESIDE = 0.015
"""A line that ends farther from the landmark, in sheet units, was not aimed at it: two standard deviations."""
FOLDED_APART = 3.0
"""What lies folded is apart by at most so many times as much: by twice, and by what the crease turns."""
COST = 0.00125
"""Shares of the paper that one standard deviation costs: half an e-fold, at 400 e-folds for all of the paper."""
FREE_LINE_TERMS = ("free_line", "own_camera_free_line")
"""What speaks against a line that no construction gives."""


def with_lines_beside(plans: Sequence[Plan]) -> list[Plan]:
    """Plans, each fold along a landmark with what the best of the lines beside it explains more; best first."""
    free = [plan for plan in plans if _folds(plan) and plan.noted.free_line]
    return best_first([_with_line_beside(plan, free) for plan in plans])


def _with_line_beside(plan: Plan, free: Sequence[Plan]) -> Plan:
    """A plan, with what the best of some folds along free lines explains more if it was aimed where that lies."""
    if not _folds(plan) or plan.noted.free_line:
        return plan
    best = max(free, key=lambda other: _gained(plan, other), default=None)
    if best is None or (gain := _gained(plan, best)) <= 0:
        return plan
    return replace(plan.noting(folded_beside=gain), beside=best.paper)


def _gained(plan: Plan, other: Plan) -> float:
    """How much better a fold scores by another line, if that was aimed at the same; negative if it was not."""
    gap = _gap(plan.paper, other.paper)
    if gap > FARTHEST_BESIDE:
        return -1.0
    unaimed = other.score - other.noted.of(*FREE_LINE_TERMS)
    return unaimed - COST * (gap / FOLDED_BESIDE) ** 2 - plan.score


def _folds(plan: Plan) -> bool:
    """Whether a plan is one fold that makes a crease."""
    return plan.action_class == "fold" and bool(plan.noted.new_crease)


def _gap(first: Paper, second: Paper) -> float:
    """How far apart creases end on two sheets, in sheet units; infinite if something is folded to where in the other there is nothing."""
    folded = _apart(first.folded_vertices_coords, second.folded_vertices_coords)
    flat = _apart(first.vertices_coords, second.vertices_coords)
    return flat if folded <= FOLDED_APART * FARTHEST_BESIDE else float("inf")


def _apart(first: Mapping[int, Point], second: Mapping[int, Point]) -> float:
    """How far two sets of vertices are apart."""
    return hausdorff_distance(np.array(list(first.values())), np.array(list(second.values())))
