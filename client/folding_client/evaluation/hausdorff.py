"""Hausdorff distances of point sets, as they lie and after the best rigid motion of the plane."""

import numpy as np

from folding_client.evaluation.compared_state import Reals

NO_DISTANCE = 1e-9
"""Sheet units below which points lie on each other, and no motion need be looked for: the precision that coordinates come in."""


def hausdorff(first: Reals, second: Reals) -> float:
    """The two-sided Hausdorff distance of points (n, 2) and (m, 2)."""
    from scipy.spatial.distance import cdist

    distances = cdist(first, second)
    return float(max(distances.min(axis=1).max(), distances.min(axis=0).max()))


def closest_hausdorff(first: Reals, second: Reals, step: float, refined: int) -> float:
    """The distance after the best rotation and translation; no reflection.

    Rotations of the centred points by each ``step`` degrees are tried, then the ``refined`` best of them with a translation
    improved by Nelder and Mead's method.
    """
    first, second = first - first.mean(axis=0), second - second.mean(axis=0)
    turns = np.radians(np.arange(0.0, 360.0, step))
    found = np.array([hausdorff(_moved(first, turn), second) for turn in turns])
    best = float(found.min())
    if best < NO_DISTANCE:
        return best
    for index in np.argsort(found, kind="stable")[:refined]:
        best = min(best, _refined(first, second, float(turns[index]), np.radians(step)))
    return best


def _moved(points: Reals, turn: float, dx: float = 0.0, dy: float = 0.0) -> Reals:
    c, s = np.cos(turn), np.sin(turn)
    return np.asarray(points @ np.array([[c, s], [-s, c]]) + (dx, dy))


def _refined(first: Reals, second: Reals, turn: float, step: float) -> float:
    from scipy.optimize import minimize

    extent = float(np.ptp(second, axis=0).max())
    simplex = np.array([turn, 0.0, 0.0]) + np.vstack([np.zeros(3), np.diag([step, extent / 50, extent / 50])])
    found = minimize(
        lambda motion: hausdorff(_moved(first, *motion), second),
        simplex[0],
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "xatol": 1e-7, "fatol": 1e-9, "maxiter": 200},
    )
    return float(found.fun)
