"""Isometries of the plane: rotations and reflections with a translation."""

from math import cos, radians, sin
from typing import NamedTuple

from folding_server.geometry.line import Line, Point


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
