"""The seven Huzita-Justin axioms: the lines along which points and lines can be brought together.

After R. J. Lang, "Origami and Geometric Constructions" (2010), whose numbering is that of Huzita with Justin's (and Hatori's)
as the seventh.
"""

from math import hypot, sqrt

import numpy as np

from folding_server.geometry.isometry import mirror
from folding_server.geometry.line import Line, Point, between, line_through
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.wording.landmarks import MEETING, NamedLine

SAME_SLANT = 1e-6
"""Two unit normals whose cross product is no larger belong to parallel lines."""


def through_two_points(p: Point, q: Point) -> list[Line]:
    """Axiom 1: the line through two points."""
    return [line_through(p, q)] if hypot(p[0] - q[0], p[1] - q[1]) > TOLERANCE else []


def point_to_point(p: Point, q: Point) -> list[Line]:
    """Axiom 2: the line that brings one point to another."""
    length = hypot(q[0] - p[0], q[1] - p[1])
    if length <= MEETING:
        return []
    nx, ny = (p[0] - q[0]) / length, (p[1] - q[1]) / length
    middle = between(p, q, 0.5)
    return [Line(nx, ny, nx * middle[0] + ny * middle[1])]


def line_to_line(first: Line, second: Line) -> list[Line]:
    """Axiom 3: the lines that bring one line to another: two, or one between parallels."""
    ax, ay, a = first
    bx, by, b = second
    if abs(ax * by - ay * bx) <= SAME_SLANT:
        sign = 1 if ax * bx + ay * by > 0 else -1
        return [Line(ax, ay, (a + sign * b) / 2)]
    found = []
    for sign in (1, -1):
        nx, ny, offset = ax + sign * bx, ay + sign * by, a + sign * b
        length = hypot(nx, ny)
        found.append(Line(nx / length, ny / length, offset / length))
    return found


def through_point_across_line(p: Point, line: Line) -> list[Line]:
    """Axiom 4: the line through a point that brings a line onto itself."""
    nx, ny = -line.ny, line.nx
    return [Line(nx, ny, nx * p[0] + ny * p[1])]


def point_to_line_through_point(p: Point, line: Line, q: Point) -> list[Line]:
    """Axiom 5: the lines through ``q`` that bring ``p`` to a line, at most two."""
    radius, off = hypot(p[0] - q[0], p[1] - q[1]), line.distance(q)
    if radius < abs(off):
        return []
    half = sqrt(radius**2 - off**2)
    foot = q[0] - off * line.nx, q[1] - off * line.ny
    images = [(foot[0] - way * half * line.ny, foot[1] + way * half * line.nx) for way in (1, -1)]
    return [found for image in images for found in point_to_point(p, image)]


def two_points_to_two_lines(p: Point, first: Line, q: Point, second: Line) -> list[Line]:
    """Axiom 6: the lines that bring two points each to a line, at most three: the roots of a cubic."""
    foot = first.nx * first.offset, first.ny * first.offset

    def image(at: float) -> Point:
        return foot[0] - at * first.ny, foot[1] + at * first.nx

    def miss(at: float) -> float:
        """How far off the second point is, times the square of the first one's way: a cubic in ``at``."""
        x, y = image(at)
        square = (x - p[0]) ** 2 + (y - p[1]) ** 2
        (line,) = point_to_point(p, (x, y)) or [Line(1.0, 0.0, p[0])]
        return second.distance(mirror(line)(q)) * square

    samples = [-1.1, -0.3, 0.6, 1.7]
    cubic = np.polyfit(samples, [miss(at) for at in samples], 3)
    roots = [float(root.real) for root in np.roots(cubic) if abs(root.imag) < 1e-6]
    return [line for root in sorted(roots) for line in point_to_point(p, image(root))]


def point_to_line_across_line(p: Point, first: Line, second: Line) -> list[Line]:
    """Axiom 7: the line at right angles to ``second`` that brings ``p`` to ``first``."""
    dx, dy = -second.ny, second.nx
    slope = first.nx * dx + first.ny * dy
    if abs(slope) <= SAME_SLANT:
        return []
    way = -first.distance(p) / slope
    return point_to_point(p, (p[0] + way * dx, p[1] + way * dy))


def lines_of(axiom: int, points: list[Point], lines: list[NamedLine]) -> list[Line]:
    """The lines of an axiom, from points and lines in the order in which they are said."""
    along = [each.line for each in lines]
    match axiom:
        case 1:
            return through_two_points(points[0], points[1])
        case 2:
            return point_to_point(points[0], points[1])
        case 3:
            return line_to_line(along[0], along[1])
        case 4:
            return through_point_across_line(points[0], along[0])
        case 5:
            return point_to_line_through_point(points[0], along[0], points[1])
        case 6:
            return two_points_to_two_lines(points[0], along[0], points[1], along[1])
    return point_to_line_across_line(points[0], along[0], along[1])
