"""Faces of a planar straight-line graph, and what makes a graph no crease pattern."""

from collections.abc import Iterator, Mapping, Sequence
from math import atan2

import numpy as np
import shapely

from folding_server.arrays import Bools, Floats, Ints
from folding_server.geometry.convex import area
from folding_server.geometry.graph import Cycle, Edge, without_dead_ends
from folding_server.geometry.line import Point

FEW_EDGES = 3000
"""Edges of which all pairs fit into memory: comparing boxes is quick, and exact tests of many through one point are not."""
SURELY_BESIDE = 1e-9
"""By how much, as the sine of an angle, a point is clearly beside a line: a million times what rounding comes to."""
TURNED = 1e-9
"""Radians between two directions beyond which they are surely not the same: a million times what rounding of angles comes to."""


def boundary_cycles(
    vertices: Sequence[Point], edges: Sequence[Edge], faces: Sequence[Cycle]
) -> tuple[Cycle, ...]:
    """The faces given, or else those the edges enclose, each counter-clockwise."""
    if faces:
        return tuple(cycle if _area(vertices, cycle) > 0 else cycle[::-1] for cycle in faces)
    bounding = without_dead_ends(edges)
    return tuple(cycle for cycle in _walks(vertices, bounding) if _area(vertices, cycle) > 0)


def _area(vertices: Sequence[Point], cycle: Cycle) -> float:
    """The signed area of a cycle, positive if it runs counter-clockwise."""
    return area([vertices[v] for v in cycle])


def _walks(vertices: Sequence[Point], edges: Sequence[Edge]) -> Iterator[Cycle]:
    """Walk every side of every edge once, turning as sharply left as possible: the faces and the outside."""
    after = _successors(vertices, edges)
    unused = set(after)
    for start in sorted(after):
        if start not in unused:
            continue
        cycle, step = [], start
        while step in unused:
            unused.discard(step)
            cycle.append(step[0])
            step = after[step]
        yield tuple(cycle)


def _successors(vertices: Sequence[Point], edges: Sequence[Edge]) -> Mapping[Edge, Edge]:
    """Each directed edge u -> v with the next around the face on its left."""
    around: dict[int, list[int]] = {}
    for u, v in edges:
        around.setdefault(u, []).append(v)
        around.setdefault(v, []).append(u)
    after = {}
    for v, ends in around.items():
        x, y = vertices[v]
        ends.sort(key=lambda w: atan2(vertices[w][1] - y, vertices[w][0] - x))
        for i, w in enumerate(ends):
            after[w, v] = (v, ends[i - 1])
    return after


def crossing_edges(vertices: Sequence[Point], edges: Sequence[Edge]) -> Edge | None:
    """The indices of two edges that meet elsewhere than in a common vertex, or None if the graph is planar."""
    return next(iter(all_crossings(vertices, edges)), None)


def all_crossings(vertices: Sequence[Point], edges: Sequence[Edge]) -> list[Edge]:
    """The indices i < j of all pairs of edges that meet elsewhere than in a common vertex, ascending."""
    points = np.array(vertices, float).reshape(-1, 2)
    ends = np.array(edges, int).reshape(-1, 2)
    found = np.concatenate([_apart_and_crossing(points, ends), _run_together(points, ends)])
    return [(i, j) for i, j in np.unique(found, axis=0).tolist()]


def with_common_end(first: Ints, second: Ints) -> Bools:
    """(n,): whether edges (n, 2) have a vertex in common, row by row."""
    (a, b), (c, d) = first.T, second.T
    return np.asarray((a == c) | (a == d) | (b == c) | (b == d))


def _apart_and_crossing(points: Floats, ends: Ints) -> Ints:
    """(n, 2): the pairs i < j of edges without a common vertex that meet."""
    segments = np.asarray(shapely.linestrings(points[ends]))
    tree = shapely.STRtree(segments)
    i, j = tree.query(segments) if len(ends) <= FEW_EDGES else tree.query(segments, predicate="intersects")
    i, j = i[i < j], j[i < j]
    near = ~with_common_end(ends[i], ends[j])
    for first, second in ((i, j), (j, i)):
        near[near] = ~_on_one_side(points[ends[first[near]]], points[ends[second[near]]])
    i, j = i[near], j[near]
    meet = shapely.intersects(segments[i], segments[j])
    return np.stack([i[meet], j[meet]], axis=1)


def _on_one_side(first: Floats, second: Floats) -> Bools:
    """(n,): whether segments (n, 2, 2) clearly lie on one side of the line through others, row by row."""
    run, arms = first[:, 1] - first[:, 0], second - first[:, :1]
    away = run[:, None, 0] * arms[..., 1] - run[:, None, 1] * arms[..., 0]
    rounding = SURELY_BESIDE * np.abs(run).sum(axis=1) * np.abs(arms).max(axis=(1, 2))
    return np.asarray((away.min(axis=1) > rounding) | (away.max(axis=1) < -rounding))


def _run_together(points: Floats, ends: Ints) -> Ints:
    """(n, 2): the pairs i < j of edges that leave a common vertex in exactly one direction, or have both vertices in common.

    Only those are compared that follow each other around the vertex and turn by less than ``TURNED``.
    """
    here, there = ends.T.reshape(-1), ends[:, ::-1].T.reshape(-1)
    edge = np.tile(np.arange(len(ends)), 2)
    run = points[there] - points[here] + 0.0
    turn = np.arctan2(run[:, 1], run[:, 0])
    order = np.lexsort((turn, here))
    here, there, edge, run, turn = here[order], there[order], edge[order], run[order], turn[order]
    found, first = [np.zeros((0, 2), int)], np.arange(len(order))
    for after in range(1, len(order)):
        first = first[first + after < len(order)]
        second = first + after
        close = (here[first] == here[second]) & (turn[second] - turn[first] <= TURNED)
        first, second = first[close], second[close]
        if not len(first):
            break
        a, b = run[first], run[second]
        level = (a[:, 0] * b[:, 1] == a[:, 1] * b[:, 0]) & ((a * b).sum(axis=1) > 0)
        kept = level | (there[first] == there[second])
        found.append(np.sort(np.stack([edge[first][kept], edge[second][kept]], axis=1), axis=1))
    return np.concatenate(found)
