"""The symbols of the Yoshizawa-Randlett convention (S. Randlett, The Art of Origami, 1961), in points.

A valley fold is dashed, a mountain fold dash-dot-dot, what is hidden dotted. The arrow of a valley fold has a solid head, that
of a mountain fold half a hollow one; unfolding is a whole hollow one, folding and unfolding has a head at each end.
"""

from collections.abc import Iterable, Sequence
from math import atan2, cos, hypot, pi, sin, tan

from folding_server.geometry.line import Point, between
from folding_server.instructions.marks import Drawn, DrawnPath, DrawnText, Segment, polyline

LINE_INK = "#1d1d1f"
WHITE = "#ffffff"
LINE_WIDTH, OLD_CREASE_WIDTH, FOLD_LINE_WIDTH, ARROW_WIDTH = 0.9, 0.4, 0.9, 0.9
"""Widths in points: of the paper's edges, of creases that are there, of lines to fold on, of arrows."""
FOLD_LINES = {
    "valley-line": (4.2, 2.4),
    "mountain-line": (6.5, 1.8, 0.9, 1.8, 0.9, 1.8),
    "x-ray-line": (0.7, 1.8),
}
"""Dashes and gaps in points, by the kind of line."""
HEAD_LENGTH, HEAD_WIDTH = 7.5, 5.6
"""Of an arrow's head, in points."""
SHORTEST_SHAFT = 6.0
"""Points of shaft that an arrow keeps beside its heads; the heads of a shorter one are smaller."""
BULGE = 0.28
"""How far an arrow bends off the straight way, in parts of its length."""
TIMES = "\u00d7"
"""The multiplication sign."""
SIGN_SIZE = 8.5
"""Size of the letters in symbols, in points."""


def fold_lines(kind: str, spans: Iterable[Sequence[Point]]) -> list[Drawn]:
    """Lines to fold on, or of hidden edges, one path for all."""
    segments = tuple(segment for span in spans for segment in polyline(span))
    if not segments:
        return []
    return [DrawnPath(kind, segments, LINE_INK, None, FOLD_LINE_WIDTH, FOLD_LINES[kind])]


class Arc:
    """The way of an arrow: a curve from ``start`` to ``end`` that bends to its left (``side`` 1) or right (-1) on paper, y down."""

    def __init__(self, start: Point, end: Point, side: int) -> None:
        self.start, self.end = start, end
        dx, dy = end[0] - start[0], end[1] - start[1]
        middle = between(start, end, 0.5)
        self.pull = middle[0] + 2 * BULGE * side * dy, middle[1] - 2 * BULGE * side * dx
        self.chord = hypot(dx, dy)

    def at(self, part: float) -> Point:
        """The point at a part of the way, 0 to 1."""
        first, second = between(self.start, self.pull, part), between(self.pull, self.end, part)
        return between(first, second, part)

    def cut(self, first: float, last: float) -> tuple[Segment, ...]:
        """The part of the curve between two parts of the way as a path."""
        start, end = self.at(first), self.at(last)
        pull = between(between(self.start, self.pull, last), between(self.pull, self.end, last), first)
        return ((start,), (start, between(start, pull, 2 / 3), between(end, pull, 2 / 3), end))

    def points(self, count: int = 24) -> list[Point]:
        """Points along the whole of it."""
        return [self.at(i / count) for i in range(count + 1)]


HEADS = {
    "valley-arrow": (None, "solid"),
    "mountain-arrow": (None, "half"),
    "unfold-arrow": (None, "hollow"),
    "fold-and-unfold-arrow": ("hollow", "solid"),
}
"""The heads at the start and at the end, by the kind of arrow."""


def arrow(kind: str, arc: Arc) -> list[Drawn]:
    """An arrow along an arc: its shaft and its heads."""
    first, last = HEADS[kind]
    heads = (first is not None) + (last is not None)
    length = min(HEAD_LENGTH, max(arc.chord - SHORTEST_SHAFT, 0.45 * arc.chord) / heads)
    part = min(0.45, 0.8 * length / max(arc.chord * (1 + BULGE**2), 1e-9))
    shaft = arc.cut(part if first else 0.0, 1 - part if last else 1.0)
    drawn: list[Drawn] = [DrawnPath(kind, shaft, LINE_INK, None, ARROW_WIDTH)]
    if first:
        drawn.append(_head(first, arc.start, arc.at(part), length))
    if last:
        drawn.append(_head(last, arc.end, arc.at(1 - part), length))
    return drawn


def _head(style: str, tip: Point, back: Point, length: float) -> Drawn:
    """A head with its tip, its axis from ``back``."""
    angle = atan2(tip[1] - back[1], tip[0] - back[0])
    half = length * HEAD_WIDTH / HEAD_LENGTH / 2

    def point(along: float, across: float) -> Point:
        return tip[0] - along * cos(angle) - across * sin(angle), tip[1] - along * sin(angle) + across * cos(
            angle
        )

    corners = [tip, point(length, half), point(0.75 * length, 0), point(length, -half)]
    if style == "half":
        corners = [tip, point(1.15 * length, 1.25 * half), point(0.8 * length, 0)]
    return DrawnPath(
        f"{style}-head",
        polyline(corners),
        LINE_INK,
        LINE_INK if style == "solid" else WHITE,
        0.7 * ARROW_WIDTH,
        (),
        closed=True,
    )


def repeat_sign(arc: Arc) -> list[Drawn]:
    """A stroke across an arrow: what it shows is repeated, once."""
    (x, y), (ahead_x, ahead_y) = arc.at(0.42), arc.at(0.44)
    angle = atan2(ahead_y - y, ahead_x - x) + pi / 2.6
    dx, dy = 4.2 * cos(angle), 4.2 * sin(angle)
    return [
        DrawnPath("repeat-sign", polyline([(x - dx, y - dy), (x + dx, y + dy)]), LINE_INK, None, ARROW_WIDTH)
    ]


def reference_dot(at: Point) -> Drawn:
    """A small circle around a point that is to be met."""
    return DrawnPath("reference-dot", circle(at, 2.3), LINE_INK, WHITE, 0.8, (), closed=True)


def circle(at: Point, radius: float) -> tuple[Segment, ...]:
    """A circle as four curves."""
    x, y = at
    r, k = radius, 0.5523 * radius
    east, south, west, north = (x + r, y), (x, y + r), (x - r, y), (x, y - r)
    return (
        (east,),
        (east, (x + r, y + k), (x + k, y + r), south),
        (south, (x - k, y + r), (x - r, y + k), west),
        (west, (x - r, y - k), (x - k, y - r), north),
        (north, (x + k, y - r), (x + r, y - k), east),
    )


TURN_OVER_ANGLES = {"x": 0.0, "y": pi / 2, "y=x": pi / 4, "y=-x": -pi / 4}
"""Which way the paper goes when it is turned over about an axis, as the angle of the arrow on paper, y down."""


def turn_over_sign(at: Point, axis: str) -> list[Drawn]:
    """The arrow with a loop around a point: turn the paper over, the way the arrow goes."""
    angle = TURN_OVER_ANGLES[axis]

    def put(x: float, y: float) -> Point:
        return at[0] + x * cos(angle) - y * sin(angle), at[1] + x * sin(angle) + y * cos(angle)

    way = [(-19, 4), (-5, 4), (8, 4), (8, -3), (8, -10), (-8, -10), (-8, -3), (-8, 4), (5, 4), (15, 4)]
    points = [put(x, y) for x, y in way]
    curves = tuple(tuple(points[i : i + 4]) for i in (0, 3, 6))
    shaft = DrawnPath("turn-over", ((points[0],), *curves), LINE_INK, None, ARROW_WIDTH)
    return [shaft, _head("solid", put(21, 4), put(14, 4), HEAD_LENGTH)]


def rotate_sign(at: Point, angle: float) -> list[Drawn]:
    """An arrow around the angle by which the paper is turned in its plane, degrees, positive clockwise."""
    radius, way = 15.0, 1 if angle > 0 else -1
    start, sweep = -pi / 2 - way * 0.82 * pi, way * 1.64 * pi
    parts = 6
    bows = (_bow(at, radius, start + sweep * i / parts, sweep / parts) for i in range(parts))
    segments: list[Segment] = [(_around(at, radius, start),), *bows]
    end = start + sweep
    tip, back = _around(at, radius, end + way * 0.42), _around(at, radius, end)
    text = DrawnText(
        "angle", (at[0], at[1] + 0.36 * SIGN_SIZE), degrees_text(angle), SIGN_SIZE, anchor="middle"
    )
    return [
        DrawnPath("rotate", tuple(segments), LINE_INK, None, ARROW_WIDTH),
        _head("solid", tip, back, HEAD_LENGTH),
        text,
    ]


def degrees_text(angle: float) -> str:
    """An angle without its sign, such as 22.5°: to a hundredth of a degree."""
    return f"{round(abs(angle), 2):g}°"


def _around(at: Point, radius: float, angle: float) -> Point:
    return at[0] + radius * cos(angle), at[1] + radius * sin(angle)


def _bow(at: Point, radius: float, start: float, sweep: float) -> Segment:
    """A part of a circle as one curve; good below a right angle."""
    reach = 4 / 3 * radius * tan(abs(sweep) / 4)
    sign = 1 if sweep > 0 else -1
    first, last = _around(at, radius, start), _around(at, radius, start + sweep)
    ahead = first[0] - sign * reach * sin(start), first[1] + sign * reach * cos(start)
    behind = last[0] + sign * reach * sin(start + sweep), last[1] - sign * reach * cos(start + sweep)
    return first, ahead, behind, last


def enlarge_sign(at: Point, factor: float) -> list[Drawn]:
    """A hollow arrow that grows, or shrinks: from here on drawn so many times as large as before. ``at`` is its left end."""
    x, y = at
    small, big = (2.0, 4.5) if factor > 1 else (4.5, 2.0)
    corners = [
        (x, y - small),
        (x + 13, y - big),
        (x + 13, y - big - 3),
        (x + 22, y),
        (x + 13, y + big + 3),
        (x + 13, y + big),
        (x, y + small),
    ]
    shown = DrawnPath("enlarge", polyline(corners), LINE_INK, WHITE, 0.7, (), closed=True)
    return [
        shown,
        DrawnText("factor", (x + 25, y + 0.36 * SIGN_SIZE), f"{TIMES}{round(factor, 2):g}", SIGN_SIZE),
    ]
