"""CPD, crease-pattern dissimilarity: creases and vertices matched one by one (Oh et al. 2015)."""

import numpy as np

from folding_client.evaluation.compared_state import ComparedState, Reals
from folding_client.evaluation.evaluation_constants import EvaluationConstants, PatternCosts

QUARTERS = (0, 1, 2, 3)
"""Turns of the square sheet: which corner is called which is a matter of taste."""


def dissimilarities(
    state: ComparedState, truth: ComparedState, constants: EvaluationConstants
) -> dict[int, dict[str, float]]:
    """The terms of CPD, creases and vertices, for each quarter turn of the state's sheet."""
    costs = constants.pattern
    found = {}
    for quarters in QUARTERS:
        turned = state.turned(quarters)
        creases = matching_cost(_crease_costs(turned, truth, costs), costs.unmatched)
        vertices = matching_cost(_vertex_costs(turned, truth), costs.unmatched)
        found[quarters] = {"CPD.EC": costs.factor * creases, "CPD.VC": costs.factor * vertices}
    return found


def nothing_matched(truth: ComparedState, costs: PatternCosts) -> float:
    """The CPD of a pattern of which nothing is known."""
    return costs.factor * costs.unmatched * (len(truth.creases) + len(truth.sheet))


def matching_cost(costs: Reals, unmatched: float) -> float:
    """The least cost of matching rows to columns (n, m), where an item that is left out costs ``unmatched``.

    A pair that costs more than both of its items left out is as good as that.
    """
    from scipy.optimize import linear_sum_assignment

    bounded = np.minimum(costs, 2 * unmatched)
    rows, columns = linear_sum_assignment(bounded)
    return float(bounded[rows, columns].sum() + unmatched * abs(costs.shape[0] - costs.shape[1]))


def _crease_costs(state: ComparedState, truth: ComparedState, costs: PatternCosts) -> Reals:
    """(n, m): length difference, angle, distance of the midpoints, letter."""
    one, two = _crease_table(state), _crease_table(truth)
    angle = np.abs(one[:, None, 3] - two[None, :, 3])
    angle = np.minimum(angle, 180 - angle)
    middle = np.hypot(one[:, None, 0] - two[None, :, 0], one[:, None, 1] - two[None, :, 1])
    letters = [np.array([each.letters[c] for c in each.creases], "U1") for each in (state, truth)]
    differs = letters[0][:, None] != letters[1][None, :]
    length = np.abs(one[:, None, 2] - two[None, :, 2])
    return np.asarray(length + angle / costs.right_angle + middle + costs.other_letter * differs)


def _crease_table(state: ComparedState) -> Reals:
    """(n, 4): middle x, middle y, length, direction in degrees from 0 up to 180, of each crease."""
    ends = state.sheet[state.edges[state.creases]]
    run = ends[:, 1] - ends[:, 0]
    direction = np.degrees(np.arctan2(run[:, 1], run[:, 0])) % 180
    middle = ends.mean(axis=1)
    return np.stack([middle[:, 0], middle[:, 1], state.lengths[state.creases], direction], axis=1)


def _vertex_costs(state: ComparedState, truth: ComparedState) -> Reals:
    """(n, m): degree difference and distance."""
    apart = state.sheet[:, None] - truth.sheet[None, :]
    return np.asarray(
        np.abs(state.degrees[:, None] - truth.degrees[None, :]) + np.hypot(apart[..., 0], apart[..., 1])
    )
