"""Lines drawn on a sheet as a planar graph: cut where they meet, ends that almost coincide taken as one vertex."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import hypot
from typing import TypeVar

import numpy as np
import shapely

from folding_server.arrays import Floats
from folding_server.errors import ProgramError
from folding_server.geometry.graph import Edge, component_of, edge_of
from folding_server.geometry.line import Point
from folding_server.simulator.foldability import Assignment, CreasePattern

L = TypeVar("L", bound=str)

COINCIDENT = 1e-5
"""Points nearer than this, in units of the drawing's longer side, are one: coordinates may be rounded to five digits."""

STRENGTH: Mapping[str, int] = {"J": 0, "F": 1, "U": 2, "M": 3, "V": 3, "B": 4, "C": 5}
"""Which assignment counts where lines lie on top of each other: the highest."""


@dataclass(frozen=True)
class DrawnLine:
    """A straight line from one point to another, in any unit, with the assignment of the crease it stands for."""

    start: Point
    end: Point
    assignment: Assignment


def arranged(lines: Sequence[DrawnLine]) -> CreasePattern:
    """The crease pattern that lines draw: a vertex wherever two meet, each stretch once, faces left to be found.

    Vertices are listed in the order in which the lines come to them. A mark outside the outline is left out. ProgramError
    if a mountain and a valley lie on top of each other.
    """
    ends = np.array([(line.start, line.end) for line in lines], float).reshape(-1, 2, 2)
    near = COINCIDENT * float(np.ptp(ends.reshape(-1, 2), axis=0).max(initial=0.0))
    cuts = _cuts(ends, near)
    points = np.array([p for row in cuts for p in row]).reshape(-1, 2)
    vertex_of = one_vertex_each(points, near)
    vertices = tuple((float(x), float(y)) for x, y in points[_firsts(vertex_of)])
    assignments: dict[Edge, Assignment] = {}
    taken = iter(vertex_of)
    for line, row in zip(lines, cuts, strict=True):
        passed = [next(taken) for _ in row]
        for u, v in pairwise(passed):
            if u != v:
                edge = edge_of(u, v)
                assignments[edge] = stronger(
                    assignments.get(edge, line.assignment), line.assignment, vertices[u], vertices[v]
                )
    kept = _within_outline(vertices, assignments, near)
    return CreasePattern(*_without_idle(vertices, list(kept)), tuple(kept.values()))


def one_vertex_each(points: Floats, near: float) -> list[int]:
    """For each point (n, 2) the number of its vertex; points nearer than that share one. Numbered as they come."""
    marks = np.asarray(shapely.points(points))
    pairs = shapely.STRtree(marks).query(marks, predicate="dwithin", distance=near).T.tolist()
    first = component_of(range(len(points)), pairs)
    numbers: dict[int, int] = {}
    return [numbers.setdefault(first[i], len(numbers)) for i in range(len(points))]


def stronger(first: L, second: L, u: Sequence[float], v: Sequence[float]) -> L:
    """The assignment of two lines that lie on top of each other from u to v. ProgramError for a mountain and a valley."""
    if {first, second} == {"M", "V"}:
        raise ProgramError(
            f"A mountain and a valley lie on top of each other from ({u[0]:g}, {u[1]:g}) to ({v[0]:g}, {v[1]:g}); "
            "remove one of them."
        )
    return max(first, second, key=STRENGTH.__getitem__)


def _firsts(vertex_of: Sequence[int]) -> list[int]:
    """The index of the first point of each vertex."""
    first: dict[int, int] = {}
    for i, vertex in enumerate(vertex_of):
        first.setdefault(vertex, i)
    return list(first.values())


def _cuts(ends: Floats, near: float) -> list[list[Point]]:
    """For each segment (n, 2, 2) the points at which it is cut, from its start to its end."""
    segments = np.asarray(shapely.linestrings(ends))
    at: list[list[float]] = [[0.0, 1.0] for _ in ends]
    for i, j in shapely.STRtree(segments).query(segments, predicate="dwithin", distance=near).T:
        if i != j:
            at[i] += _meetings(ends[i], ends[j], near)
    return [[_along(segment, t) for t in sorted(set(row))] for segment, row in zip(ends, at, strict=True)]


def _meetings(segment: Floats, other: Floats, near: float) -> Iterable[float]:
    """Where, as fractions of a segment, another touches or crosses it."""
    run, theirs = segment[1] - segment[0], other[1] - other[0]
    length = hypot(*run)
    if length <= near:
        return
    for end in other:
        arm = end - segment[0]
        t = float(arm @ run) / length**2
        if 0 < t < 1 and abs(run[0] * arm[1] - run[1] * arm[0]) / length <= near:
            yield t
    across = float(run[0] * theirs[1] - run[1] * theirs[0])
    if abs(across) > near * length:
        arm = other[0] - segment[0]
        t = float(arm[0] * theirs[1] - arm[1] * theirs[0]) / across
        s = float(arm[0] * run[1] - arm[1] * run[0]) / across
        if 0 < t < 1 and 0 < s < 1:
            yield t


def _along(segment: Floats, t: float) -> Point:
    """The point a fraction of the way along a segment; its own ends exactly."""
    x, y = segment[int(t)] if t in {0.0, 1.0} else segment[0] + t * (segment[1] - segment[0])
    return float(x), float(y)


def _within_outline(
    vertices: Sequence[Point], assignments: Mapping[Edge, Assignment], near: float
) -> dict[Edge, Assignment]:
    """The edges without the marks that lie outside the sheet, where there is an outline."""
    outline = [
        shapely.LineString([vertices[u], vertices[v]])
        for (u, v), assignment in assignments.items()
        if assignment == "B"
    ]
    sheet = shapely.union_all(shapely.get_parts(shapely.polygonize(outline)))
    if sheet.is_empty:
        return dict(assignments)
    grown = shapely.buffer(sheet, 2 * near)
    shapely.prepare(grown)
    return {
        (u, v): assignment
        for (u, v), assignment in assignments.items()
        if assignment != "F" or grown.covers(shapely.LineString([vertices[u], vertices[v]]))
    }


def _without_idle(
    vertices: Sequence[Point], edges: Sequence[Edge]
) -> tuple[tuple[Point, ...], tuple[Edge, ...]]:
    """The vertices that edges use, and the edges by their new numbers."""
    used = sorted({v for edge in edges for v in edge})
    number = {v: i for i, v in enumerate(used)}
    return tuple(vertices[v] for v in used), tuple((number[u], number[v]) for u, v in edges)
