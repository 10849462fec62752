"""Convex polygons: area, clipping, bounding boxes, overlap."""

from collections.abc import Sequence
from math import hypot, inf

from folding_server.geometry.line import Line, Point, between
from folding_server.geometry.tolerance import TOLERANCE

Polygon = Sequence[Point]
"""The corners of a convex outline, either way round."""
Box = tuple[float, float, float, float]
"""Least x, least y, greatest x, greatest y."""

SPECK = 1e-9
"""Sides shorter than this (sheet units) come from clipping at a corner: their direction is rounding noise."""


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
            if min([nx * x + ny * y for x, y in second]) >= edge - tolerance:
                return True
        x0, y0 = x1, y1
    return False


NO_BOX: Box = (inf, inf, -inf, -inf)
"""The box around nothing."""


def bounding_box(outline: list[Point]) -> Box:
    """The box around an outline; that of no points meets nothing."""
    if not outline:
        return NO_BOX
    xs, ys = [p[0] for p in outline], [p[1] for p in outline]
    return min(xs), min(ys), max(xs), max(ys)


def boxes_meet(a: Box, b: Box) -> bool:
    """Whether two boxes have a point in common."""
    return a[0] <= b[2] and b[0] <= a[2] and a[1] <= b[3] and b[1] <= a[3]
