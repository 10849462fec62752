"""Where flat-lying faces and edges touch: overlaps, edges through faces, edges along each other, common cells.

Lengths in one unit; everything is shrunk by a tolerance, so that what reaches into something else by less does not
touch it, and points that nearly coincide need not be merged.
"""

import numpy as np
import shapely

from folding_server.arrays import Bools, Floats, Geometries, Indices, Ints

PARALLEL = 0.02
"""Largest angle, in radians, between two edges that lie along one line."""
SHARED = 4.0
"""How many tolerances two edges must run along each other to count."""
STRIP_HALF_WIDTH = 1e3
"""Half the width of a strip across an edge: more than any sheet measures."""


def shrunk(outlines: Geometries, distance: float) -> Geometries:
    """Polygons without a margin; empty where they are thinner than twice that."""
    return np.asarray(shapely.buffer(outlines, -distance, join_style="mitre"))


def overlapping(outlines: Geometries, tolerance: float) -> Indices:
    """(2, k): the pairs i < j of faces that overlap by more than the tolerance."""
    cores = shrunk(outlines, tolerance / 2)
    pairs = shapely.STRtree(cores).query(cores, predicate="intersects")
    return pairs[:, pairs[0] < pairs[1]]


def through(segments: Floats, outlines: Geometries, tolerance: float) -> Indices:
    """(2, k): edge i runs through the inside of face j for more than the tolerance."""
    cores = shrunk(outlines, tolerance)
    lines = np.asarray(shapely.linestrings(segments))
    edge, face = shapely.STRtree(cores).query(lines, predicate="intersects")
    long = shapely.length(shapely.intersection(lines[edge], cores[face])) > tolerance
    return np.stack([edge[long], face[long]])


def along(segments: Floats, tolerance: float) -> tuple[Indices, Ints]:
    """(2, k) pairs i < j of edges that run along each other, and (k,) 1 if they point the same way, else -1.

    The shorter lies within the tolerance of the longer's line and is parallel to it; edges so short that the tolerance
    alone could make them parallel do not count.
    """
    lines = np.asarray(shapely.linestrings(segments))
    pairs = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=tolerance)
    pairs = pairs[:, pairs[0] < pairs[1]]
    vectors = segments[:, 1] - segments[:, 0]
    length = np.hypot(*vectors.T)
    long, short = np.where(length[pairs[0]] >= length[pairs[1]], pairs, pairs[::-1])
    unit = vectors[long] / np.maximum(length[long, None], tolerance)
    arms = segments[short] - segments[long, :1]
    reach = np.einsum("kij,kj->ki", arms, unit)
    away = arms[..., 0] * unit[:, None, 1] - arms[..., 1] * unit[:, None, 0]
    common = np.minimum(reach.max(axis=1), length[long]) - np.maximum(reach.min(axis=1), 0)
    tilt = np.abs(away[:, 1] - away[:, 0]) / np.maximum(length[short], tolerance)
    found = (common > SHARED * tolerance) & (np.abs(away).max(axis=1) <= tolerance) & (tilt <= PARALLEL)
    way = np.where(reach[:, 1] >= reach[:, 0], 1, -1)
    return pairs[:, found], way[found]


def common_stretch(first: Floats, second: Floats) -> Floats:
    """The part (2, 2) of the longer of two edges, each (2, 2), beside which the shorter one runs."""
    long, short = (
        (first, second) if np.ptp(first, axis=0).max() >= np.ptp(second, axis=0).max() else (second, first)
    )
    run = long[1] - long[0]
    reach = np.clip((short - long[0]) @ run / (run @ run), 0, 1)
    stretch: Floats = long[0] + np.sort(reach)[:, None] * run
    return stretch


def meet_across(outlines: Geometries, stretch: Floats, tolerance: float) -> bool:
    """Whether convex faces have a part in common, thicker than the tolerance, straight across from a stretch (2, 2)."""
    strip = shapely.buffer(shapely.LineString(stretch), STRIP_HALF_WIDTH, cap_style="flat")
    common = shapely.intersection_all([strip, *outlines])
    return not bool(shapely.is_empty(shapely.buffer(common, -tolerance / 2, join_style="mitre")))


def cells(outlines: Geometries, tolerance: float) -> Bools:
    """(n, c): which faces cover each cell of the arrangement of all outlines, cells thinner than the tolerance left out.

    Cells covered by the same faces, or by some of the faces that cover another, are given once.
    """
    rings = shapely.get_exterior_ring(outlines)
    network = shapely.unary_union(rings, grid_size=tolerance / 8)
    found = shapely.get_parts(shapely.polygonize([network]))
    cores = shrunk(found, tolerance / 2)
    inside = shapely.point_on_surface(cores[~shapely.is_empty(cores)])
    face, cell = shapely.STRtree(inside).query(outlines, predicate="contains")
    cover = np.zeros((len(outlines), len(inside)), bool)
    cover[face, cell] = True
    return _largest(np.unique(cover, axis=1))


def _largest(cover: Bools) -> Bools:
    """The columns that are not contained in another column."""
    counts = cover.sum(axis=0)
    common = cover.T.astype(np.float32) @ cover.astype(np.float32)
    contained = (common >= counts[:, None]) & (counts[None, :] > counts[:, None])
    kept: Bools = cover[:, ~contained.any(axis=1)]
    return kept
