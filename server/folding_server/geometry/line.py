"""Points and lines of the plane."""

from math import hypot
from typing import NamedTuple

Point = tuple[float, float]
"""x, y."""


class Line(NamedTuple):
    """The points with nx x + ny y = offset; (nx, ny) is a unit normal that points to the moving side of a fold."""

    nx: float
    ny: float
    offset: float

    def distance(self, point: Point) -> float:
        """Signed distance of a point, positive on the side of the normal."""
        return self.nx * point[0] + self.ny * point[1] - self.offset

    def opposite(self) -> "Line":
        """The same line with its normal to the other side."""
        return Line(-self.nx, -self.ny, -self.offset)


def line_through(p: Point, q: Point) -> Line:
    """The line through two distinct points, normal to the left of p -> q. ZeroDivisionError if they coincide."""
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = hypot(dx, dy)
    nx, ny = -dy / length, dx / length
    return Line(nx, ny, nx * p[0] + ny * p[1])


def between(p: Point, q: Point, fraction: float) -> Point:
    """The point a fraction of the way from p to q."""
    return p[0] + (q[0] - p[0]) * fraction, p[1] + (q[1] - p[1]) * fraction
