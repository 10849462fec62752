"""Convex outlines as half planes, and how much of a segment lies within them: whole arrays at once."""

import numpy as np
import shapely

from folding_server.arrays import Floats, Geometries, Indices

BATCH = 100_000
"""Segments that are clipped at once: arrays of at most 2.4 MB each."""
CONVEX = 1e-9
"""How far, as the sine of an angle times both lengths, a corner may turn inwards by rounding."""


def half_planes(outlines: Geometries) -> Floats:
    """(n, k, 3): for each face, unit normals (a, b) out of its sides and distances c with a x + b y <= c inside.

    Faces with fewer sides have sides that exclude nothing; those that are not convex have NaN instead of all numbers.
    """
    corners, face = shapely.get_coordinates(shapely.normalize(outlines), return_index=True)
    follows = np.append(face[1:] == face[:-1], [False])
    starts, ends = corners[follows], corners[np.flatnonzero(follows) + 1]
    owner = face[follows]
    first = np.searchsorted(owner, np.arange(len(outlines)))
    count = np.bincount(owner, minlength=len(outlines))
    side = np.arange(len(owner)) - first[owner]
    run = ends - starts
    length = np.maximum(np.hypot(*run.T), 1e-300)
    normals = np.column_stack([-run[:, 1], run[:, 0]]) / length[:, None]
    planes = np.zeros((len(outlines), int(count.max(initial=1)), 3))
    planes[..., 2] = np.inf
    planes[owner, side, :2] = normals
    planes[owner, side, 2] = (normals * starts).sum(axis=1)
    after = np.where(side + 1 < count[owner], np.arange(len(owner)) + 1, first[owner])
    turns = run[:, 0] * run[after][:, 1] - run[:, 1] * run[after][:, 0]
    planes[owner[turns > CONVEX]] = np.nan
    return planes


def lengths_inside(segments: Floats, face: Indices, planes: Floats, margin: float) -> Floats:
    """(k,): how much of each segment (k, 2, 2) lies in a convex face, less a margin along its sides.

    Cyrus and Beck, "Generalized two- and three-dimensional clipping" (1978).
    """
    batches = [
        _clipped(segments[k : k + BATCH], face[k : k + BATCH], planes, margin)
        for k in range(0, len(segments), BATCH)
    ]
    return np.concatenate([np.zeros(0), *batches])


def _clipped(segments: Floats, face: Indices, planes: Floats, margin: float) -> Floats:
    """One side after the other: what lies outside of one is not looked at again."""
    start, run = segments[:, 0], segments[:, 1] - segments[:, 0]
    sides = np.isfinite(planes[..., 2]).sum(axis=1)[face]
    first, last = np.zeros(len(face)), np.ones(len(face))
    left = np.arange(len(face))
    for side in range(planes.shape[1]):
        left = left[(side < sides[left]) & (first[left] < last[left])]
        across, up, distance = planes[face[left], side].T
        room = distance - margin - (across * start[left, 0] + up * start[left, 1])
        rate = across * run[left, 0] + up * run[left, 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            at = room / rate
        first[left] = np.where(rate < 0, np.maximum(first[left], at), first[left])
        last[left] = np.where(rate > 0, np.minimum(last[left], at), last[left])
        last[left[(rate == 0) & (room < 0)]] = 0.0
    lengths: Floats = np.maximum(last - first, 0.0) * np.hypot(*run.T)
    return lengths
