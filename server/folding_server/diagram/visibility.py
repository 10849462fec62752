"""What can be seen of a folded sheet from above: the exact visible region of each face, and of each edge.

Shapely cuts the regions, but which faces to cut by which is found first, for all of them at once: a running union of what
lies above takes about twice to forty times as long (``benchmarks/diagram.py``), the more the more of the sheet is seen.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import hypot

import numpy as np
import shapely

from folding_server.arrays import Bools, Floats, Geometries, Indices
from folding_server.geometry.graph import Edge, edge_of
from folding_server.geometry.line import Point
from folding_server.geometry.polygon_batch import ConvexPolygons, convex_polygons
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator.paper import Paper

SLIVER = 5 * TOLERANCE
"""Visible parts narrower than this (sheet units) are left out: matching layers differ by about as much."""

SLANTED = 8
"""A side of an outline within a sliver of an edge, and at least so many times longer, is along it within 15 degrees."""

TOUCHING = 1e-9
"""Outlines that cross by no more than this only touch."""

TOPMOST = 16
"""How many faces from the top are tried first as covers of whole faces."""

BLOCK = 256
"""How many faces are held against all others at once."""

Ring = list[Point]
Span = tuple[float, float]
WHOLE: Span = (0.0, 1.0)


@dataclass(frozen=True)
class VisibleFace:
    """The visible parts of a face, each its outer ring and its holes. ``whole`` if nothing covers it."""

    face: int
    back_up: bool
    parts: tuple[tuple[Ring, ...], ...]
    whole: bool

    @property
    def area(self) -> float:
        """Visible area in sheet units squared."""
        return float(sum(shapely.Polygon(part[0], part[1:]).area for part in self.parts))


def visible_faces(paper: Paper) -> list[VisibleFace]:
    """The faces that show at all, bottom to top, with what shows of them."""
    downward = paper.order[::-1]
    outlines = [paper.polygon(face) for face in downward]
    regions, covered, hidden = _uncover(outlines)
    cut = np.flatnonzero(covered & ~hidden)
    pieces = dict(zip(cut.tolist(), _parts(regions[cut]), strict=True))
    seen = []
    for i in np.flatnonzero(~hidden).tolist():
        parts = pieces[i] if covered[i] else ((outlines[i],),)
        if parts:
            seen.append(VisibleFace(downward[i], paper.back_up(downward[i]), parts, not covered[i]))
    return seen[::-1]


def visible_spans(paper: Paper, faces: Iterable[VisibleFace]) -> Mapping[Edge, list[Span]]:
    """For each edge that shows, the visible stretches as fractions from its smaller vertex to the other.

    A stretch of an edge shows where one of the faces beside it shows.
    """
    spans: dict[Edge, list[Span]] = {}
    wholly: dict[Edge, list[Span]] = {}
    for seen in faces:
        cycle = paper.faces[seen.face]
        sides = [edge_of(u, v) for u, v in zip((cycle[-1], *cycle), cycle, strict=False)]
        if seen.whole:
            wholly.update((side, [WHOLE]) for side in sides)
            continue
        for side in sides:
            p, q = (paper.isometries[seen.face](paper.vertices_coords[v]) for v in side)
            found = _stretches(p, q, seen.parts)
            if found:
                spans.setdefault(side, []).extend(found)
    return {edge: _merged(found) for edge, found in spans.items()} | wholly


def _polygons(outlines: list[Ring], needed: Indices) -> Geometries:
    """The outlines as polygons, of the faces that are needed."""
    polygons: Geometries = np.full(len(outlines), None)
    if len(needed):
        rings = [outlines[i] for i in needed.tolist()]
        corners = np.array([point for ring in rings for point in ring], dtype=float)
        indices = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
        polygons[needed] = shapely.polygons(shapely.linearrings(corners, indices=indices))
    return polygons


def _uncover(outlines: list[Ring]) -> tuple[Geometries, Bools, Bools]:
    """Cut away from each outline (listed top to bottom) what lies under the ones before it.

    Faces wholly under one other face go first. The rest are worked through together, one covering face each
    per round. A face that is hidden itself need not cover others: what hides it lies over them as well.
    Returns what is left of each, which lost something, and which are hidden.
    """
    covered, hidden = np.zeros(len(outlines), dtype=bool), np.zeros(len(outlines), dtype=bool)
    lower, upper = _pairs_to_cut(convex_polygons(outlines), hidden)
    polygons = _polygons(outlines, np.union1d(lower, upper))
    regions = polygons.copy()
    while len(lower):
        rest = ~(hidden[lower] | hidden[upper])
        lower, upper = lower[rest], upper[rest]
        first = np.diff(lower, prepend=-1) != 0
        below = lower[first]
        regions[below] = shapely.difference(regions[below], polygons[upper[first]])
        covered[below] = True
        hidden[below] = _hidden(regions[below])
        lower, upper = lower[~first], upper[~first]
    return regions, covered, hidden


def _pairs_to_cut(shapes: ConvexPolygons, hidden: Bools) -> tuple[Indices, Indices]:
    """Pairs (lower, upper) that overlap, by lower face, the largest common box first.

    Faces that another covers wholly are marked in ``hidden`` on the way and do not occur in the pairs. Most
    of them lie under one of the topmost faces, so those are tried first.
    """
    every = np.arange(len(hidden))
    _hide_enclosed(shapes, hidden, *_meeting(shapes, every, every[:TOPMOST]))
    left = np.flatnonzero(~hidden)
    lower, upper, common = _meeting(shapes, left, left)
    _hide_enclosed(shapes, hidden, lower, upper, common)
    meet = ~(hidden[lower] | hidden[upper])
    meet[meet] = shapes.overlaps(lower[meet], upper[meet], TOUCHING)
    lower, upper, common = lower[meet], upper[meet], common[meet]
    order = np.lexsort((-common.prod(axis=1), lower))
    return lower[order], upper[order]


def _meeting(shapes: ConvexPolygons, lower: Indices, upper: Indices) -> tuple[Indices, Indices, Floats]:
    """All pairs of which the upper is above the lower and the boxes overlap, with their common boxes (k, 2)."""
    found = [_meeting_some(shapes, block, upper) for block in np.array_split(lower, 1 + len(lower) // BLOCK)]
    lowers, uppers, common = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return lowers, uppers, common


def _meeting_some(shapes: ConvexPolygons, lower: Indices, upper: Indices) -> tuple[Indices, Indices, Floats]:
    under, over = shapes.boxes[lower].T[:, :, None], shapes.boxes[upper].T[:, None, :]
    width = np.minimum(under[2], over[2]) - np.maximum(under[0], over[0])
    height = np.minimum(under[3], over[3]) - np.maximum(under[1], over[1])
    i, j = np.nonzero((width > TOUCHING) & (height > TOUCHING) & (upper < lower[:, None]))
    return lower[i], upper[j], np.stack([width[i, j], height[i, j]], axis=1)


def _hide_enclosed(
    shapes: ConvexPolygons, hidden: Bools, lower: Indices, upper: Indices, common: Floats
) -> None:
    """Mark the lower faces that lie wholly under their upper face."""
    size = shapes.boxes[lower, 2:] - shapes.boxes[lower, :2]
    enclosed = np.flatnonzero((common >= size - 2 * TOUCHING).all(axis=1))
    under = shapes.contains(upper[enclosed], lower[enclosed], TOUCHING)
    hidden[lower[enclosed][under]] = True


def _hidden(regions: Geometries) -> Bools:
    """Whether what is left of a face is nothing, or nothing but slivers.

    What is small for its outline may still have a part that is wider, with hairlines to it.
    """
    hidden: Bools = 2 * shapely.area(regions) <= SLIVER * shapely.length(regions)
    small = np.flatnonzero(hidden)
    wide = ~shapely.is_empty(shapely.buffer(regions[small], -SLIVER / 2, join_style="mitre"))
    hidden[small[wide]] = False
    return hidden


def _parts(regions: Geometries) -> list[tuple[tuple[Ring, ...], ...]]:
    """For each region its parts that are no slivers, each as its rings, the outer one first."""
    pieces, region_of = shapely.get_parts(regions, return_index=True)
    kept = (shapely.get_type_id(pieces) == shapely.GeometryType.POLYGON) & ~_hidden(pieces)
    rings, piece_of = shapely.get_rings(pieces[kept], return_index=True)
    sizes = shapely.get_num_coordinates(rings)
    corners = shapely.get_coordinates(rings).tolist()
    parts: list[list[list[Ring]]] = [[] for _ in regions]
    by_piece: list[list[Ring]] = [[] for _ in range(int(kept.sum()))]
    start = 0
    for size, piece in zip(sizes.tolist(), piece_of.tolist(), strict=True):
        ring = _without_spikes(corners[start : start + size - 1])
        if ring:
            by_piece[piece].append(ring)
        start += size
    for found, region in zip(by_piece, region_of[kept].tolist(), strict=True):
        if found:
            parts[region].append(found)
    return [tuple(tuple(found) for found in of_region) for of_region in parts]


def _without_spikes(ring: list[list[float]]) -> Ring:
    """The ring without points where it doubles back on itself, which show no area; empty if nothing is left.

    Such hairlines stay open between two covering faces that touch.
    """
    points = [(x, y) for x, y in ring]
    i, steady = 0, 0
    while len(points) > 2 and steady < len(points):
        i %= len(points)
        if _is_spike(points[i - 1], points[i], points[(i + 1) % len(points)]):
            del points[i]
            i, steady = i - 1, 0
        else:
            i, steady = i + 1, steady + 1
    return points if len(points) > 2 else []


def _is_spike(before: Point, tip: Point, after: Point) -> bool:
    """Whether the way to a point and on from it runs back within the width of a sliver, or stays in place."""
    ax, ay = tip[0] - before[0], tip[1] - before[1]
    bx, by = after[0] - tip[0], after[1] - tip[1]
    longer = max(hypot(ax, ay), hypot(bx, by))
    if min(hypot(ax, ay), hypot(bx, by)) <= TOUCHING:
        return True
    return ax * bx + ay * by < 0 and abs(ax * by - ay * bx) <= SLIVER * longer


def _stretches(p: Point, q: Point, parts: Iterable[tuple[Ring, ...]]) -> list[Span]:
    """The stretches of segment pq that run along the outline of the visible parts, as fractions of pq."""
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = hypot(dx, dy)
    if length <= TOLERANCE:
        return []
    ux, uy = dx / length, dy / length
    found: list[Span] = []
    for part in parts:
        for ring in part:
            before = _along(ring[-1], p, ux, uy)
            for point in ring:
                here = _along(point, p, ux, uy)
                if _runs_along(before, here):
                    found.append((min(before[0], here[0]) / length, max(before[0], here[0]) / length))
                before = here
    clipped = ((max(a, 0.0), min(b, 1.0)) for a, b in found)
    return [(a, b) for a, b in clipped if (b - a) * length > TOLERANCE]


def _runs_along(start: Point, end: Point) -> bool:
    """Whether a side of an outline, given along and across an edge, runs along it.

    Where a vertex of a layer above meets the edge within the tolerance, the outline turns off to that vertex, but by no more
    than the width of a sliver, and by another where a spike of that width was taken off it. A side so short that it may as well
    cross the edge has to lie on it.
    """
    far, length = max(abs(start[1]), abs(end[1])), abs(end[0] - start[0])
    return far <= TOLERANCE / 2 or (far <= 2 * SLIVER and length >= SLANTED * max(far, SLIVER))


def _along(point: Point, origin: Point, ux: float, uy: float) -> Point:
    """Coordinates of a point along and across the unit direction from the origin."""
    x, y = point[0] - origin[0], point[1] - origin[1]
    return x * ux + y * uy, y * ux - x * uy


def _merged(spans: list[Span]) -> list[Span]:
    """Overlapping and touching stretches joined."""
    merged: list[Span] = []
    for start, end in sorted(spans):
        if merged and start <= merged[-1][1] + 1e-6:
            merged[-1] = (merged[-1][0], max(merged[-1][1], end))
        else:
            merged.append((start, end))
    return merged
