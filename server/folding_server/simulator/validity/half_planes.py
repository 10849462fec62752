"""Convex outlines as half planes, and how much of a segment lies within them: whole arrays at once."""

import numpy as np
import shapely

from folding_server.arrays import Floats, Geometries, Indices

BATCH = 100_000
"""Segments that are clipped at once: with eight sides a face, arrays of 6 MB each."""
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
        _clipped(segments[k : k + BATCH], planes[face[k : k + BATCH]], margin)
        for k in range(0, len(segments), BATCH)
    ]
    return np.concatenate([np.zeros(0), *batches])


def _clipped(segments: Floats, planes: Floats, margin: float) -> Floats:
    start, run = segments[:, 0], segments[:, 1] - segments[:, 0]
    room = planes[..., 2] - margin - (planes[..., :2] * start[:, None]).sum(axis=2)
    rate = (planes[..., :2] * run[:, None]).sum(axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = room / rate
    first = np.where(rate < 0, at, 0.0).max(axis=1, initial=0.0)
    last = np.where(rate > 0, at, 1.0).min(axis=1, initial=1.0)
    shut = ((rate == 0) & (room < 0)).any(axis=1)
    share = np.where(shut, 0.0, np.maximum(last - first, 0.0))
    lengths: Floats = share * np.hypot(*run.T)
    return lengths
