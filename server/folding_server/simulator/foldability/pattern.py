"""A crease pattern as a record: what foldability is asked of."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

from folding_server.errors import ProgramError
from folding_server.geometry.graph import Cycle, Edge
from folding_server.geometry.line import Point
from folding_server.geometry.planar import boundary_cycles
from folding_server.simulator.paper import Paper

Assignment = Literal["B", "M", "V", "F", "U"]
"""Boundary, mountain, valley, flat (a mark), or a crease whose direction is not given."""

ASSIGNMENTS: Mapping[str, Assignment] = {assignment: assignment for assignment in get_args(Assignment)}
"""Every assignment of a pattern by itself, to check and narrow plain strings with."""


@dataclass(frozen=True)
class CreasePattern:
    """A planar straight-line graph on the unfolded sheet, in FOLD's words.

    ``vertices_coords``    (x, y) of each vertex, in any unit
    ``edges_vertices``     pairs of indices of vertices
    ``edges_assignment``   one for each edge
    ``faces_vertices``     boundary cycles of indices of vertices; empty if they are to be found from the edges
    ``names``              what each vertex is called in messages; its index if empty
    """

    vertices_coords: tuple[Point, ...]
    edges_vertices: tuple[Edge, ...]
    edges_assignment: tuple[Assignment, ...]
    faces_vertices: tuple[Cycle, ...] = ()
    names: tuple[int, ...] = ()

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
        return boundary_cycles(self.vertices_coords, self.edges_vertices, self.faces_vertices)

    def name(self, vertex: int) -> int:
        """What a vertex is called in messages."""
        return self.names[vertex] if self.names else vertex


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
