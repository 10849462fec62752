"""Subdividing edges: the action ``add_vertex`` and the look-ups that name what is wrong with an edge."""

from collections.abc import Iterable
from dataclasses import replace

from folding_server.errors import ActionRefused
from folding_server.geometry.graph import Edge, edge_of
from folding_server.geometry.line import between
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator.paper import Paper


def add_vertex(paper: Paper, edge: Edge, position: float) -> Paper:
    """Subdivide an existing edge at ``position`` in (0, 1) of the way from its first vertex.

    The new vertex takes the highest id + 1. Raises ActionRefused for an unknown vertex, two vertices that no edge
    joins, and a position outside 0 to 1 or so near an end that it is that end.
    """
    u, v = known_edge(paper, edge)
    p, q = paper.vertices_coords[u], paper.vertices_coords[v]
    length = ((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2) ** 0.5
    if not 0 <= position <= 1:
        raise ActionRefused(f"Position {position:g} is outside edge [{u}, {v}]; give a fraction from 0 to 1.")
    for end, gap in ((u, position * length), (v, (1 - position) * length)):
        if gap <= TOLERANCE:
            raise ActionRefused(
                f"Position {position:g} on edge [{u}, {v}] is vertex {end} itself; use that vertex instead."
            )
    new = max(paper.vertices_coords) + 1
    faces, creases = dict(paper.faces), dict(paper.creases)
    for face in paper.edge_faces[edge_of(u, v)]:
        faces[face] = insert_vertex(faces[face], u, v, new)
    record = creases.pop(edge_of(u, v), None)
    if record is not None:
        creases[edge_of(u, new)] = creases[edge_of(new, v)] = record
    return replace(
        paper,
        vertices_coords={**paper.vertices_coords, new: between(p, q, position)},
        faces=faces,
        creases=creases,
    )


def insert_vertex(cycle: tuple[int, ...], u: int, v: int, new: int) -> tuple[int, ...]:
    """A face's cycle with a vertex put between two neighbours."""
    i = cycle.index(u)
    if cycle[i - 1] == v:
        return (*cycle[:i], new, *cycle[i:])
    return (*cycle[: i + 1], new, *cycle[i + 1 :])


def known_vertices(paper: Paper, vertices: Iterable[int]) -> None:
    """Raise ActionRefused naming the first vertex that the paper does not have."""
    for v in vertices:
        if v not in paper.vertices_coords:
            raise ActionRefused(
                f"There is no vertex {v}; the vertices are {id_ranges(paper.vertices_coords)}. Use add_vertex to make a new one."
            )


def known_edge(paper: Paper, edge: Edge) -> Edge:
    """The edge as given, if both its vertices exist and an edge joins them; ActionRefused otherwise."""
    known_vertices(paper, edge)
    u, v = edge
    if edge_of(u, v) not in paper.edge_faces:
        joined = sorted({w for e in paper.edge_faces if u in e for w in e} - {u})
        raise ActionRefused(f"No edge joins {u} and {v}; edges from {u} lead to {id_ranges(joined)}.")
    return edge


def id_ranges(numbers: Iterable[int]) -> str:
    """Ids in words: runs shortened, as in ``1 to 9, 12``."""
    runs: list[list[int]] = []
    for n in sorted(numbers):
        if runs and n == runs[-1][-1] + 1:
            runs[-1].append(n)
        else:
            runs.append([n])
    parts = [f"{r[0]} to {r[-1]}" if len(r) > 2 else ", ".join(map(str, r)) for r in runs]
    return ", ".join(parts)
