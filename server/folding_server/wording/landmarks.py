"""What of a folded sheet people can name: its corners, edges, creases and middles, as seen from above.

A name is a key such as ``corner.top``, ``edge.top-left``, ``crease.vertical``, ``centre``, ``end-left.edge.top`` or
``middle.edge.top``; the words of a key are in the message files. The same paper always has the same names, so that words can be read back.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import atan2, dist, hypot, pi

from folding_server.geometry.line import Line, Point, between, line_through
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator import Paper

MEETING = 5 * TOLERANCE
"""Points this near each other are one to the eye, and lines this near one line: matching layers differ by about as much."""
CORNER_LEAD = 20 * TOLERANCE
"""A corner is the topmost if it is higher than all others by so much."""
COMPASS = ("right", "top-right", "top", "top-left", "left", "bottom-left", "bottom", "bottom-right")
"""Directions on the table, each an eighth of a turn further."""
SLANTS = {"horizontal": 0.0, "rising": 0.25, "vertical": 0.5, "falling": 0.75}
"""Slants of creases, in parts of half a turn."""


@dataclass(frozen=True)
class NamedLine:
    """An edge or a crease: its line, and how far it reaches on the table."""

    kind: str
    line: Line
    start: Point
    end: Point

    @property
    def middle(self) -> Point:
        """The middle of it."""
        return between(self.start, self.end, 0.5)

    def ends(self) -> tuple[Point, Point]:
        """Its left end and its right end; of an upright one the lower and the upper end."""
        first, last = sorted((self.start, self.end), key=lambda p: p[1] if self.upright else p[0])
        return first, last

    @property
    def upright(self) -> bool:
        """Whether no end of it is further left than the other."""
        return abs(self.start[0] - self.end[0]) <= MEETING

    def end_names(self) -> tuple[str, str]:
        """What its ends are called, in the order of ``ends``."""
        return ("lower", "upper") if self.upright else ("left", "right")

    def reaches(self, point: Point) -> bool:
        """Whether a point lies on it."""
        length = dist(self.start, self.end)
        near = abs(self.line.distance(point)) <= MEETING
        return near and dist(self.start, point) + dist(point, self.end) <= length + 2 * MEETING


class Landmarks:
    """The points and lines of a paper that have names, and the spots where its vertices lie."""

    def __init__(self, paper: Paper) -> None:
        self.paper = paper
        self.spots = _spots(paper)

    @cached_property
    def box(self) -> tuple[Point, Point]:
        """The lower left and the upper right corner of the box around the paper."""
        xs, ys = zip(*self.spots, strict=True)
        return (min(xs), min(ys)), (max(xs), max(ys))

    @property
    def middle(self) -> float:
        """How far to the right the middle of the box lies."""
        return (self.box[0][0] + self.box[1][0]) / 2

    @cached_property
    def straight(self) -> list[NamedLine]:
        """All edges and creases, those along one line as one, the longest first."""
        found = _straight_lines(self.paper)
        return sorted(found, key=lambda each: (-round(dist(each.start, each.end), 4), each.start))

    @cached_property
    def lines(self) -> Mapping[str, NamedLine]:
        """Those that have a name, by it."""
        named = self._outer_edges()
        for key, line in self._creases().items():
            named.setdefault(key, line)
        return named

    @cached_property
    def points(self) -> Mapping[str, Point]:
        """The points that have a name, by it."""
        named = _corners(self.spots)
        low, high = self.box
        centre = between(low, high, 0.5)
        met = [spot for spot in self.spots if dist(spot, centre) <= MEETING]
        if met:
            named["centre"] = met[0]
        edges = {key: line for key, line in self.lines.items() if key.startswith("edge.")}
        for key, line in edges.items():
            for end, at in zip(line.end_names(), line.ends(), strict=True):
                if not any(dist(at, known) <= MEETING for known in named.values()):
                    named[f"end-{end}.{key}"] = at
        for key, line in edges.items():
            if not any(dist(line.middle, at) <= MEETING for at in named.values()):
                named[f"middle.{key}"] = line.middle
        return named

    def name_at(self, point: Point) -> str | None:
        """The name of the point there, None if it has none."""
        near = [(dist(at, point), key) for key, at in self.points.items() if dist(at, point) <= MEETING]
        return min(near)[1] if near else None

    def _outer_edges(self) -> dict[str, NamedLine]:
        """Edges with all of the paper on one side, named by the side that they close."""
        found: dict[str, list[NamedLine]] = {}
        for line in self.straight:
            across = [line.line.distance(spot) for spot in self.spots]
            if line.kind == "edge" and (min(across) >= -MEETING or max(across) <= MEETING):
                sign = -1 if min(across) >= -MEETING else 1
                found.setdefault(compass_of(sign * line.line.nx, sign * line.line.ny), []).append(line)
        return {f"edge.{side}": lines[0] for side, lines in found.items() if len(lines) == 1}

    def _creases(self) -> dict[str, NamedLine]:
        """Creases named by their slant: the only one of it, or the one through the middle of the paper."""
        low, high = self.box
        centre = between(low, high, 0.5)
        named: dict[str, NamedLine] = {}
        for slant, part in SLANTS.items():
            alike = [line for line in self.straight if line.kind == "crease" and _slants(line, part)]
            central = [line for line in alike if abs(line.line.distance(centre)) <= MEETING]
            if central:
                named[f"crease.centre-{slant}"] = central[0]
            elif len(alike) == 1:
                named[f"crease.{slant}"] = alike[0]
        return named


def compass_of(x: float, y: float) -> str:
    """The nearest of eight directions."""
    return COMPASS[round(atan2(y, x) / (pi / 4)) % 8]


def toward(side: str) -> Point:
    """A vector in one of the eight directions."""
    signs = {"left": (-1, 0), "right": (1, 0), "top": (0, 1), "bottom": (0, -1)}
    parts = [signs[part] for part in side.split("-")]
    return sum(x for x, _ in parts), sum(y for _, y in parts)


def _spots(paper: Paper) -> list[Point]:
    """Where vertices lie on the table, those that coincide once."""
    spots: list[Point] = []
    for _, at in sorted(paper.folded_vertices_coords.items()):
        if not any(dist(at, spot) <= MEETING for spot in spots):
            spots.append(at)
    return spots


def _corners(spots: Sequence[Point]) -> dict[str, Point]:
    """The spots that stand out in one of the eight directions, those of straight directions first."""
    named: dict[str, Point] = {}
    for side in (*COMPASS[::2], *COMPASS[1::2]):
        x, y = toward(side)
        ahead = sorted(spots, key=lambda spot: -(x * spot[0] + y * spot[1]))
        first = ahead[0]
        lead = [x * spot[0] + y * spot[1] for spot in ahead[:2]]
        if (len(lead) < 2 or lead[0] - lead[1] > CORNER_LEAD) and first not in named.values():
            named[f"corner.{side}"] = first
    return named


def _straight_lines(paper: Paper) -> list[NamedLine]:
    groups: list[tuple[str, Line, list[Point]]] = []
    coords = paper.folded_vertices_coords
    for edge, assignment in paper.edges():
        p, q = coords[edge[0]], coords[edge[1]]
        if dist(p, q) <= MEETING:
            continue
        kind = "crease" if assignment == "F" else "edge"
        for known, line, ends in groups:
            if known == kind and abs(line.distance(p)) <= MEETING and abs(line.distance(q)) <= MEETING:
                ends += [p, q]
                break
        else:
            groups.append((kind, line_through(p, q), [p, q]))
    return [_reaching(kind, line, ends) for kind, line, ends in groups]


def _reaching(kind: str, line: Line, ends: Sequence[Point]) -> NamedLine:
    """A line between those of its points that are furthest apart."""
    along = sorted(ends, key=lambda p: -line.ny * p[0] + line.nx * p[1])
    first, last = along[0], along[-1]
    return NamedLine(kind, line_through(first, last), first, last)


def _slants(line: NamedLine, part: float) -> bool:
    """Whether a line has a slant, to about a tenth of a degree."""
    angle = atan2(line.end[1] - line.start[1], line.end[0] - line.start[0]) / pi % 1.0
    off = abs(angle - part)
    return min(off, 1 - off) < 6e-4


def spot_in_box(box: tuple[Point, Point], point: Point) -> Point:
    """A point as parts of the width and of the height of a box; 0 where it has none."""
    (left, low), (right, high) = box
    width, height = right - left, high - low
    return (
        (point[0] - left) / width if width > MEETING else 0.0,
        (point[1] - low) / height if height > MEETING else 0.0,
    )


def length_of(vector: Point) -> float:
    """The length of a vector."""
    return hypot(*vector)
