"""Whether a reconstructed paper is the true one: same vertices, same creases, same order of layers.

The sheet is a square, and which corner is called which is a matter of taste: the best of its four turns counts.
"""

from dataclasses import dataclass
from math import hypot

import numpy as np
from folding_server.simulator import Paper, overlapping_pairs
from folding_server.simulator.plane_geometry import Point, clip, line_through
from shapely.geometry import Polygon


@dataclass(frozen=True)
class Exactness:
    """``farthest`` is the largest distance (sheet units) from a true vertex to the nearest found one."""

    farthest: float
    creases: float
    order: float

    def holds(self, tolerance: float) -> bool:
        """Whether vertices, creases and order all agree."""
        return self.farthest <= tolerance and self.creases == 1.0 and self.order == 1.0


def exactness(truth: Paper, found: Paper, tolerance: float = 0.02) -> Exactness:
    """The best agreement over the four turns of the sheet."""
    results = [_under(truth, found, quarter, tolerance) for quarter in range(4)]
    return max(results, key=lambda e: (e.creases + e.order, -e.farthest))


def _under(truth: Paper, found: Paper, quarter: int, tolerance: float) -> Exactness:
    def turned(p: Point) -> Point:
        x, y = p
        for _ in range(quarter):
            x, y = y, 1 - x
        return x, y

    places = np.array(list(found.places.values()))
    farthest = max(float(np.min(np.hypot(*(places - turned(p)).T))) for p in truth.places.values())
    return Exactness(farthest, _creases(truth, found, turned, tolerance), _order(truth, found, turned))


def _creases(truth: Paper, found: Paper, turned, tolerance: float) -> float:  # noqa: ANN001
    """Share of sampled points on the creases of either that lie on one of the same kind in the other."""
    true_lines = [(turned(truth.places[u]), turned(truth.places[v]), kind(letter)) for (u, v), letter in truth.edges()]
    found_lines = [(found.places[u], found.places[v], kind(letter)) for (u, v), letter in found.edges()]
    checks = [
        any(k == other and _gap(point, p, q) <= tolerance for p, q, other in lines)
        for own, lines in ((true_lines, found_lines), (found_lines, true_lines))
        for a, b, k in own
        if k != "boundary" and hypot(a[0] - b[0], a[1] - b[1]) > 3 * tolerance
        for point in ((a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t) for t in (0.3, 0.5, 0.7))
    ]
    return sum(checks) / len(checks) if checks else 1.0


def kind(letter: str) -> str:
    """Boundary, flat or folded."""
    return {"B": "boundary", "F": "flat"}.get(letter, "folded")


def _gap(point: Point, p: Point, q: Point) -> float:
    """Distance of a point from a segment."""
    (x, y), (px, py), (qx, qy) = point, p, q
    dx, dy = qx - px, qy - py
    length = dx * dx + dy * dy
    t = 0.0 if length == 0 else min(1.0, max(0.0, ((x - px) * dx + (y - py) * dy) / length))
    return hypot(x - px - t * dx, y - py - t * dy)


def _order(truth: Paper, found: Paper, turned) -> float:  # noqa: ANN001
    """Share of overlapping pairs of true faces whose order agrees, at the middle of their overlap."""
    agree = total = 0
    for lower, upper in overlapping_pairs(truth):
        common = Polygon(truth.polygon(lower)).intersection(Polygon(truth.polygon(upper)))
        if common.area < 4e-4:
            continue
        spot = common.representative_point()
        below = _face_at(found, turned(truth.isometries[lower].inverse()((spot.x, spot.y))))
        above = _face_at(found, turned(truth.isometries[upper].inverse()((spot.x, spot.y))))
        total += 1
        agree += found.rank[below] < found.rank[above]
    return agree / total if total else 1.0


def _face_at(paper: Paper, place: Point) -> int:
    """The face whose part of the sheet holds a place, or is nearest to it."""
    return min(paper.faces, key=lambda f: _outside(paper.sheet_polygon(f), place))


def _outside(outline: list[Point], point: Point) -> float:
    return max(
        line_through(p, q).distance(point)
        for p, q in zip(outline, outline[1:] + outline[:1], strict=True)
        if hypot(p[0] - q[0], p[1] - q[1]) > 1e-9
    )


__all__ = ["Exactness", "clip", "exactness", "kind"]
