"""Faces of a planar straight-line graph, and what makes a graph no crease pattern."""

from collections.abc import Iterator, Mapping, Sequence
from math import atan2

import networkx as nx
import numpy as np
import shapely

from folding_server.arrays import Bools, Floats, Ints
from folding_server.geometry.convex import area
from folding_server.geometry.graph import Cycle, Edge
from folding_server.geometry.line import Point

FEW_EDGES = 3000
"""Edges of which all pairs fit into memory: comparing boxes is quick, and exact tests of many through one point are not."""


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
    return next(iter(all_crossings(vertices, edges)), None)


def all_crossings(vertices: Sequence[Point], edges: Sequence[Edge]) -> list[Edge]:
    """The indices i < j of all pairs of edges that meet elsewhere than in a common vertex."""
    points = np.array(vertices, float).reshape(-1, 2)
    ends = np.array(edges, int).reshape(-1, 2)
    segments = np.asarray(shapely.linestrings(points[ends]))
    tree = shapely.STRtree(segments)
    i, j = tree.query(segments) if len(edges) <= FEW_EDGES else tree.query(segments, predicate="intersects")
    i, j = i[i < j], j[i < j]
    same = ends[i][:, :, None] == ends[j][:, None, :]
    common = same.any(axis=(1, 2))
    both = same.any(axis=2).all(axis=1)
    apart = np.flatnonzero(~common)
    found = np.zeros(len(i), bool)
    found[apart] = shapely.intersects(segments[i[apart]], segments[j[apart]])
    found |= both | (common & _run_together(points, ends[i], ends[j], same))
    return [(int(a), int(b)) for a, b in zip(i[found], j[found], strict=True)]


def _run_together(points: Floats, first: Ints, second: Ints, same: Bools) -> Bools:
    """Whether edges (n, 2) with one common end leave it in exactly one direction; ``same`` (n, 2, 2) says which end it is."""
    rows = np.arange(len(first))
    k, m = same.any(axis=2).argmax(axis=1), same.any(axis=1).argmax(axis=1)
    a = points[first[rows, 1 - k]] - points[first[rows, k]]
    b = points[second[rows, 1 - m]] - points[second[rows, m]]
    level: Bools = (a[:, 0] * b[:, 1] == a[:, 1] * b[:, 0]) & ((a * b).sum(axis=1) > 0)
    return level
