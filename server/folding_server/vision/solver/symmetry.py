"""What is done to one side of a model is mostly done to the other: the mirror images of creases."""

import numpy as np

from folding_server.arrays import Floats
from folding_server.geometry.line import line_through
from folding_server.simulator.paper import Paper

MIRROR_TOLERANCE = 0.01
"""How far beside its partner's mirror image a vertex may lie (sheet units): folds are not perfect."""
LEAST_SHARE = 0.6
"""A line about which at least this share of the vertices beside it have partners is an axis of symmetry."""
LEAST_PAIRED = 4
"""Vertices with partners that an axis needs at least, but where none beside it is without."""
ON_AXIS = 0.005
"""How far beside an axis of the sheet a crease may run that is meant to lie on it, as a part of the sheet's side."""
MOST_AXES = 4
"""Axes of symmetry that are used, the clearest: a square has so many."""
MOST_POINTS = 40
"""Papers with more distinct vertices are not looked at: there would be too many lines to try."""


def mirrored(lines: Floats, axes: Floats) -> Floats:
    """Lines (n, 3), as unit normal and offset, reflected about each of k axes (k, 3): (n k, 3)."""
    images = []
    for axis in axes:
        along = lines[:, :2] @ axis[:2]
        images.append(
            np.column_stack([lines[:, :2] - 2 * along[:, None] * axis[:2], lines[:, 2] - 2 * along * axis[2]])
        )
    return np.concatenate(images) if images else np.empty((0, 3))


def sheet_axes(paper: Paper) -> Floats:
    """Where creases along the axes of symmetry of the sheet itself lie now, (k, 3)."""
    width, height = paper.sheet
    rows = []
    for u, v in paper.edge_faces:
        (ux, uy), (vx, vy) = (
            (x / width - 0.5, y / height - 0.5)
            for x, y in (paper.vertices_coords[u], paper.vertices_coords[v])
        )
        along = [(ux, vx), (uy, vy)]
        if width == height:
            along += [(ux - uy, vx - vy), (ux + uy, vx + vy)]
        if any(max(abs(a), abs(b)) < ON_AXIS for a, b in along):
            rows.append(line_through(paper.folded_vertices_coords[u], paper.folded_vertices_coords[v]))
    return np.array(rows).reshape(-1, 3)


def symmetry_axes(points: Floats, candidates: Floats) -> Floats:
    """Those of the candidates (n, 3) about which most points (m, 2) have partners, the most symmetrical first, (k, 3)."""
    if len(points) > MOST_POINTS:
        return np.empty((0, 3))
    height = candidates[:, :2] @ points.T - candidates[:, 2:3]
    images = points[None] - 2 * height[..., None] * candidates[:, None, :2]
    across, up = (images[:, :, None, i] - points[:, i] for i in (0, 1))
    gaps = np.sqrt((across**2 + up**2).min(axis=2))
    beside = np.abs(height) > MIRROR_TOLERANCE
    paired = beside & (gaps < MIRROR_TOLERANCE)
    count = paired.sum(axis=1)
    share = count / np.maximum(beside.sum(axis=1), 1)
    miss = np.where(paired, gaps, 0).sum(axis=1) / np.maximum(count, 1)
    whole = (count > 0) & (count == beside.sum(axis=1))
    good = np.nonzero(whole | (share >= LEAST_SHARE) & (count >= LEAST_PAIRED))[0]
    kept: list[Floats] = []
    for i in good[np.lexsort((miss[good], -share[good]))]:
        near = (
            np.abs(candidates[i] - side * other).max() < 3 * MIRROR_TOLERANCE
            for other in kept
            for side in (1, -1)
        )
        if not any(near):
            kept.append(candidates[i])
    return np.array(kept[:MOST_AXES]).reshape(-1, 3)
