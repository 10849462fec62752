"""Predicting a fold without making it: which faces would move, and what the stack would look like.

A search tries thousands of lines; this follows the same rule as the simulator's ``fold`` but cuts nothing and numbers
nothing. The plan that wins is made of real actions and checked against the simulator.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from folding_server.simulator.paper import Paper
from folding_server.simulator.plane_geometry import Line, Point, clip, mirror, overlap
from folding_server.vision.solver.scene import Stack

NEAR = 0.006
"""A corner this near a line counts as on it while searching, as a line is found no more exactly than that."""


@dataclass(frozen=True)
class MovingSet:
    """The faces that a fold along ``line`` turns, at least in part, when it starts at ``seed``."""

    line: Line
    seed: int
    faces: frozenset[int]


class Leaves:
    """A paper prepared for trying many folds: outlines, neighbours and overlaps worked out once."""

    def __init__(self, paper: Paper) -> None:
        self.paper = paper
        self.outlines: dict[int, list[Point]] = {f: paper.polygon(f) for f in paper.order}
        self.backs = {f: paper.back_up(f) for f in paper.order}
        self.joined: dict[int, list[tuple[int, Point, Point]]] = {f: [] for f in paper.order}
        for (u, v), beside in paper.edge_faces.items():
            if len(beside) == 2:
                for face, other in (beside, beside[::-1]):
                    self.joined[face].append((other, paper.positions[u], paper.positions[v]))
        self.above: dict[int, list[int]] = {f: [] for f in paper.order}
        for i, low in enumerate(paper.order):
            for high in paper.order[i + 1 :]:
                if overlap(self.outlines[low], self.outlines[high]):
                    self.above[low].append(high)

    def moving_sets(self, line: Line) -> Iterator[MovingSet]:
        """The different sets of layers that a fold along a line can turn, topmost seed first; never all faces."""
        reach = {f: _extent(self.outlines[f], line) for f in self.paper.order}
        seen: set[frozenset[int]] = set()
        for seed in reversed(self.paper.order):
            low, high = reach[seed]
            if high <= NEAR or low > NEAR:
                continue
            faces = self._closure(seed, line, reach)
            if faces in seen:
                continue
            seen.add(faces)
            if len(faces) < len(self.paper.faces) or any(reach[f][0] < -NEAR for f in faces):
                yield MovingSet(line, seed, faces)

    def moving_from(self, line: Line, seed: int) -> MovingSet | None:
        """The set turned by a fold along a line from one seed; None if the seed has nothing on the moving side."""
        reach = {f: _extent(self.outlines[f], line) for f in self.paper.order}
        if reach[seed][1] <= NEAR:
            return None
        return MovingSet(line, seed, self._closure(seed, line, reach))

    def folded(self, moving: MovingSet) -> Stack:
        """What the stack looks like after a fold."""
        line = moving.line
        away = Line(-line.nx, -line.ny, -line.offset)
        reflection = mirror(line)
        outlines: list[list[Point]] = []
        backs: list[bool] = []
        for face in self.paper.order:
            stays = clip(self.outlines[face], away) if face in moving.faces else self.outlines[face]
            if len(stays) > 2:
                outlines.append(stays)
                backs.append(self.backs[face])
        for face in reversed(self.paper.order):
            if face in moving.faces:
                turned = [reflection(p) for p in clip(self.outlines[face], line)]
                if len(turned) > 2:
                    outlines.append(turned)
                    backs.append(not self.backs[face])
        return Stack(outlines, backs)

    def _closure(self, seed: int, line: Line, reach: dict[int, tuple[float, float]]) -> frozenset[int]:
        """Everything that moves with a seed: joined off the line, or lying over a moving part."""
        found, waiting = {seed}, [seed]
        while waiting:
            face = waiting.pop()
            for other, p, q in self.joined[face]:
                if other not in found and max(line.distance(p), line.distance(q)) > NEAR:
                    found.add(other)
                    waiting.append(other)
            for other in self.above[face]:
                if other not in found and reach[other][1] > NEAR and self._meet(face, other, line, reach):
                    found.add(other)
                    waiting.append(other)
        return frozenset(found)

    def _meet(self, face: int, other: int, line: Line, reach: dict[int, tuple[float, float]]) -> bool:
        """Whether the moving parts of two faces that overlap do so too."""
        if reach[face][0] >= -NEAR and reach[other][0] >= -NEAR:
            return True
        return overlap(clip(self.outlines[face], line), clip(self.outlines[other], line))


def _extent(outline: list[Point], line: Line) -> tuple[float, float]:
    """The least and greatest signed distance of an outline's corners from a line."""
    distances = [line.nx * x + line.ny * y - line.offset for x, y in outline]
    return min(distances), max(distances)
