"""Similarities of the plane: a rotation or a reflection with a scaling and a translation."""

from math import atan2, cos, degrees, hypot, sin
from typing import NamedTuple, TypeVar

from folding_server.geometry.line import Point


class Similarity(NamedTuple):
    """(x, y) -> (a x + b y + e, c x + d y + f), where (a, c) and (b, d) are square to each other and equally long."""

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

    def after(self, first: "Similarity") -> "Similarity":
        """The similarity that applies ``first`` and then this one."""
        return composed(self, first, Similarity)

    def inverse(self) -> "Similarity":
        """The similarity that undoes this one. ZeroDivisionError if its scale is 0."""
        a, b, c, d, e, f = self
        det = a * d - b * c
        return Similarity(d / det, -b / det, -c / det, a / det, (b * f - d * e) / det, (c * e - a * f) / det)

    @property
    def rows(self) -> tuple[tuple[float, float, float], ...]:
        """The three rows of its matrix, for points (x, y, 1)."""
        return (self.a, self.b, self.e), (self.c, self.d, self.f), (0.0, 0.0, 1.0)

    @property
    def mirrors(self) -> bool:
        """Whether it turns the plane over."""
        return self.a * self.d - self.b * self.c < 0

    @property
    def scale(self) -> float:
        """How many times as long everything becomes."""
        return hypot(self.a, self.b)


S = TypeVar("S", bound=Similarity)


def composed(second: Similarity, first: Similarity, kind: type[S]) -> S:
    """``first`` and then ``second``, as one transform of a kind that the caller knows to be right."""
    a, b, c, d, e, f = second
    p, q, r, s, t, u = first
    return kind(
        a * p + b * r, a * q + b * s, c * p + d * r, c * q + d * s, a * t + b * u + e, c * t + d * u + f
    )


def turned_between(first: Similarity, second: Similarity) -> float:
    """The angle between two similarities in degrees, 0 to 180."""
    turn = atan2(second.b, second.a) - atan2(first.b, first.a)
    return abs(degrees(atan2(sin(turn), cos(turn))))
