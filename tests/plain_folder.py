"""A second folder of paper, which shares no code with the simulator, to know what a program leads to.

It is written from the rules of folding alone: faces are convex polygons of points of the sheet, their places complex
numbers, and a stack is a list. It knows what the programs in ``data/results`` need: folds, and unfolding the fold that
was made last while no other came after it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import shapely

NEAR = 1e-4
"""Parts of the sheet's side below which two points are one, and a strip is no part of a face: the programs' tolerance."""
AXES = {"x": (-1, 1), "y": (1, 1j), "y=x": (1j, 0), "y=-x": (-1j, 0)}
"""A flip takes z to ``a * conjugate(z) + b``."""


@dataclass(frozen=True)
class Motion:
    """``z -> a z + b``, or ``a conjugate(z) + b`` if it turns the paper over."""

    a: complex = 1
    b: complex = 0
    over: bool = False

    def __call__(self, z: complex) -> complex:
        return self.a * (z.conjugate() if self.over else z) + self.b

    def after(self, first: "Motion") -> "Motion":
        """This motion, done after another."""
        a, b = (first.a.conjugate(), first.b.conjugate()) if self.over else (first.a, first.b)
        return Motion(self.a * a, self.a * b + self.b, self.over != first.over)


@dataclass(frozen=True)
class Face:
    """The ids of the points around a face, and where it lies."""

    points: tuple[int, ...]
    motion: Motion

    def sides(self) -> Iterator[frozenset[int]]:
        """Its edges, as pairs of points."""
        return map(frozenset, zip(self.points, self.points[1:] + self.points[:1], strict=True))


@dataclass
class Sheet:
    """A folded sheet: the places of its points when flat, its faces from the bottom up, and the last fold."""

    points: dict[int, complex] = field(default_factory=lambda: {1: 1j, 2: 1 + 1j, 3: 1 + 0j, 4: 0j})
    faces: list[Face] = field(default_factory=lambda: [Face((1, 2, 3, 4), Motion())])
    opened: list[Face] | None = None
    """The faces, already cut, as they lay before the last fold."""

    def place(self, point: int) -> complex:
        """Where a point lies now."""
        return next(face for face in self.faces if point in face.points).motion(self.points[point])

    def act(self, action: dict[str, Any]) -> None:
        """Carry out an action of a program."""
        getattr(self, action["action"])(**{key: value for key, value in action.items() if key != "action"})

    def rotate(self, angle: float) -> None:
        """Turn clockwise by degrees, about the mean of all points."""
        middle = sum(map(self.place, self.points)) / len(self.points)
        turn = 1j ** (-angle / 90)
        self._move_all(Motion(turn, middle - turn * middle))

    def flip(self, axis: str) -> None:
        """Turn the whole stack over."""
        a, b = AXES[axis]
        self._move_all(Motion(a, b, over=True))
        self.faces.reverse()
        self.opened = None

    def add_vertex(self, edge: Sequence[int], position: float) -> None:
        """A new point on an edge."""
        u, v = edge
        self._cut_edge(frozenset(edge), self.points[u] + position * (self.points[v] - self.points[u]))

    def unfold(self) -> None:
        """Open the fold that was made last."""
        assert self.opened is not None, "only the fold that was made last is opened here"
        self.faces, self.opened = self.opened, None

    def fold(self, edge: Sequence[int], direction: int) -> None:
        """Fold towards the viewer what the rules let move."""
        p, q = map(self.place, edge)
        across = _across(p, q) * direction
        moving = self._moving(edge, p, across)
        mirror = -(across**2)
        motion = Motion(mirror, p - mirror * p.conjugate(), over=True)
        stay, moved, opened = [], [], []
        for face in self.faces:
            away, beyond = self._halves(face, p, across) if face in moving else (face, None)
            stay += [away] if away else []
            moved += [Face(beyond.points, motion.after(face.motion))] if beyond else []
            opened += [half for half in (away, beyond) if half]
        stay, moved, opened = (list(map(self._with_new_points, faces)) for faces in (stay, moved, opened))
        self.faces, self.opened = stay + moved[::-1], opened

    def _moving(self, edge: Sequence[int], p: complex, across: complex) -> set[Face]:
        """The faces of which a part moves: the seeds, what is joined to them beyond the line, what lies above."""
        parts = {face: self._polygon(face, p, across) for face in self.faces}
        beyond = {face: part for face, part in parts.items() if part is not None}
        moving = set(self._seeds(edge, list(beyond)))
        waiting = list(moving)
        while waiting:
            face = waiting.pop()
            above = self.faces[self.faces.index(face) + 1 :]
            taken = {
                other
                for other in beyond.keys() - moving
                if self._joined_beyond(face, other, p, across)
                or (other in above and overlap(beyond[face], beyond[other]))
            }
            moving |= taken
            waiting += taken
        return moving

    def _seeds(self, edge: Sequence[int], beyond: list[Face]) -> list[Face]:
        """The topmost face with both points and a part beyond the line, or those of the topmost such plane."""
        for face in reversed(beyond):
            if set(edge) <= set(face.points):
                return [face]
        for face in reversed(beyond):
            plane = self._plane(face)
            if set(edge) <= {point for each in plane for point in each.points}:
                return [each for each in plane if each in beyond]
        raise AssertionError("no face has both points of the edge: this folder has no rule for that")

    def _plane(self, face: Face) -> list[Face]:
        """A face with all that are joined to it by edges that are not folded."""
        plane = [face]
        for each in plane:
            plane += [
                other
                for other in self.faces
                if other not in plane
                and other.motion.over == face.motion.over
                and set(each.sides()) & set(other.sides())
            ]
        return plane

    def _joined_beyond(self, face: Face, other: Face, p: complex, across: complex) -> bool:
        shared = set(face.sides()) & set(other.sides())
        return any(max(self._distance(face, v, p, across) for v in side) > NEAR for side in shared)

    def _distance(self, face: Face, point: int, p: complex, across: complex) -> float:
        """How far a point of a face lies beyond the line."""
        away = face.motion(self.points[point]) - p
        return (away * across.conjugate()).real

    def _polygon(self, face: Face, p: complex, across: complex) -> shapely.Polygon | None:
        """Where the part of a face beyond the line lies, if there is one."""
        if max(self._distance(face, v, p, across) for v in face.points) <= NEAR:
            return None
        half = shapely.Polygon(
            [(z.real, z.imag) for z in (p + 1j * across * 9, p - 1j * across * 9)]
            + [(z.real, z.imag) for z in (p + across * (9 - 9j), p + across * (9 + 9j))]
        )
        return self.outline(face).intersection(half)

    def _halves(self, face: Face, p: complex, across: complex) -> tuple[Face | None, Face | None]:
        """A face's parts on this side of the line and beyond, with new points where the line cuts its edges."""
        face = self._with_new_points(face)
        for side in list(face.sides()):
            u, v = side
            at, to = (self._distance(face, point, p, across) for point in (u, v))
            if min(at, to) < -NEAR and max(at, to) > NEAR:
                part = at / (at - to)
                self._cut_edge(side, self.points[u] + part * (self.points[v] - self.points[u]))
        face = self._with_new_points(face)
        far = {v: self._distance(face, v, p, across) for v in face.points}
        here = tuple(v for v in face.points if far[v] <= NEAR)
        there = tuple(v for v in face.points if far[v] >= -NEAR)
        return (
            Face(here, face.motion) if min(far.values()) < -NEAR else None,
            Face(there, face.motion) if max(far.values()) > NEAR else None,
        )

    def _cut_edge(self, side: frozenset[int], at: complex) -> None:
        self.points[max(self.points) + 1] = at
        self.faces = list(map(self._with_new_points, self.faces))
        assert side not in {each for face in self.faces for each in face.sides()}

    def _with_new_points(self, face: Face) -> Face:
        """A face with all points that lie on its edges."""
        around: list[int] = []
        for u, v in zip(face.points, face.points[1:] + face.points[:1], strict=True):
            along = self.points[v] - self.points[u]
            parts = {w: (z - self.points[u]) / along for w, z in self.points.items() if w not in face.points}
            on = [w for w, part in parts.items() if 0 < part.real < 1 and abs(part.imag * along) < 1e-9]
            around += [u, *sorted(on, key=lambda w: parts[w].real)]
        return Face(tuple(around), face.motion)

    def _move_all(self, motion: Motion) -> None:
        self.faces = [Face(face.points, motion.after(face.motion)) for face in self.faces]
        if self.opened is not None:
            self.opened = [Face(face.points, motion.after(face.motion)) for face in self.opened]

    def outline(self, face: Face) -> shapely.Polygon:
        """Where a face lies."""
        return shapely.Polygon(
            [(z.real, z.imag) for z in map(face.motion, map(self.points.get, face.points))]
        )


def _across(p: complex, q: complex) -> complex:
    """The direction across a line, upwards, or to the right if it is vertical; of length 1."""
    along = (q - p) / abs(q - p)
    across = along * 1j
    if abs(along.real) < NEAR:
        return across if across.real > 0 else -across
    return across if across.imag > 0 else -across


def overlap(one: shapely.Polygon, other: shapely.Polygon) -> bool:
    """Whether two polygons share more than a strip as thin as the tolerance."""
    return not one.intersection(other).buffer(-NEAR / 2).is_empty
