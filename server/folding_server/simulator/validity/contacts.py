"""Where flat-lying faces and edges touch: overlaps, edges through faces, edges along each other, common cells.

Lengths in one unit; everything is shrunk by a tolerance, so that what reaches into something else by less does not
touch it, and points that nearly coincide need not be merged.
"""

from itertools import pairwise

import numpy as np
import shapely

from folding_server.arrays import Bools, Floats, Geometries, Indices, Ints
from folding_server.simulator.validity.convex_overlaps import meeting
from folding_server.simulator.validity.half_planes import half_planes, lengths_inside
from folding_server.simulator.validity.near_lines import nearly_collinear

PARALLEL = 0.02
"""Largest angle, in radians, between two edges that lie along one line."""
SHARED = 4.0
"""How many tolerances two edges must run along each other to count."""
FEW_CELLS = 3000
"""Up to so many sets of faces, each is compared with each: the comparison takes 36 MB."""
STRIP_HALF_WIDTH = 1e3
"""Half the width of a strip across an edge: more than any sheet measures."""


def shrunk(outlines: Geometries, distance: float) -> Geometries:
    """Polygons without a margin; empty where they are thinner than twice that."""
    return np.asarray(shapely.buffer(outlines, -distance, join_style="mitre"))


def overlapping(outlines: Geometries, tolerance: float) -> Indices:
    """(2, k): the pairs i < j of faces that overlap by more than the tolerance, ascending."""
    pairs = near_pairs(outlines)
    return pairs[:, overlap_by(outlines, pairs, tolerance)]


def near_pairs(outlines: Geometries) -> Indices:
    """(2, k): the pairs i < j of faces whose boxes meet, ascending."""
    i, j = shapely.STRtree(outlines).query(outlines)
    i, j = i[i < j], j[i < j]
    return np.stack([i, j])[:, np.argsort(i * len(outlines) + j)]


def overlap_by(outlines: Geometries, pairs: Indices, tolerance: float) -> Bools:
    """(k,): whether the faces of each pair (2, k) overlap by more than the tolerance."""
    cores = shrunk(outlines, tolerance / 2)
    bounds = np.asarray(shapely.bounds(cores))
    first, second = bounds[pairs[0]], bounds[pairs[1]]
    found: Bools = ((first[:, :2] <= second[:, 2:]) & (second[:, :2] <= first[:, 2:])).all(axis=1)
    found[found] = meeting(cores, pairs[:, found])
    return found


def through(segments: Floats, outlines: Geometries, tolerance: float) -> Indices:
    """(2, k): edge i runs through the inside of face j for more than the tolerance."""
    pairs = near_faces(segments, outlines)
    return pairs[:, run_through(segments, outlines, pairs, tolerance)]


def near_faces(segments: Floats, outlines: Geometries) -> Indices:
    """(2, k): the edges i whose boxes meet that of face j."""
    return np.asarray(shapely.STRtree(outlines).query(shapely.linestrings(segments)))


def run_through(segments: Floats, outlines: Geometries, pairs: Indices, tolerance: float) -> Bools:
    """(k,): whether the edge of each pair (2, k) runs through the inside of the face for more than the tolerance."""
    edge, face = pairs
    planes = half_planes(outlines)
    convex = ~np.isnan(planes[face, 0, 2])
    long = np.zeros(len(edge), bool)
    inside = lengths_inside(segments[edge[convex]], face[convex], planes, tolerance)
    long[convex] = inside > tolerance
    lines, cores = shapely.linestrings(segments[edge[~convex]]), shrunk(outlines[face[~convex]], tolerance)
    long[~convex] = shapely.length(shapely.intersection(lines, cores)) > tolerance
    return long


def along(segments: Floats, tolerance: float) -> tuple[Indices, Ints]:
    """(2, k) pairs i < j of edges that run along each other, and (k,) 1 if they point the same way, else -1.

    The shorter lies within the tolerance of the longer's line and is parallel to it; edges so short that the tolerance
    alone could make them parallel do not count.
    """
    pairs = nearly_collinear(segments, tolerance, PARALLEL, SHARED * tolerance)
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


def covering_faces(outlines: Geometries, tolerance: float) -> list[tuple[int, ...]]:
    """The sets of two or more faces that cover a cell of the arrangement of all outlines, each once; cells thinner than the
    tolerance are left out.
    """
    network = shapely.unary_union(_sides(outlines, tolerance / 8), grid_size=tolerance / 8)
    found = shapely.get_parts(shapely.polygonize([network]))
    cores = shrunk(found, tolerance / 2)
    inside = shapely.point_on_surface(cores[~shapely.is_empty(cores)])
    face, cell = shapely.STRtree(inside).query(outlines, predicate="contains")
    return _distinct(face, cell, len(inside))


def cell_sets(outlines: Geometries, tolerance: float) -> list[int]:
    """For each face a bit set of the cells it shares with others (``covering_faces``), without those covered by some of the
    faces that cover another where there are few cells.
    """
    covers = covering_faces(outlines, tolerance)
    if len(covers) <= FEW_CELLS:
        covers = _largest(covers, len(outlines))
    return _bit_sets(covers, len(outlines))


def _sides(outlines: Geometries, grid: float) -> Geometries:
    """The sides of all outlines on a grid, those that coincide once: neighbours share a side, and layers lie on layers."""
    corners, face = shapely.get_coordinates(outlines, return_index=True)
    on_grid = np.round(corners / grid).astype(np.int64)
    follows = face[1:] == face[:-1]
    ends = np.stack([on_grid[:-1][follows], on_grid[1:][follows]], axis=1)
    turned = (ends[:, 0, 0] > ends[:, 1, 0]) | (
        (ends[:, 0, 0] == ends[:, 1, 0]) & (ends[:, 0, 1] > ends[:, 1, 1])
    )
    ends[turned] = ends[turned][:, ::-1]
    distinct = np.unique(ends.reshape(-1, 4), axis=0).reshape(-1, 2, 2)
    return np.asarray(shapely.linestrings(distinct * grid))


def _bit_sets(covers: list[tuple[int, ...]], faces: int) -> list[int]:
    """For each face the numbers of the sets that it is in, as a bit set."""
    face = np.array([each for cover in covers for each in cover], int)
    number = np.repeat(np.arange(len(covers)), [len(cover) for cover in covers])
    packed = np.zeros((faces, len(covers) // 8 + 1), np.uint8)
    np.bitwise_or.at(packed, (face, number >> 3), (1 << (number & 7)).astype(np.uint8))
    return [int.from_bytes(row.tobytes(), "little") for row in packed]


def _distinct(face: Indices, cell: Indices, cells: int) -> list[tuple[int, ...]]:
    """The sets of two or more faces that cover a cell, each once; all other faces alone need no order."""
    order = np.lexsort((face, cell))
    starts = np.searchsorted(cell[order], np.arange(cells + 1)).tolist()
    sorted_faces = face[order].tolist()
    found = {tuple(sorted_faces[i:j]) for i, j in pairwise(starts)}
    return sorted(faces for faces in found if len(faces) > 1)


def _largest(covers: list[tuple[int, ...]], faces: int) -> list[tuple[int, ...]]:
    """The sets that are not contained in another."""
    cover = np.zeros((faces, len(covers)), np.float32)
    for number, each in enumerate(covers):
        cover[list(each), number] = 1
    counts = cover.sum(axis=0)
    contained = (cover.T @ cover >= counts[:, None]) & (counts[None, :] > counts[:, None])
    return [each for each, within in zip(covers, contained.any(axis=1).tolist(), strict=True) if not within]
