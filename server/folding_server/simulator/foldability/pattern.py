"""A crease pattern as a record: what foldability is asked of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

from folding_server.errors import ProgramError
from folding_server.geometry.graph import Cycle, Edge, edge_faces, edge_of, sides
from folding_server.geometry.line import Point
from folding_server.geometry.planar import boundary_cycles
from folding_server.simulator.foldability.fault import FilePlace
from folding_server.simulator.paper import Paper

Assignment = Literal["B", "M", "V", "F", "U"]
"""Boundary, mountain, valley, flat (a mark), or a crease whose direction is not given."""

FOLDED_ASSIGNMENTS = frozenset("MVU")
"""Assignments of creases that are folded: an unassigned one is folded one way or the other."""

ASSIGNMENTS: Mapping[str, Assignment] = {assignment: assignment for assignment in get_args(Assignment)}
"""Every assignment of a pattern by itself, to check and narrow plain strings with."""


@dataclass(frozen=True)
class FileAxes:
    """How coordinates of a sheet stand in a file: (x, y) is ``origin`` + x ``right`` + y ``up``, in two or three dimensions."""

    origin: FilePlace
    right: FilePlace
    up: FilePlace

    def place(self, point: Point) -> FilePlace:
        """Where the file has a point."""
        return tuple(
            o + point[0] * a + point[1] * b for o, a, b in zip(self.origin, self.right, self.up, strict=True)
        )


Y_DOWN = FileAxes((0.0, 0.0), (1.0, 0.0), (0.0, -1.0))
"""The axes of drawings on a screen."""


@dataclass(frozen=True)
class JoinedEnd:
    """An end of a line that missed what it was meant to meet: where it was, where it is, on the sheet, and how far that is
    in units of the sheet's longer side.
    """

    before: Point
    after: Point
    gap: float


@dataclass(frozen=True)
class PatternCrease:
    """An edge between two faces, ``left`` of u -> v on the sheet and ``right`` of it."""

    edge: Edge
    assignment: Assignment
    left: int
    right: int

    @property
    def folded(self) -> bool:
        """Whether the two faces lie on top of each other at this crease."""
        return self.assignment in FOLDED_ASSIGNMENTS


@dataclass(frozen=True)
class CreasePattern:
    """A planar straight-line graph on the unfolded sheet, in FOLD's words.

    ``vertices_coords``    (x, y) of each vertex, in any unit
    ``edges_vertices``     pairs of indices of vertices
    ``edges_assignment``   one for each edge
    ``faces_vertices``     boundary cycles of indices of vertices; empty if they are to be found from the edges
    ``names``              what each vertex is called in messages; its index if empty
    ``axes``               where the file that it was read from has a point; the same coordinates if None
    ``joined``             ends of lines that were moved onto what they missed
    ``notes``              sentences on what else was read otherwise than it stands in the file
    """

    vertices_coords: tuple[Point, ...]
    edges_vertices: tuple[Edge, ...]
    edges_assignment: tuple[Assignment, ...]
    faces_vertices: tuple[Cycle, ...] = ()
    names: tuple[int, ...] = ()
    axes: "FileAxes | None" = None
    joined: "tuple[JoinedEnd, ...]" = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if len(self.edges_assignment) != len(self.edges_vertices):
            raise ProgramError(
                f"There are {len(self.edges_vertices)} edges but {len(self.edges_assignment)} letters; give one letter for each edge."
            )
        odd = sorted(set(self.edges_assignment) - set(ASSIGNMENTS))
        if odd:
            raise ProgramError(f"The letter {odd[0]!r} is unknown; use B, M, V, F or U.")
        loop = next((i for i, (u, v) in enumerate(self.edges_vertices) if u == v), None)
        if loop is not None:
            raise ProgramError(
                f"Edge {loop} joins vertex {self.edges_vertices[loop][0]} with itself; leave it out."
            )
        for cycle in (*self.edges_vertices, *self.faces_vertices):
            for v in cycle:
                if not 0 <= v < len(self.vertices_coords):
                    raise ProgramError(
                        f"{list(cycle)} refers to vertex {v}, but there are vertices 0 to {len(self.vertices_coords) - 1} only."
                    )

    @cached_property
    def cycles(self) -> tuple[Cycle, ...]:
        """The faces, each counter-clockwise: as given, else found from the edges."""
        if self.faces_vertices:
            return boundary_cycles(self.vertices_coords, self.edges_vertices, self.faces_vertices)
        return faces_of_sheet(self.vertices_coords, self.edges_vertices, self.edges_assignment)

    @cached_property
    def creases(self) -> tuple[PatternCrease, ...]:
        """The edges that join two faces; a boundary edge between two is a cut and joins nothing."""
        beside = edge_faces(dict(enumerate(self.cycles)))
        left_of = {side: face for face, cycle in enumerate(self.cycles) for side in sides(cycle)}
        found = []
        for (u, v), assignment in zip(self.edges_vertices, self.edges_assignment, strict=True):
            joins = len(set(beside.get(edge_of(u, v), ()))) == 2 and assignment != "B"
            if joins and (u, v) in left_of and (v, u) in left_of:
                found.append(PatternCrease((u, v), assignment, left_of[u, v], left_of[v, u]))
        return tuple(found)

    def place(self, vertex: int) -> FilePlace:
        """Where the file has a vertex."""
        return self.place_of(self.vertices_coords[vertex])

    def place_of(self, point: Point) -> FilePlace:
        """Where the file has a point of the sheet."""
        return self.axes.place(point) if self.axes else tuple(point)

    def name(self, vertex: int) -> int:
        """What a vertex is called in messages."""
        return self.names[vertex] if self.names else vertex


def faces_of_sheet(
    vertices: Sequence[Point], edges: Sequence[Edge], assignments: Sequence[str]
) -> tuple[Cycle, ...]:
    """The faces that edges enclose, counter-clockwise, without holes: a hole has an edge of the sheet on every side and paper
    beyond each.
    """
    cycles = boundary_cycles(vertices, edges, ())
    beside = edge_faces(dict(enumerate(cycles)))
    border = {edge_of(*edge) for edge, letter in zip(edges, assignments, strict=True) if letter == "B"}
    return tuple(
        cycle
        for cycle in cycles
        if not all(edge_of(*side) in border and len(beside[edge_of(*side)]) == 2 for side in sides(cycle))
    )


def pattern_of(paper: Paper) -> CreasePattern:
    """The crease pattern of a paper; faces in ascending order of id, vertices called by theirs."""
    ids = sorted(paper.vertices_coords)
    index = {v: i for i, v in enumerate(ids)}
    edges = list(paper.edges())
    return CreasePattern(
        vertices_coords=tuple(paper.vertices_coords[v] for v in ids),
        edges_vertices=tuple((index[u], index[v]) for (u, v), _ in edges),
        edges_assignment=tuple(ASSIGNMENTS[assignment] for _, assignment in edges),
        faces_vertices=tuple(tuple(index[v] for v in paper.faces[f]) for f in sorted(paper.faces)),
        names=tuple(ids),
    )
