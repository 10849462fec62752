"""Points and creases on the unfolded sheet, and how far apart they lie. Lengths in sheet units."""

from collections.abc import Iterator, Sequence
from math import dist, hypot

from folding_server.geometry.line import Point, between
from folding_server.simulator import Paper

Segment = tuple[Point, Point]
QUARTERS = range(4)
"""Quarter turns of the sheet: which of its corners is called the first cannot be seen."""
_SPACING = 0.01


def turned(point: Point, quarters: int) -> Point:
    """A place on the sheet after quarter turns of the unit square about its middle."""
    x, y = point
    for _ in range(quarters):
        x, y = y, 1 - x
    return x, y


def gap(point: Point, segment: Segment) -> float:
    """Distance of a point from a segment."""
    (x, y), ((px, py), (qx, qy)) = point, segment
    dx, dy = qx - px, qy - py
    length = dx * dx + dy * dy
    t = 0.0 if length == 0 else min(1.0, max(0.0, ((x - px) * dx + (y - py) * dy) / length))
    return hypot(x - px - t * dx, y - py - t * dy)


def folded_between(before: Paper, after: Paper) -> list[Segment]:
    """What the folds of a transition creased: the parts of their creases on each layer, on the sheet."""
    return [
        (after.vertices_coords[u], after.vertices_coords[v])
        for (u, v), crease in sorted(after.creases.items())
        if crease.fold > before.folds and after.is_folded((u, v))
    ]


def line_error(true: Sequence[Segment], found: Sequence[Segment], quarters: int = 0) -> float | None:
    """How far two sets of creases are apart; None if either is empty.

    The mean distance of the points of one set from the other, the larger of the two ways: the modified
    Hausdorff distance of Dubuisson and Jain (1994). ``true`` is turned by quarters of the sheet first.
    """
    if not true or not found:
        return None
    expected = [(turned(p, quarters), turned(q, quarters)) for p, q in true]
    return max(_mean_gap(expected, found), _mean_gap(found, expected))


def _mean_gap(own: Sequence[Segment], other: Sequence[Segment]) -> float:
    gaps = [min(gap(point, segment) for segment in other) for point in _samples(own)]
    return sum(gaps) / len(gaps)


def _samples(segments: Sequence[Segment]) -> Iterator[Point]:
    """Points evenly spaced along segments, at least one each."""
    for p, q in segments:
        count = max(1, round(dist(p, q) / _SPACING))
        yield from (between(p, q, (i + 0.5) / count) for i in range(count))
