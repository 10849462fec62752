"""Lines drawn on a sheet as a planar graph: cut where they meet, ends that almost coincide taken as one vertex."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

import shapely

from folding_server.errors import ProgramError
from folding_server.geometry.graph import Edge, edge_of
from folding_server.geometry.line import Point
from folding_server.interchange.cutting import CutLines, lines_cut
from folding_server.interchange.drawn_line import DrawnLine
from folding_server.interchange.gaps import GAP, closed_gaps
from folding_server.interchange.islands import bridges
from folding_server.simulator.foldability import Assignment, CreasePattern, FileAxes, said

L = TypeVar("L", bound=str)

STRENGTH: Mapping[str, int] = {"J": 0, "F": 1, "U": 2, "M": 3, "V": 3, "B": 4, "C": 5}
"""Which assignment counts where lines lie on top of each other: the highest."""


def arranged(
    lines: Sequence[DrawnLine], *, gap: float = GAP, off_sheet: str = "F", axes: FileAxes | None = None
) -> CreasePattern:
    """The crease pattern that lines draw: a vertex wherever two meet, each stretch once, faces left to be found.

    Vertices are listed in the order in which the lines come to them. Ends that miss what they were drawn to meet by up to
    ``gap``, in units of the drawing's longer side, are joined to it and listed in ``joined``. Lines of the assignments
    ``off_sheet`` that lie outside the outline are left out. ``axes`` say where the file has a point. ProgramError if a mountain and a valley lie on top of each other.
    """
    lines, joined, cut = closed_gaps(lines, gap)
    pattern = _cut_pattern(lines, cut, off_sheet, axes)
    marks = [
        DrawnLine(start, end, "F") for start, end in bridges(pattern.vertices_coords, pattern.edges_vertices)
    ]
    if marks:
        lines = [*lines, *marks]
        pattern = _cut_pattern(lines, lines_cut(lines), off_sheet, axes)
    return replace(pattern, joined=joined)


def _cut_pattern(
    lines: Sequence[DrawnLine], cut: CutLines, off_sheet: str, axes: FileAxes | None
) -> CreasePattern:
    vertices = tuple((x, y) for x, y in cut.places.tolist())
    places = [axes.place(vertex) for vertex in vertices] if axes else vertices
    assignments: dict[Edge, Assignment] = {}
    for line, row in zip(lines, cut.passed, strict=True):
        for u, v in pairwise(row):
            edge = edge_of(u, v)
            assignments[edge] = stronger(
                assignments.get(edge, line.assignment), line.assignment, places[u], places[v]
            )
    kept = _within_outline(vertices, assignments, cut.near, off_sheet)
    return CreasePattern(*_without_idle(vertices, list(kept)), tuple(kept.values()), axes=axes)


def stronger(first: L, second: L, u: Sequence[float], v: Sequence[float]) -> L:
    """The assignment of two lines that lie on top of each other from u to v. ProgramError for a mountain and a valley."""
    if {first, second} == {"M", "V"}:
        raise ProgramError(
            f"A mountain and a valley lie on top of each other from {said(tuple(u))} to {said(tuple(v))}; remove one of them."
        )
    return max(first, second, key=STRENGTH.__getitem__)


def _within_outline(
    vertices: Sequence[Point], assignments: Mapping[Edge, Assignment], near: float, off_sheet: str
) -> dict[Edge, Assignment]:
    """The edges without those of some assignments that lie outside the sheet, where there is an outline."""
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
        if assignment not in off_sheet or grown.covers(shapely.LineString([vertices[u], vertices[v]]))
    }


def _without_idle(
    vertices: Sequence[Point], edges: Sequence[Edge]
) -> tuple[tuple[Point, ...], tuple[Edge, ...]]:
    """The vertices that edges use, and the edges by their new numbers."""
    used = sorted({v for edge in edges for v in edge})
    number = {v: i for i, v in enumerate(used)}
    return tuple(vertices[v] for v in used), tuple((number[u], number[v]) for u, v in edges)
