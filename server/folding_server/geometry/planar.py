"""Faces of a planar straight-line graph, and what makes a graph no crease pattern."""

from collections.abc import Iterator, Mapping, Sequence
from math import atan2

import networkx as nx
import numpy as np
import shapely

from folding_server.arrays import Floats
from folding_server.geometry.convex import area
from folding_server.geometry.graph import Cycle, Edge
from folding_server.geometry.line import Point


def boundary_cycles(
    vertices: Sequence[Point], edges: Sequence[Edge], faces: Sequence[Cycle]
) -> tuple[Cycle, ...]:
    """The faces given, or else those the edges enclose, each counter-clockwise."""
    if faces:
        return tuple(cycle if _area(vertices, cycle) > 0 else cycle[::-1] for cycle in faces)
    bounding = without_dead_ends(edges)
    return tuple(cycle for cycle in _walks(vertices, bounding) if _area(vertices, cycle) > 0)


def without_dead_ends(edges: Sequence[Edge]) -> list[Edge]:
    """The edges without those that end in a vertex no other edge meets, again and again: they bound no face."""
    core = nx.k_core(nx.Graph(edges), 2)
    return [edge for edge in edges if edge in core.edges]


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
    points = np.array(vertices, float).reshape(-1, 2)
    segments = np.asarray(shapely.linestrings(points[np.array(edges, int).reshape(-1, 2)]))
    pairs = shapely.STRtree(segments).query(segments, predicate="intersects").T
    for i, j in pairs[pairs[:, 0] < pairs[:, 1]]:
        shared = len(set(edges[i]) & set(edges[j]))
        if shared in {0, 2} or _run_together(points, edges[i], edges[j]):
            return int(i), int(j)
    return None


def _run_together(points: Floats, first: Edge, second: Edge) -> bool:
    """Whether two edges with one common end leave it in exactly one direction."""
    (common,) = set(first) & set(second)
    u, v = ((set(edge) - {common}).pop() for edge in (first, second))
    a, b = points[u] - points[common], points[v] - points[common]
    return bool(a[0] * b[1] == a[1] * b[0] and a @ b > 0)
