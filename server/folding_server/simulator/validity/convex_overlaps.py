"""Whether convex outlines meet, pair by pair: whole arrays at once."""

import numpy as np
import shapely

from folding_server.arrays import Bools, Floats, Geometries, Indices
from folding_server.simulator.validity.half_planes import half_planes

FEW_SIDES = 6
"""Pairs of outlines with at most so many sides, nearly all in crease patterns, are compared in smaller arrays."""
PAIRS_AT_ONCE = 20_000
"""Pairs that are compared at once: with six sides each, arrays of 1 MB."""


def meeting(outlines: Geometries, pairs: Indices) -> Bools:
    """(k,): whether the outlines of each pair (2, k) have a point in common; empty ones have none with any.

    Two convex outlines are apart if a side of one has all of the other beyond it. What is not convex is left to shapely.
    """
    planes = half_planes(outlines)
    count = np.maximum(shapely.get_num_coordinates(outlines) - 1, 0)
    corners = _corners(outlines, planes.shape[1])
    single = shapely.get_type_id(outlines) == shapely.GeometryType.POLYGON
    convex = ~np.isnan(planes[:, 0, 2]) & (count > 0) & single
    few = (count <= FEW_SIDES) & convex
    small = few[pairs].all(axis=0)
    large = convex[pairs].all(axis=0) & ~small
    rest = ~small & ~large
    found = np.zeros(pairs.shape[1], bool)
    found[small] = _not_apart(planes[:, :FEW_SIDES], corners[:, :FEW_SIDES], pairs[:, small])
    found[large] = _not_apart(planes, corners, pairs[:, large])
    found[rest] = shapely.intersects(*outlines[pairs[:, rest]])
    return found


def _corners(outlines: Geometries, most: int) -> Floats:
    """(n, k, 2): the corners of each outline, the last one repeated; k is ``most``."""
    points, owner = shapely.get_coordinates(outlines, return_index=True)
    first = np.searchsorted(owner, np.arange(len(outlines)))
    last = np.searchsorted(owner, np.arange(len(outlines)), side="right") - 1
    at = np.minimum(first[:, None] + np.arange(most), np.maximum(last, 0)[:, None])
    return np.asarray(points[at]) if len(points) else np.zeros((len(outlines), most, 2))


def _not_apart(planes: Floats, corners: Floats, pairs: Indices) -> Bools:
    """(k,): whether no side of one convex outline has all corners of the other beyond it."""
    found = np.ones(pairs.shape[1], bool)
    for k in range(0, pairs.shape[1], PAIRS_AT_ONCE):
        for one, other in (pairs[:, k : k + PAIRS_AT_ONCE], pairs[::-1, k : k + PAIRS_AT_ONCE]):
            left = k + np.flatnonzero(found[k : k + PAIRS_AT_ONCE])
            found[left] = ~_beyond(planes[one[left - k]], corners[other[left - k]])
    return found


def _beyond(planes: Floats, corners: Floats) -> Bools:
    """(k,): whether some side (k, s, 3) of an outline has all corners (k, c, 2) beyond it."""
    across, up = planes[..., 0], planes[..., 1]
    nearest = np.full(across.shape, np.inf)
    for k in range(corners.shape[1]):
        np.minimum(nearest, across * corners[:, k, :1] + up * corners[:, k, 1:], out=nearest)
    return np.asarray((nearest > planes[..., 2]).any(axis=1))
