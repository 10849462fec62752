"""The folded sheet as one immutable record, and the questions that can be asked of it.

The crease pattern is kept at all times (``vertices_coords`` and ``faces``); each face carries the isometry that takes it from
the sheet to where it lies now, so its shape never changes. The stack is one total order of the faces, bottom to top.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from folding_server.geometry.graph import Edge, edge_faces
from folding_server.geometry.isometry import IDENTITY, Isometry
from folding_server.geometry.line import Point


class FoldedCrease(NamedTuple):
    """Who last turned an inner edge: the fold's number, the face beside the edge that moved, and what it covered.

    ``below`` is the record that returns when this fold is undone by an unfold.
    """

    fold: int
    moved: int
    below: "FoldedCrease | None"


@dataclass(frozen=True)
class Paper:
    """A flat-folded sheet of ``sheet`` = (width, height).

    ``vertices_coords``  vertex id -> its coordinates in the crease pattern, on the unfolded sheet
    ``faces``        face id -> its convex boundary as a cycle of vertex ids
    ``isometries``   face id -> motion from the crease pattern to the folded form; a mirror if the back is up
    ``order``        all faces, bottom to top
    ``creases``      inner edge -> record of the folds that turned it; absent for a mark that nothing holds folded
    ``folds``        number of folds so far; the newest has this number
    ``fold_edges``   fold number -> the two vertices it was made through, for messages and for ``unfold``
    """

    sheet: tuple[float, float]
    vertices_coords: Mapping[int, Point]
    faces: Mapping[int, tuple[int, ...]]
    isometries: Mapping[int, Isometry]
    order: tuple[int, ...]
    creases: Mapping[Edge, FoldedCrease]
    folds: int
    fold_edges: Mapping[int, tuple[int, int]]

    @cached_property
    def edge_faces(self) -> Mapping[Edge, tuple[int, ...]]:
        """Edge -> the one or two faces beside it."""
        return edge_faces(self.faces)

    @cached_property
    def vertex_face(self) -> Mapping[int, int]:
        """Vertex -> the face it is read off: the first that has it."""
        owner: dict[int, int] = {}
        for face, cycle in self.faces.items():
            for v in cycle:
                owner.setdefault(v, face)
        return owner

    @cached_property
    def folded_vertices_coords(self) -> Mapping[int, Point]:
        """Vertex -> its coordinates in the folded form."""
        return {v: self.isometries[f](self.vertices_coords[v]) for v, f in self.vertex_face.items()}

    @cached_property
    def rank(self) -> Mapping[int, int]:
        """Face -> its index in the stack, 0 at the bottom."""
        return {face: i for i, face in enumerate(self.order)}

    def polygon(self, face: int) -> list[Point]:
        """The folded outline of a face, in the order of its cycle."""
        isometry, coords = self.isometries[face], self.vertices_coords
        return [isometry(coords[v]) for v in self.faces[face]]

    def sheet_polygon(self, face: int) -> list[Point]:
        """The outline of a face on the unfolded sheet."""
        return [self.vertices_coords[v] for v in self.faces[face]]

    def back_up(self, face: int) -> bool:
        """Whether the back of the sheet is up at a face."""
        return self.isometries[face].mirrors

    def is_folded(self, edge: Edge) -> bool:
        """Whether an inner edge is folded now (its two faces show different sides)."""
        beside = self.edge_faces[edge]
        return len(beside) == 2 and self.back_up(beside[0]) != self.back_up(beside[1])

    def edge_assignment(self, edge: Edge) -> str:
        """B, F, M or V of an edge, relative to the front of the sheet, so that a flip never changes it."""
        beside = self.edge_faces[edge]
        if len(beside) == 1:
            return "B"
        if not self.is_folded(edge):
            return "F"
        lower = min(beside, key=self.rank.__getitem__)
        return "M" if self.back_up(lower) else "V"

    def edges(self) -> Iterator[tuple[Edge, str]]:
        """All edges with their assignments, in a fixed order."""
        return ((edge, self.edge_assignment(edge)) for edge in sorted(self.edge_faces))


def new_paper(sheet: tuple[float, float] = (1.0, 1.0)) -> Paper:
    """A flat sheet, front up: vertices 1 to 4 from the upper left corner clockwise, one face.

    Width and height in sheet units; the square (1, 1) is the default.
    """
    width, height = sheet
    vertices_coords = {1: (0.0, height), 2: (width, height), 3: (width, 0.0), 4: (0.0, 0.0)}
    return Paper(sheet, vertices_coords, {1: (1, 2, 3, 4)}, {1: IDENTITY}, (1,), {}, 0, {})
