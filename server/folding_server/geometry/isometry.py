"""Isometries of the plane: rotations and reflections with a translation."""

from math import cos, radians, sin, sqrt

from folding_server.geometry.line import Line, Point
from folding_server.geometry.similarity import S, Similarity, composed


class Isometry(Similarity):
    """A similarity that leaves every length as it is: (x, y) -> (a x + b y + e, c x + d y + f)."""

    __slots__ = ()

    def after(self, first: S) -> S:
        """The transform that applies ``first`` and then this one: of the kind of ``first``."""
        return composed(self, first, type(first))

    def inverse(self) -> "Isometry":
        """The isometry that undoes this one: its matrix turned over, without a division."""
        a, b, c, d, e, f = self
        return Isometry(a, c, b, d, -(a * e + c * f), -(b * e + d * f))


IDENTITY = Isometry(1.0, 0.0, 0.0, 1.0, 0.0, 0.0)


def mirror(line: Line) -> Isometry:
    """Reflection across a line."""
    nx, ny, k = line
    return Isometry(1 - 2 * nx * nx, -2 * nx * ny, -2 * nx * ny, 1 - 2 * ny * ny, 2 * k * nx, 2 * k * ny)


def mirror_line(reflection: Isometry) -> Line:
    """The line that a reflection leaves in place: what ``mirror`` was made from, up to the side of its normal."""
    nx, ny = sqrt(max(0.0, (1 - reflection.a) / 2)), sqrt(max(0.0, (1 - reflection.d) / 2))
    if reflection.b > 0:
        ny = -ny
    return Line(nx, ny, (reflection.e * nx + reflection.f * ny) / 2)


def turn(degrees: float, center: Point) -> Isometry:
    """Rotation by degrees, positive clockwise, about a point."""
    angle = radians(degrees)
    c, s = cos(angle), sin(angle)
    x, y = center
    return Isometry(c, s, -s, c, x - c * x - s * y, y + s * x - c * y)
