"""Segments cut where they meet: vertices, and for each segment those it passes.

Linear where many meet in one point: ends are gathered into vertices first, and segments with a common vertex are not cut anew.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from folding_server.arrays import Bools, Floats, Indices, Ints
from folding_server.geometry.graph import component_of
from folding_server.geometry.planar import with_common_end
from folding_server.interchange.drawn_line import COINCIDENT, DrawnLine

FEW = 3000
"""Segments of which all pairs fit into memory: comparing boxes is quick, and exact distances of many through one point are not."""
SHORTEST = 1e-150
"""Instead of a length of zero, where one divides by its square."""


@dataclass(frozen=True)
class CutLines:
    """Lines cut where they meet: ``places`` (k, 2) of the vertices, for each line the numbers of those that it ``passed`` from its
    start to its end, and how ``near`` points are one vertex.
    """

    places: Floats
    passed: list[list[int]]
    near: float


def lines_cut(lines: Sequence[DrawnLine]) -> CutLines:
    """Lines cut where they meet, ends that almost coincide taken as one vertex."""
    ends = np.array([(line.start, line.end) for line in lines], float).reshape(-1, 2, 2)
    near = COINCIDENT * span_of(ends)
    return CutLines(*segments_cut(ends, near), near)


def span_of(ends: Floats) -> float:
    """The longer side of the box around segments (n, 2, 2)."""
    return float(np.ptp(ends.reshape(-1, 2), axis=0).max(initial=0.0)) if len(ends) else 0.0


def segments_cut(ends: Floats, near: float) -> tuple[Floats, list[list[int]]]:
    """The vertices (k, 2) of segments (n, 2, 2), and for each the numbers of those it passes from its start to its end.

    Points nearer than ``near`` are one vertex, at the first of them; vertices nearer to a segment cut it.
    """
    count = len(ends)
    vertex = np.array(one_vertex_each(ends.reshape(-1, 2), near), int)
    snapped = ends.reshape(-1, 2)[_firsts(vertex)][vertex].reshape(-1, 2, 2)
    first, second = _neighbours(snapped, near)
    met = vertex.reshape(-1, 2)
    apart = ~with_common_end(met[first], met[second])
    crossings, i, j = _crossings(snapped, first[apart], second[apart], near)
    points = np.concatenate([ends.reshape(-1, 2), crossings])
    numbers = np.array(one_vertex_each(points, near), int)
    places = points[_firsts(numbers)]
    passed = [numbers[: 2 * count].reshape(-1, 2)[:, k] for k in (0, 1)]
    at_crossing = numbers[2 * count :]
    segment = np.concatenate([np.arange(count), np.arange(count), i, j])
    number = np.concatenate([*passed, at_crossing, at_crossing])
    touched, touching = _touched(places, snapped, near)
    segment, number = np.concatenate([segment, touched]), np.concatenate([number, touching])
    return places, _in_order(places, snapped, segment, number)


def one_vertex_each(points: Floats, near: float) -> list[int]:
    """For each point (n, 2) the number of its vertex; points nearer than that share one. Numbered as they come."""
    if not len(points):
        return []
    grid = max(near, 1e-300) / 2
    _, first, cell = np.unique(np.floor(points / grid), axis=0, return_index=True, return_inverse=True)
    marks = np.asarray(shapely.points(points[first]))
    pairs = shapely.STRtree(marks).query(marks, predicate="dwithin", distance=near).T.tolist()
    joined = component_of(range(len(first)), pairs)
    numbers: dict[int, int] = {}
    return [numbers.setdefault(joined[each], len(numbers)) for each in cell.reshape(-1).tolist()]


def _firsts(vertex_of: Ints) -> Indices:
    """The index of the first point of each vertex."""
    firsts: Indices = np.unique(vertex_of, return_index=True)[1]
    return firsts


def _boxes(segments: Floats, near: float) -> np.ndarray:
    low, high = segments.min(axis=1) - near, segments.max(axis=1) + near
    return np.asarray(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))


def _neighbours(segments: Floats, near: float) -> tuple[Indices, Indices]:
    """The pairs i < j of segments that may meet: of few, those whose boxes do, of many, those that are near each other."""
    if len(segments) <= FEW:
        boxes = _boxes(segments, near)
        i, j = shapely.STRtree(boxes).query(boxes)
    else:
        lines = np.asarray(shapely.linestrings(segments))
        i, j = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=near)
    return i[i < j], j[i < j]


def _cross(a: Floats, b: Floats) -> Floats:
    crossed: Floats = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return crossed


def _crossings(segments: Floats, i: Indices, j: Indices, near: float) -> tuple[Floats, Indices, Indices]:
    """Where pairs of segments cross inside both, and which those are."""
    run, theirs = segments[i, 1] - segments[i, 0], segments[j, 1] - segments[j, 0]
    across = _cross(run, theirs)
    crosses = np.abs(across) > near * np.maximum(np.hypot(*run.T), np.hypot(*theirs.T))
    arm = segments[j, 0] - segments[i, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t, s = _cross(arm, theirs) / across, _cross(arm, run) / across
    crosses &= (t > 0) & (t < 1) & (s > 0) & (s < 1)
    points: Floats = segments[i, 0][crosses] + t[crosses, None] * run[crosses]
    return points, i[crosses], j[crosses]


def _touched(places: Floats, segments: Floats, near: float) -> tuple[Indices, Indices]:
    """(segment, vertex): the vertices that lie inside a segment, or so near that they cut it."""
    marks = np.asarray(shapely.points(places))
    tree = shapely.STRtree(marks)
    if len(segments) <= FEW:
        segment, number = tree.query(_boxes(segments, near))
    else:
        lines = np.asarray(shapely.linestrings(segments))
        segment, number = tree.query(lines, predicate="dwithin", distance=near)
    run, arm = segments[segment, 1] - segments[segment, 0], places[number] - segments[segment, 0]
    length = np.maximum(np.hypot(*run.T), SHORTEST)
    t = (arm * run).sum(axis=1) / length**2
    inside: Bools = (length > near) & (t > 0) & (t < 1) & (np.abs(_cross(run, arm)) / length <= near)
    return segment[inside], number[inside]


def _in_order(places: Floats, segments: Floats, segment: Indices, number: Ints) -> list[list[int]]:
    """For each segment its vertices from its start to its end, each once."""
    run = segments[segment, 1] - segments[segment, 0]
    along = ((places[number] - segments[segment, 0]) * run).sum(axis=1)
    order = np.lexsort((along, segment))
    rows: list[list[int]] = [[] for _ in segments]
    for k, v in zip(segment[order].tolist(), number[order].tolist(), strict=True):
        if v not in rows[k][-2:]:
            rows[k].append(v)
    return [list(dict.fromkeys(row)) if len(row) > 2 else row for row in rows]
