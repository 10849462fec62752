"""The order in which the layers of faces are best decided: row by row over the sheet."""

import numpy as np

from folding_server.arrays import Floats, Indices
from folding_server.simulator.foldability.flat_faces import FlatFaces

DIRECTION_BINS = 180
"""Bins of half a turn, one degree each, in which the lengths of creases are added up."""
ROWS = 1e-6
"""Middles of faces that differ by less, in units of the sheet's longer side, lie in one row."""


def sweep(flat: FlatFaces) -> Indices:
    """The faces by the rows that run along most creases, and within a row from one end to the other.

    A face is then laid when most of those around it are: in a map, with its neighbours in the row before and beside it.
    """
    points = np.array(flat.pattern.vertices_coords, float)
    points = (points - points.min(axis=0)) / max(float(np.ptp(points, axis=0).max()), 1e-300)
    middles = np.array([points[list(cycle)].mean(axis=0) for cycle in flat.pattern.cycles])
    turn = _main_direction(points, flat)
    across = middles @ np.array([-np.sin(turn), np.cos(turn)])
    row = np.round(across / ROWS)
    return np.lexsort((middles @ np.array([np.cos(turn), np.sin(turn)]), row))


def _main_direction(points: Floats, flat: FlatFaces) -> float:
    """The direction, 0 to half a turn, in which most of the creases run by their length."""
    if not flat.creases:
        return 0.0
    ends = points[[crease.edge for crease in flat.creases]]
    run = ends[:, 1] - ends[:, 0]
    turns = np.arctan2(run[:, 1], run[:, 0]) % np.pi
    bins = np.round(turns / np.pi * DIRECTION_BINS).astype(int) % DIRECTION_BINS
    best = int(np.bincount(bins, weights=np.hypot(*run.T), minlength=DIRECTION_BINS).argmax())
    return float(turns[np.flatnonzero(bins == best)[0]])
