"""Nobody folds exactly where they aim: a fold along a landmark is judged by the best of the lines that lie a little beside it.

A free line explains more than the landmark it was aimed at, and costs more. Judged one by one, the right fold would count as the worse
of both, and a wrong one that fits by chance as more than it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from folding_server.geometry.point_batch import hausdorff_distance
from folding_server.simulator.paper import Paper
from folding_server.vision.solver.plan import Plan, best_first

FOLDED_BESIDE = 0.01
"""Standard deviation, in sheet units, of how far a crease ends beside the landmark it was aimed at, with what the landmark itself is off.
"""
FARTHEST_BESIDE = 0.03
"""A line that ends farther from the landmark, in sheet units, was not aimed at it: three standard deviations."""
COST = 0.00125
"""Shares of the paper that one standard deviation costs: half an e-fold, at 400 e-folds for all of the paper."""
FREE_LINE_TERMS = ("free_line", "own_camera_free_line")
"""What speaks against a line that no construction gives."""


def with_lines_beside(plans: Sequence[Plan]) -> list[Plan]:
    """Plans, each fold along a landmark and those beside it with what the best of them explains more; best first."""
    aimed = [plan for plan in plans if _folds(plan) and not plan.noted.free_line]
    beside: dict[int, list[tuple[Plan, float]]] = {i: [] for i in range(len(aimed))}
    for plan in plans:
        if aimed and _folds(plan) and plan.noted.free_line:
            gaps = [_gap(plan.paper, other.paper) for other in aimed]
            nearest = int(np.argmin(gaps))
            if gaps[nearest] <= FARTHEST_BESIDE:
                beside[nearest].append((plan, gaps[nearest]))
    more: dict[int, tuple[float, Paper]] = {}
    for i, found in beside.items():
        if found:
            reached, at = max(
                (_unaimed(p) - COST * (gap / FOLDED_BESIDE) ** 2, -k) for k, (p, gap) in enumerate(found)
            )
            group = [aimed[i], *(plan for plan, _ in found)]
            gain = reached - max(plan.score for plan in group)
            if gain > 0:
                more |= {id(plan): (gain, found[-at][0].paper) for plan in group}
    return best_first([_with(plan, *more.get(id(plan), (0.0, None))) for plan in plans])


def _with(plan: Plan, gain: float, beside: Paper | None) -> Plan:
    """A plan with what the best line beside it explains more, and makes."""
    return replace(plan.noting(folded_beside=gain), beside=beside)


def _folds(plan: Plan) -> bool:
    """Whether a plan is one fold that makes a crease."""
    return plan.action_class == "fold" and bool(plan.noted.new_crease)


def _unaimed(plan: Plan) -> float:
    """The score of a plan but for what its free line costs."""
    return plan.score - plan.noted.of(*FREE_LINE_TERMS)


def _gap(first: Paper, second: Paper) -> float:
    """How far apart the vertices of two papers are at most, on the flat sheet and as they lie folded, in sheet units."""
    return max(
        hausdorff_distance(np.array(list(one.values())), np.array(list(other.values())))
        for one, other in (
            (first.vertices_coords, second.vertices_coords),
            (first.folded_vertices_coords, second.folded_vertices_coords),
        )
    )
