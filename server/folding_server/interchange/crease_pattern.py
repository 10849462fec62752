"""The crease pattern as a record by itself, and the faces of a planar pattern given by its edges alone."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2

from folding_server.errors import ProgramError
from folding_server.simulator.paper import Paper
from folding_server.simulator.plane_geometry import Point, area

Assignment = str
"""One of the letters of FOLD: B boundary, M mountain, V valley, F flat, U unassigned."""


@dataclass(frozen=True)
class CreasePattern:
    """An unfolded sheet with its creases, by index; nothing is known of how it lies when folded.

    ``vertices``     places on the sheet
    ``edges``        pairs of vertex indices
    ``assignments``  a letter for each edge: B, M, V, F or U
    ``faces``        boundary cycles of vertex indices, counter-clockwise, so that normals point out of the front
    """

    vertices: tuple[Point, ...]
    edges: tuple[tuple[int, int], ...]
    assignments: tuple[Assignment, ...]
    faces: tuple[tuple[int, ...], ...]

    @property
    def folded(self) -> bool:
        """Whether every crease has a letter that says if it is folded."""
        return "U" not in self.assignments


def crease_pattern_of(paper: Paper) -> CreasePattern:
    """The crease pattern of a paper, vertices by ascending id, faces in the paper's order of ids."""
    index = {v: i for i, v in enumerate(sorted(paper.places))}
    edges = list(paper.edges())
    return CreasePattern(
        tuple(paper.places[v] for v in index),
        tuple((index[u], index[v]) for (u, v), _ in edges),
        tuple(letter for _, letter in edges),
        tuple(counterclockwise([index[v] for v in cycle], paper.sheet_polygon(f)) for f, cycle in paper.faces.items()),
    )


def counterclockwise(cycle: Sequence[int], outline: Sequence[Point]) -> tuple[int, ...]:
    """The cycle, turned round if its outline runs clockwise; the first vertex stays first."""
    return tuple(cycle) if area(outline) > 0 else turned_round(cycle)


def turned_round(cycle: Sequence[int]) -> tuple[int, ...]:
    """The same cycle the other way round, from the same first vertex."""
    return (cycle[0], *reversed(cycle[1:]))


def planar_faces(vertices: Sequence[Point], edges: Sequence[tuple[int, int]]) -> tuple[tuple[int, ...], ...]:
    """The inner faces of a connected planar pattern, counter-clockwise, each from its smallest vertex.

    Follows every edge in both directions, turning as far left as possible at each vertex. ProgramError if edges cross
    without a vertex or the pattern is in several pieces: then the faces found do not tile what their outline encloses.
    """
    after = _turns(vertices, edges)
    unused = dict.fromkeys(after)
    inner = []
    while unused:
        cycle = _walk(next(iter(unused)), after)
        for step in cycle:
            del unused[step]
        corners = [u for u, _ in cycle]
        size = area([vertices[v] for v in corners])
        if size > 0:
            first = corners.index(min(corners))
            inner.append((*corners[first:], *corners[:first]))
    _check_planar(vertices, edges, inner)
    return tuple(sorted(inner))


def _turns(vertices: Sequence[Point], edges: Sequence[tuple[int, int]]) -> dict[tuple[int, int], tuple[int, int]]:
    """Directed edge -> the directed edge that follows it around the face on its left."""
    around: dict[int, list[int]] = {}
    for u, v in edges:
        around.setdefault(u, []).append(v)
        around.setdefault(v, []).append(u)
    after = {}
    for v, neighbours in around.items():
        x, y = vertices[v]
        neighbours.sort(key=lambda w: atan2(vertices[w][1] - y, vertices[w][0] - x))
        for i, w in enumerate(neighbours):
            after[(w, v)] = (v, neighbours[i - 1])
    return after


def _walk(start: tuple[int, int], after: dict[tuple[int, int], tuple[int, int]]) -> list[tuple[int, int]]:
    cycle = [start]
    while (step := after[cycle[-1]]) != start:
        cycle.append(step)
    return cycle


def _check_planar(vertices: Sequence[Point], edges: Sequence[tuple[int, int]], inner: Sequence[Sequence[int]]) -> None:
    """Euler's formula for a connected planar graph: V - E + F = 1, the outside not counted."""
    used = {v for edge in edges for v in edge}
    if len(used) - len(edges) + len(inner) != 1:
        raise ProgramError(
            f"The crease pattern ({len(used)} vertices, {len(edges)} edges) has no plain faces: edges cross where there "
            "is no vertex, or parts of it are not connected; split edges where they meet, or give faces_vertices."
        )
