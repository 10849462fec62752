"""Growing the moving set of a fold and cutting the faces that straddle its line."""

from collections.abc import Iterable, Iterator
from itertools import count

from folding_server.errors import ActionRefused
from folding_server.geometry.convex import Box, bounding_box, boxes_meet, clip, overlap
from folding_server.geometry.graph import Edge, edge_of, sides
from folding_server.geometry.line import Line, Point, between
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator.paper import FoldedCrease, Paper
from folding_server.simulator.vertices import insert_vertex


class FoldBuilder:
    """A working copy of a paper while one fold decides what moves.

    ``side`` gives each vertex +1 on the moving side of the line, -1 on the other, 0 on the line to the tolerance.
    ``moving`` holds the faces that will turn over, after cuts; ``origin`` the face that a cut-off part came from.
    """

    def __init__(self, paper: Paper, line: Line) -> None:
        self.paper, self.line = paper, line
        self.vertices_coords = dict(paper.vertices_coords)
        self.faces = dict(paper.faces)
        self.isometries = dict(paper.isometries)
        self.beside = dict(paper.edge_faces)
        self.creases: dict[Edge, FoldedCrease] = dict(paper.creases)
        self.distance = {v: line.distance(p) for v, p in paper.folded_vertices_coords.items()}
        self.side = {v: _sign(d) for v, d in self.distance.items()}
        self._new_ids = count(max(paper.vertices_coords) + 1)
        self._new_faces = count(max(paper.faces) + 1)
        self.moving: set[int] = set()
        self.part_of: dict[int, int] = {}
        self._moving_parts: dict[int, tuple[list[Point], Box]] = {}

    def reaches(self, face: int) -> bool:
        """Whether a face has area on the moving side."""
        return any(self.side[v] > 0 for v in self.faces[face])

    def touches(self, face: int) -> bool:
        """Whether a face has a vertex on the line or beyond it."""
        return any(self.side[v] <= 0 for v in self.faces[face])

    def straddles(self, face: int) -> bool:
        """Whether a face has area on both sides."""
        return self.reaches(face) and any(self.side[v] < 0 for v in self.faces[face])

    def move_with(self, seeds: Iterable[int]) -> None:
        """Close the moving set: joined off the line, or lying over a moving part. Last in, first out."""
        waiting = list(seeds)
        done: set[int] = set()
        free = {face for face in self.paper.order if self.reaches(face)}.difference(waiting)
        while waiting:
            face = waiting.pop()
            if face in done:
                continue
            done.add(face)
            part = self._cut(face) if self.straddles(face) else face
            self.moving.add(part)
            found = self._lying_over(face, free)
            found += [other for other in self._joined(part) if other not in self.moving and other not in done]
            free.difference_update(found)
            waiting += found

    def stacks(self, order: Iterable[int]) -> tuple[list[int], list[int]]:
        """The faces that stay and those that turn, each from bottom to top."""
        stays: list[int] = []
        turns: list[int] = []
        for face in order:
            (turns if face in self.moving else stays).append(face)
            if face in self.part_of:
                turns.append(self.part_of[face])
        return stays, turns

    def _joined(self, part: int) -> Iterator[int]:
        """Faces joined to a moving part by an edge off the line, along its boundary."""
        for u, v in sides(self.faces[part]):
            if self.side[u] > 0 or self.side[v] > 0:
                yield from (f for f in self.beside[edge_of(u, v)] if f != part)

    def _lying_over(self, face: int, free: set[int]) -> list[int]:
        """Faces not yet waiting that lie over the moving part of a face, by id."""
        rank = self.paper.rank
        here = rank[face]
        outline, box = self._moving_part(face)
        above = sorted(g for g in free if rank[g] > here)
        return [g for g in above if self._meets(g, outline, box)]

    def _meets(self, face: int, outline: list[Point], box: Box) -> bool:
        other, its_box = self._moving_part(face)
        return boxes_meet(box, its_box) and overlap(outline, other)

    def _moving_part(self, face: int) -> tuple[list[Point], Box]:
        """The folded outline of what a face of the paper has on the moving side, and its bounding box."""
        if face not in self._moving_parts:
            outline = clip(self.paper.polygon(face), self.line)
            self._moving_parts[face] = outline, bounding_box(outline)
        return self._moving_parts[face]

    def _cut(self, face: int) -> int:
        """Cut a straddling face along the line; the part that stays keeps the id, the other takes the highest + 1."""
        first, second = self._ends_of_cut(face)
        cycle = self.faces[face]
        i, j = sorted((cycle.index(first), cycle.index(second)))
        parts = cycle[i : j + 1], cycle[j:] + cycle[: i + 1]
        moves = 0 if any(self.side[v] > 0 for v in parts[0]) else 1
        new = next(self._new_faces)
        self.faces[face], self.faces[new] = parts[1 - moves], parts[moves]
        self.isometries[new] = self.isometries[face]
        self.part_of[face] = new
        for u, v in sides(parts[moves]):
            self._hand_over(edge_of(u, v), face, new)
        self.beside[edge_of(first, second)] = (face, new)
        return new

    def _hand_over(self, edge: Edge, face: int, new: int) -> None:
        """Let an edge border the new part instead of the face it was cut from."""
        if edge in self.beside:
            self.beside[edge] = tuple(new if f == face else f for f in self.beside[edge])
        if edge in self.creases:
            self.creases[edge] = _moved_by(self.creases[edge], face, new)

    def _ends_of_cut(self, face: int) -> tuple[int, int]:
        """The two vertices between which a face is cut, made where needed, walking the boundary from its start."""
        cycle = self.faces[face]
        off = [i for i, v in enumerate(cycle) if self.side[v]]
        changes = [
            (i, j)
            for i, j in zip(off, off[1:] + off[:1], strict=True)
            if self.side[cycle[i]] != self.side[cycle[j]]
        ]
        if len(changes) != 2:
            raise ActionRefused(
                f"The line grazes face {face} within {TOLERANCE:g} in {len(changes)} places, too thin to crease; "
                "fold along a line that is clear of that face's edges."
            )
        first, second = (self._crossing(cycle, i, j) for i, j in changes)
        return first, second

    def _crossing(self, cycle: tuple[int, ...], i: int, j: int) -> int:
        """The vertex on the line between the i-th of a cycle and the j-th, which lie on different sides."""
        between_them = [cycle[k % len(cycle)] for k in range(i + 1, j if j > i else j + len(cycle))]
        if between_them:
            return min(between_them, key=lambda v: abs(self.distance[v]))
        return self._new_vertex(cycle[i], cycle[j])

    def _new_vertex(self, u: int, v: int) -> int:
        """A vertex where the line crosses an edge, put into the faces beside it."""
        new = next(self._new_ids)
        fraction = self.distance[u] / (self.distance[u] - self.distance[v])
        self.vertices_coords[new] = between(self.vertices_coords[u], self.vertices_coords[v], fraction)
        self.distance[new], self.side[new] = 0.0, 0
        edge, halves = edge_of(u, v), (edge_of(u, new), edge_of(new, v))
        beside, record = self.beside.pop(edge), self.creases.pop(edge, None)
        for face in beside:
            self.faces[face] = insert_vertex(self.faces[face], u, v, new)
        for half in halves:
            self.beside[half] = beside
            if record is not None:
                self.creases[half] = record
        return new


def _sign(distance: float) -> int:
    return 0 if abs(distance) <= TOLERANCE else 1 if distance > 0 else -1


def _moved_by(record: FoldedCrease, face: int, new: int) -> FoldedCrease:
    """A crease record in which a new part stands for the face it was cut from, all the way down."""
    below = record.below and _moved_by(record.below, face, new)
    return FoldedCrease(record.fold, new if record.moved == face else record.moved, below)
