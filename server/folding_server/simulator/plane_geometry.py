"""Isometries of the plane and convex polygons: pure functions on plain tuples. Lengths in sheet units."""

from collections.abc import Sequence
from math import cos, hypot, radians, sin
from typing import NamedTuple

Point = tuple[float, float]
Polygon = Sequence[Point]

TOLERANCE = 1e-4
"""A vertex this near a fold line lies on it; faces that overlap by less do not overlap (in sheet units)."""


SPECK = 1e-9
"""Sides shorter than this (sheet units) come from clipping at a corner: their direction is rounding noise."""


class Isometry(NamedTuple):
    """(x, y) -> (a x + b y + e, c x + d y + f), a rotation or a reflection with a translation."""

    a: float
    b: float
    c: float
    d: float
    e: float
    f: float

    def __call__(self, point: Point) -> Point:
        """Where a point goes."""
        x, y = point
        return self.a * x + self.b * y + self.e, self.c * x + self.d * y + self.f

    def after(self, first: "Isometry") -> "Isometry":
        """The isometry that applies ``first`` and then this one."""
        a, b, c, d, e, f = self
        p, q, r, s, t, u = first
        return Isometry(
            a * p + b * r, a * q + b * s, c * p + d * r, c * q + d * s, a * t + b * u + e, c * t + d * u + f
        )

    def inverse(self) -> "Isometry":
        """The isometry that undoes this one."""
        a, b, c, d, e, f = self
        return Isometry(a, c, b, d, -(a * e + c * f), -(b * e + d * f))

    @property
    def rows(self) -> tuple[tuple[float, float, float], ...]:
        """The three rows of its matrix, for points (x, y, 1)."""
        return (self.a, self.b, self.e), (self.c, self.d, self.f), (0.0, 0.0, 1.0)

    @property
    def mirrors(self) -> bool:
        """Whether it turns the plane over."""
        return self.a * self.d - self.b * self.c < 0


IDENTITY = Isometry(1.0, 0.0, 0.0, 1.0, 0.0, 0.0)


class Line(NamedTuple):
    """The points with nx x + ny y = offset; (nx, ny) is a unit normal that points to the moving side of a fold."""

    nx: float
    ny: float
    offset: float

    def distance(self, point: Point) -> float:
        """Signed distance of a point, positive on the side of the normal."""
        return self.nx * point[0] + self.ny * point[1] - self.offset


def line_through(p: Point, q: Point) -> Line:
    """The line through two distinct points, normal to the left of p -> q. ZeroDivisionError if they coincide."""
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = hypot(dx, dy)
    nx, ny = -dy / length, dx / length
    return Line(nx, ny, nx * p[0] + ny * p[1])


def mirror(line: Line) -> Isometry:
    """Reflection across a line."""
    nx, ny, k = line
    return Isometry(1 - 2 * nx * nx, -2 * nx * ny, -2 * nx * ny, 1 - 2 * ny * ny, 2 * k * nx, 2 * k * ny)


def turn(degrees: float, center: Point) -> Isometry:
    """Rotation by degrees, positive clockwise, about a point."""
    angle = radians(degrees)
    c, s = cos(angle), sin(angle)
    x, y = center
    return Isometry(c, s, -s, c, x - c * x - s * y, y + s * x - c * y)


def between(p: Point, q: Point, fraction: float) -> Point:
    """The point a fraction of the way from p to q."""
    return p[0] + (q[0] - p[0]) * fraction, p[1] + (q[1] - p[1]) * fraction


def clip(polygon: Polygon, line: Line) -> list[Point]:
    """The part of a convex polygon on the side of the line's normal."""
    kept: list[Point] = []
    previous = polygon[-1]
    before = line.distance(previous)
    for point in polygon:
        here = line.distance(point)
        if (before < 0 < here) or (here < 0 < before):
            kept.append(between(previous, point, before / (before - here)))
        if here >= 0:
            kept.append(point)
        previous, before = point, here
    return kept


def area(polygon: Polygon) -> float:
    """Signed area, positive if the polygon runs counter-clockwise."""
    total = 0.0
    x0, y0 = polygon[-1]
    for x1, y1 in polygon:
        total += x0 * y1 - x1 * y0
        x0, y0 = x1, y1
    return total / 2


def overlap(first: Polygon, second: Polygon, tolerance: float = TOLERANCE) -> bool:
    """Whether two convex polygons overlap by more than the tolerance, measured across every side of both."""
    return not (_separated(first, second, tolerance) or _separated(second, first, tolerance))


def _separated(first: Polygon, second: Polygon, tolerance: float) -> bool:
    """Whether a side of ``first`` separates the two to within the tolerance."""
    x0, y0 = first[-1]
    sign = 1.0 if area(first) > 0 else -1.0
    for x1, y1 in first:
        dx, dy = x1 - x0, y1 - y0
        length = hypot(dx, dy)
        if length > SPECK:
            nx, ny = sign * dy / length, -sign * dx / length
            edge = nx * x0 + ny * y0
            if min(nx * x + ny * y for x, y in second) >= edge - tolerance:
                return True
        x0, y0 = x1, y1
    return False
