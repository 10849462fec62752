"""The crease pattern of a paper with its faces as files list them."""

from collections.abc import Sequence

from folding_server.geometry.convex import area
from folding_server.geometry.line import Point
from folding_server.simulator.foldability import Assignment, CreasePattern
from folding_server.simulator.paper import Paper

FOLD_ASSIGNMENTS: dict[str, Assignment] = {"B": "B", "M": "M", "V": "V", "F": "F", "U": "U", "J": "F"}
"""Assignments of FOLD files as those of a pattern: a join (J) only divides a face for the sake of the file."""


def crease_pattern_of(paper: Paper) -> CreasePattern:
    """The crease pattern of a paper: vertices by ascending id, faces in the paper's own order.

    Faces run counter-clockwise, so that normals point out of the front, and start where the
    paper's cycles start.
    """
    index = {v: i for i, v in enumerate(sorted(paper.vertices_coords))}
    edges = list(paper.edges())
    return CreasePattern(
        vertices_coords=tuple(paper.vertices_coords[v] for v in index),
        edges_vertices=tuple((index[u], index[v]) for (u, v), _ in edges),
        edges_assignment=tuple(FOLD_ASSIGNMENTS[assignment] for _, assignment in edges),
        faces_vertices=tuple(
            counterclockwise([index[v] for v in cycle], paper.sheet_polygon(f))
            for f, cycle in paper.faces.items()
        ),
        names=tuple(index),
    )


def counterclockwise(cycle: Sequence[int], outline: Sequence[Point]) -> tuple[int, ...]:
    """The cycle, turned round if its outline runs clockwise; the first vertex stays first."""
    return tuple(cycle) if area(outline) > 0 else turned_round(cycle)


def turned_round(cycle: Sequence[int]) -> tuple[int, ...]:
    """The same cycle the other way round, from the same first vertex."""
    return (cycle[0], *reversed(cycle[1:]))
