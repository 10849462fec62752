"""The best small motion from a predicted paper to a photo's: sheets drift, and cameras are hand-held."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from math import hypot, inf, log, sqrt

import numpy as np

from folding_server.geometry.isometry import IDENTITY
from folding_server.geometry.line import Point
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACK, BACKGROUND, FRONT, UNKNOWN, LabelImage, is_paper
from folding_server.vision.registration.alignment import SCALES, Vector, climb, nudged, polished
from folding_server.vision.registration.scene import FaceStack, Scene, face_stack

LARGEST_SHIFT = 0.3
"""Sheet units that the paper may have drifted."""
LARGEST_TURN = 12.0
"""Degrees that it may have turned."""
THICKNESS_SCALE = 1.02
"""Even under a camera that stands still thick paper looks larger, for it reaches up to the lens."""
FIXED = (1.0, 1.0)
"""Scales that a camera which stands still shows the sheet at."""
TURNS = (0.0, -3.0, 3.0, -6.0, 6.0, -9.0, 9.0)
"""Degrees at which the search starts."""

_COARSER = 3
"""How many times coarser the first look is."""
_STARTS = 3
"""Starts that are climbed from, the most promising."""
_ROUNDING = 1e-9
"""Motions within this of a limit are allowed."""
_CLOSE = (0.01, 0.01, 1.0, 0.02)
"""Motions that differ by less (dx, dy in sheet units, degrees, logarithm of the scale) are one."""
_SHIFT_PRICE, _TURN_PRICE, _SCALE_PRICE = 0.01, 0.00005, 0.02
"""What motion costs in agreement, per sheet unit, degree and unit of the scale's logarithm: it settles ties."""


@dataclass(frozen=True)
class Alignment:
    """``motion`` takes the predicted paper to where the photo has it.

    ``shift`` is (dx, dy in sheet units, degrees clockwise) about the predicted paper's ``centre``;
    ``agreement`` is what :meth:`folding_server.vision.registration.scene.Scene.agreement_of` gives after the
    motion, 0 if the photo shows none of the places where the paper should be.
    """

    motion: Similarity
    agreement: float
    shift: tuple[float, float, float]
    scale: float
    centre: Point


def align_paper(paper: Paper, scene: Scene, scales: tuple[float, float] = FIXED) -> Alignment:
    """The best small motion between a folded sheet and a photo; deterministic.

    ``scales`` bounds how much smaller or larger than in frame 1 a camera may show the sheet.
    """
    stack = face_stack(paper)
    low, high = (
        log(max(scales[0] / THICKNESS_SCALE, SCALES[0])),
        log(min(scales[1] * THICKNESS_SCALE, SCALES[1])),
    )
    coarse, fine = _Search(stack, coarser(scene), low, high), _Search(stack, scene, low, high)
    begun = [coarse.climbed(start, 0.03, 3) for start in coarse.starts()]
    best = max((fine.polished(start) for start in _distinct(begun)), key=fine.value)
    best = fine.polished(fine.climbed(best, 0.01, 3))
    motion = fine.motion(best)
    return Alignment(motion, fine.agreement(motion), (best[0], best[1], best[2]), motion.scale, stack.center)


@dataclass(frozen=True)
class _Search:
    """The search for the motion of one stack: (dx, dy, degrees clockwise, logarithm of the scale) within limits."""

    stack: FaceStack
    scene: Scene
    smallest: float
    largest: float

    def limited(self, nudge: Vector) -> Vector:
        """The nearest motion that is allowed."""
        dx, dy, turned, size = nudge
        nearer = min(1.0, LARGEST_SHIFT / max(hypot(dx, dy), 1e-9))
        turned = min(max(turned, -LARGEST_TURN), LARGEST_TURN)
        return dx * nearer, dy * nearer, turned, min(max(size, self.smallest), self.largest)

    def motion(self, nudge: Vector) -> Similarity:
        """The similarity about the stack's middle."""
        return nudged(IDENTITY, self.stack.center, self.limited(nudge))

    def drawn(self, nudge: Vector) -> LabelImage:
        """What the stack looks like after a motion."""
        return self.scene.draw(self.stack, self.motion(nudge))

    def value(self, nudge: Vector) -> float:
        """Agreement, less a little for motion; minus infinity for motions that are not allowed."""
        dx, dy, turned, size = nudge
        if any(abs(a - b) > _ROUNDING for a, b in zip(nudge, self.limited(nudge), strict=True)):
            return -inf
        price = _SHIFT_PRICE * hypot(dx, dy) + _TURN_PRICE * abs(turned) + _SCALE_PRICE * abs(size)
        return self.scene.agreement_of(self.drawn(nudge)) - price

    def agreement(self, motion: Similarity) -> float:
        """Agreement, 0 if nothing can be seen where the paper should be."""
        drawn = self.scene.draw(self.stack, motion)
        judged = (is_paper(drawn) | self.scene.paper) & self.scene.known
        return self.scene.agreement_of(drawn) if judged.any() else 0.0

    def starts(self) -> list[Vector]:
        """The most promising of no motion and of laying the middles over each other, at several turns and sizes."""
        tried = sorted(self._all_starts(), key=self.value, reverse=True)
        return tried[:_STARTS]

    def _all_starts(self) -> Iterator[Vector]:
        x, y = self.stack.center
        to_seen = self.scene.center[0] - x, self.scene.center[1] - y
        for (dx, dy), size, turned in product(((0.0, 0.0), to_seen), {0.0, self._size()}, TURNS):
            yield self.limited((dx, dy, turned, size))

    def _size(self) -> float:
        """The logarithm of the scale at which as much paper would show as is seen."""
        seen = np.count_nonzero(self.scene.paper)
        drawn = np.count_nonzero(is_paper(self.scene.draw(self.stack, IDENTITY)))
        return log(sqrt(seen / drawn)) if seen and drawn else 0.0

    def climbed(self, start: Vector, step: float, halvings: int) -> Vector:
        """The summit near a start; ``step`` is in sheet units at the paper's rim."""
        return climb(self.value, start, (step, step, 100 * step, 2 * step), halvings)[0]

    def polished(self, start: Vector) -> Vector:
        """A start after descents on the blurred picture."""
        pixel = 1.0 / self.scene.grid.pixels_per_unit
        steps = (pixel, pixel, 100 * pixel, 2 * pixel)
        return self.limited(
            polished(self.drawn, self._agreement, self.scene, start, self._agreement(start), steps)[0]
        )

    def _agreement(self, nudge: Vector) -> float:
        return self.scene.agreement_of(self.drawn(nudge))


def _distinct(nudges: list[Vector]) -> list[Vector]:
    """Motions without those that an earlier one comes close to."""
    kept: list[Vector] = []
    for nudge in nudges:
        if not any(_close(nudge, other) for other in kept):
            kept.append(nudge)
    return kept


def _close(first: Vector, second: Vector) -> bool:
    return all(abs(a - b) <= reach for a, b, reach in zip(first, second, _CLOSE, strict=True))


def coarser(scene: Scene) -> Scene:
    """The same at a third of the resolution: the most frequent class of each 3 x 3 pixels."""
    rows, cols = scene.grid.rows // _COARSER, scene.grid.cols // _COARSER
    blocks = scene.labels[: rows * _COARSER, : cols * _COARSER].reshape(rows, _COARSER, cols, _COARSER)
    values = (BACKGROUND, FRONT, BACK, UNKNOWN)
    counts = np.stack([(blocks == value).sum(axis=(1, 3)) for value in values])
    labels = np.array(values, np.uint8)[counts.argmax(axis=0)]
    grid: Grid = replace(
        scene.grid, pixels_per_unit=scene.grid.pixels_per_unit / _COARSER, rows=rows, cols=cols
    )
    return Scene(grid, labels, scene.two_coloured)
