"""The best small motion from a predicted paper to a photo's: sheets drift, and cameras are hand-held."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, degrees, exp, hypot, log, radians, sin

import numpy as np

from folding_server.simulator.paper import Paper
from folding_server.simulator.plane_geometry import Isometry, Point, Polygon, area
from folding_server.vision.agreement import Target, agreement, wrong_pixels
from folding_server.vision.raster import draw_labels

FARTHEST = 0.3
"""Sheet units that the paper may have drifted."""
LARGEST_TURN = 12.0
"""Degrees that it may have turned."""
SCALES = (0.85, 1.15)
"""How far a hand-held camera may have moved away or closer."""
FIXED = (1.0, 1.0)

_SCALE_PRICE = 0.15
_SHIFT_PRICE = 0.01

Parameters = tuple[float, float, float, float]
"""dx, dy in sheet units, turn in radians counter-clockwise, logarithm of the scale; about the centre."""
STILL: Parameters = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Alignment:
    """``motion`` takes the predicted paper to where the photo has it.

    ``shift`` is (dx, dy in sheet units, degrees clockwise) about the predicted paper's ``centre``;
    ``agreement`` is what :func:`folding_server.vision.agreement.agreement` gives after the motion.
    """

    motion: Isometry
    agreement: float
    shift: tuple[float, float, float]
    scale: float
    centre: Point


def align_paper(paper: Paper, target: Target, scales: tuple[float, float] = FIXED) -> Alignment:
    """:func:`align` for a folded sheet."""
    order = paper.order
    return align([paper.polygon(f) for f in order], [paper.back_up(f) for f in order], target, scales)


def align(
    polygons: Sequence[Polygon], backs: Sequence[bool], target: Target, scales: tuple[float, float] = FIXED
) -> Alignment:
    """The best small motion between folded faces, bottom to top, and a photo.

    Scales are tried only if ``scales`` allows more than one; a scale near 1 is preferred.
    """
    search = _Search(polygons, [b and target.two_coloured for b in backs], scales)
    coarse = target.coarser
    best = max(search.starts(coarse), key=lambda p: search.score(p, coarse))
    best = search.climb(best, coarse, 0.05, 2)
    best = max((best, STILL), key=lambda p: search.score(p, target))
    best = search.climb(best, target, 0.012, 3)
    motion = search.motion(best)
    predicted = draw_labels(polygons, search.backs, target.grid, motion)
    dx, dy, turn, size = best
    return Alignment(motion, agreement(predicted, target), (dx, dy, -degrees(turn)), exp(size), search.centre)


class _Search:
    """Hill climbing on the agreement of one prediction."""

    def __init__(
        self, polygons: Sequence[Polygon], backs: Sequence[bool], scales: tuple[float, float]
    ) -> None:
        self.polygons, self.backs, self.scales = polygons, backs, scales
        self.centre = _centre(polygons)
        points = np.array([p for polygon in polygons for p in polygon])
        self.radius = float(np.hypot(*(points - self.centre).T).max()) + 1e-6

    def motion(self, parameters: Parameters) -> Isometry:
        """The similarity with these parameters about the centre."""
        dx, dy, turn, size = parameters
        c, s = exp(size) * cos(turn), exp(size) * sin(turn)
        x, y = self.centre
        return Isometry(c, -s, s, c, x + dx - c * x + s * y, y + dy - s * x - c * y)

    def starts(self, target: Target) -> list[Parameters]:
        """No motion, and the seen paper's centre at several turns."""
        found = [STILL]
        shifts = [(0.0, 0.0)]
        if target.centre is not None:
            shift = (target.centre[0] - self.centre[0], target.centre[1] - self.centre[1])
            if 0.01 < hypot(*shift) <= FARTHEST:
                shifts.append(shift)
        for dx, dy in shifts:
            found += [(dx, dy, radians(turn), 0.0) for turn in (-8.0, -4.0, 0.0, 4.0, 8.0)]
        return found

    def score(self, parameters: Parameters, target: Target) -> float:
        """Minus the share of wrong pixels, less a little for motion."""
        predicted = draw_labels(self.polygons, self.backs, target.grid, self.motion(parameters))
        wrong = wrong_pixels(predicted, target) / max(target.paper_pixels, 1)
        dx, dy, turn, size = parameters
        return -wrong - _SHIFT_PRICE * (hypot(dx, dy) + 0.3 * abs(turn)) - _SCALE_PRICE * abs(size)

    def climb(self, start: Parameters, target: Target, step: float, halvings: int) -> Parameters:
        """Pattern search: ``step`` is in sheet units at the paper's rim, halved whenever nothing improves."""
        best, value = start, self.score(start, target)
        axes = 4 if self.scales[0] < self.scales[1] else 3
        for _ in range(halvings + 1):
            improved = True
            while improved:
                improved = False
                for axis in range(axes):
                    best, value, better = self._along(best, value, axis, step, target)
                    improved |= better
            step /= 2
        return best

    def _along(
        self, best: Parameters, value: float, axis: int, step: float, target: Target
    ) -> tuple[Parameters, float, bool]:
        """The best of one step either way along one parameter."""
        size = step if axis < 2 else step / self.radius
        for sign in (1, -1):
            trial = list(best)
            trial[axis] += sign * size
            moved = (trial[0], trial[1], trial[2], trial[3])
            if self._allowed(moved):
                reached = self.score(moved, target)
                if reached > value + 1e-9:
                    return moved, reached, True
        return best, value, False

    def _allowed(self, parameters: Parameters) -> bool:
        dx, dy, turn, size = parameters
        low, high = self.scales
        near = hypot(dx, dy) <= FARTHEST and abs(turn) <= radians(LARGEST_TURN)
        return near and log(low) - 1e-9 <= size <= log(high) + 1e-9


def _centre(polygons: Sequence[Polygon]) -> Point:
    """Mean place of the paper, every layer counted."""
    total, x, y = 0.0, 0.0, 0.0
    for polygon in polygons:
        size = abs(area(polygon))
        total += size
        x += size * sum(p[0] for p in polygon) / len(polygon)
        y += size * sum(p[1] for p in polygon) / len(polygon)
    return (x / total, y / total) if total else (0.0, 0.0)
