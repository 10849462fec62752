"""What a fold aligns on a paper: its sayings by named places and lines, and by points that are marked for it."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, permutations
from math import dist

from folding_server.geometry.isometry import mirror
from folding_server.geometry.line import Line, Point
from folding_server.wording.landmarks import MEETING, Landmarks, NamedLine, spot_in_box
from folding_server.wording.said import InBox, MarkedPoint, OnLine, SaidFold

RIGHT_ANGLE = 1e-3
"""Lines whose unit normals have no larger product stand at right angles."""
LETTERS = "ABCDEFGHIJKLMNOP"
SPOT_DIGITS = 6
"""Decimals with which the place of a spot is said: it is the nearest spot that is meant."""


def by_marks(
    places: Landmarks, line: Line, moving: Sequence[Point], ends: Sequence[Point], digits: Sequence[int]
) -> Iterator[SaidFold]:
    """The sayings of a fold by points that are marked for it: first with a corner that moves, then with its side."""
    far = sorted(moving, key=lambda p: -round(line.distance(p), 4))
    flaps = [p for p in far if places.name_at(p)][:3] + far[:1]
    for count in digits:
        for through in (ends, _outermost(places, line, ends)):
            for flap in flaps:
                keys, marks = named_or_marked([*through, flap], places, count)
                yield SaidFold(1, keys[:2], flap=keys[2], marks=marks)
            keys, marks = named_or_marked(through, places, count)
            yield SaidFold(1, keys, side=side_of(line), marks=marks)


def _outermost(places: Landmarks, line: Line, ends: Sequence[Point]) -> list[Point]:
    """The two spots on a line that are furthest apart, with the ends of the fold."""
    on_line = [*(spot for spot in places.spots if abs(line.distance(spot)) <= MEETING), *ends]
    along = sorted(on_line, key=lambda p: -line.ny * p[0] + line.nx * p[1])
    return [along[0], along[-1]]


@dataclass(frozen=True)
class Alignments:
    """What a line aligns on a paper: named places that are ``brought`` somewhere, furthest first, and those ``met`` by it.

    ``landings`` are places and the named lines that they are brought to; ``across`` the named lines at right angles to it.
    """

    places: Landmarks
    line: Line
    moving: Sequence[Point]

    @cached_property
    def brought(self) -> list[tuple[str, Point]]:
        """Named places on the part that moves, the furthest from the line first."""
        found = [
            (key, at)
            for key, at in self.places.points.items()
            if any(dist(at, p) <= MEETING for p in self.moving)
        ]
        return sorted(found, key=lambda each: -round(self.line.distance(each[1]), 4))

    @cached_property
    def met(self) -> list[tuple[str, Point]]:
        """Named places on the line."""
        return [(key, at) for key, at in self.places.points.items() if abs(self.line.distance(at)) <= MEETING]

    @cached_property
    def landings(self) -> list[tuple[str, str]]:
        """Named places, each with a named line that it is brought to."""
        reflect, lines = mirror(self.line), self.places.lines.items()
        return [
            (key, other) for key, at in self.brought for other, each in lines if each.reaches(reflect(at))
        ]

    @cached_property
    def across(self) -> list[str]:
        """Named lines at right angles to it."""
        return [key for key, each in self.places.lines.items() if _square_to(each.line, self.line)]

    def along(self, axiom: int, places: tuple[str, ...], lines: tuple[str, ...] = ()) -> SaidFold:
        """A fold along a line that brings nothing anywhere: with a place that moves, or else the side."""
        if self.brought:
            return SaidFold(axiom, places, lines, flap=self.brought[0][0])
        return SaidFold(axiom, places, lines, side=side_of(self.line))


def by_names(places: Landmarks, line: Line, moving: Sequence[Point]) -> Iterator[SaidFold]:
    """The sayings of a fold by named places and lines, the plainest first; without layers."""
    found = Alignments(places, line, moving)
    yield from _to_landmarks(found)
    yield from _through_landmarks(found)
    yield from _spot_to_spot(places, line, moving)
    for key, other in found.landings:
        yield from (SaidFold(7, (key,), (other, square)) for square in found.across if square != other)
    for (first, to), (second, other) in combinations(found.landings, 2):
        if first != second:
            yield SaidFold(6, (first, second), (to, other))


def _to_landmarks(found: Alignments) -> Iterator[SaidFold]:
    """Axioms 2, 3 and 5."""
    reflect, lines = mirror(found.line), found.places.lines
    for key, at in found.brought:
        target = found.places.name_at(reflect(at))
        if target:
            yield SaidFold(2, (key, target))
    for first, second in permutations(lines, 2):
        if _is_brought(lines[first], lines[second], found.line):
            yield SaidFold(3, lines=(first, second))
    for key, other in found.landings:
        yield from (SaidFold(5, (key, through), (other,)) for through, _ in found.met)


def _through_landmarks(found: Alignments) -> Iterator[SaidFold]:
    """Axioms 1 and 4."""
    for (first, p), (last, q) in combinations(found.met, 2):
        if dist(p, q) > 10 * MEETING:
            yield found.along(1, (first, last))
    for key in found.across:
        yield from (found.along(4, (through,), (key,)) for through, _ in found.met)


def _spot_to_spot(places: Landmarks, line: Line, moving: Sequence[Point]) -> Iterator[SaidFold]:
    """Axiom 2 for points that have no name but can be seen: the furthest of the part that moves, to where another lies."""
    far = sorted((p for p in moving if line.distance(p) > MEETING), key=lambda p: -round(line.distance(p), 4))
    for start in far[:4]:
        end = mirror(line)(start)
        if any(dist(spot, end) <= MEETING for spot in places.spots):
            keys, marks = named_or_marked([start, end], places, SPOT_DIGITS)
            yield SaidFold(2, keys, marks=marks)


def _is_brought(first: NamedLine, second: NamedLine, line: Line) -> bool:
    """Whether a fold brings the whole of one line to another."""
    reflect = mirror(line)
    apart = line.distance(first.start), line.distance(first.end)
    if min(apart) < -MEETING or max(apart) <= MEETING:
        return False
    return all(abs(second.line.distance(reflect(p))) <= MEETING for p in (first.start, first.end))


def _square_to(first: Line, second: Line) -> bool:
    return abs(first.nx * second.nx + first.ny * second.ny) <= RIGHT_ANGLE


def named_or_marked(
    points: Iterable[Point], places: Landmarks, digits: int
) -> tuple[tuple[str, ...], tuple[MarkedPoint, ...]]:
    """The keys of points, and the marks of those that have no name."""
    keys: list[str] = []
    marks: list[MarkedPoint] = []
    for point in points:
        key = places.name_at(point)
        if key is None:
            marks.append(_mark(LETTERS[len(marks)], point, places, digits))
            key = f"letter.{marks[-1].letter}"
        keys.append(key)
    return tuple(keys), tuple(marks)


def _mark(letter: str, point: Point, places: Landmarks, digits: int) -> MarkedPoint:
    """A point by the part of the way along a named line, else by where it is in the box around the model."""
    for key, line in sorted(places.lines.items(), key=lambda item: not item[0].startswith("edge")):
        if line.reaches(point):
            first, last = line.ends()
            part = min(1.0, round(dist(first, point) / dist(first, last), digits))
            return OnLine(letter, key, part, line.upright)
    return InBox(letter, *rounded(spot_in_box(places.box, point), digits))


def rounded(point: Point, digits: int) -> Point:
    """A point with so many decimals."""
    return round(point[0], digits), round(point[1], digits)


def side_of(line: Line) -> str:
    """The side to which the normal of a line points: top, bottom, left or right."""
    if abs(line.nx) > abs(line.ny):
        return "right" if line.nx > 0 else "left"
    return "top" if line.ny > 0 else "bottom"
