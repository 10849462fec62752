"""What changed between two photos within one colour, where label images show nothing.

Paper that did not move looks as it did, but for slow changes of the light. What looks different must lie along a border
that came or went, and a border that came must look different.
"""

from dataclasses import dataclass
from functools import cached_property, reduce

import cv2
import numpy as np

from folding_server.arrays import Floats, Image, Mask
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.simulator.state_diff import origins
from folding_server.vision.borders import Borders, value_of, visible_borders
from folding_server.vision.labels import LabelImage
from folding_server.vision.registration.scene import Scene
from folding_server.vision.solver.faint_lines import FaintLines, averages

MATCH = 1
"""Pixels by which a border may move and be the same."""
BORDER_REACH = 2
"""Pixels around a border that came or went within which things look different."""
CLOSE = 3
"""Pixels from another border within which a border that came or went need not look different."""
CLEAR_DIFFERENCE = (3.0, 8.0)
"""Differences of so many times the usual one begin to count, and count in full."""
LEAST_USUAL_DIFFERENCE = 0.25
"""The usual difference of lightness (0 to 255) is at least this."""
LEAST_SHARP_SHARE = 0.2
"""If pixels by themselves show less of what looks different than so, it is looked for along lines."""
ACROSS = 3.0
"""Pixels across the trace that a border leaves."""
FADED = 0.4
"""What a border counts that should have changed something and did not, against a change without a border."""


@dataclass(frozen=True)
class Differences:
    """Two photos of a paper, of which nothing or little moved from one to the other.

    ``paper`` lay under the motion ``then`` in the photo ``before``, and lies under ``now`` in ``after`` where it has not
    moved.
    """

    paper: Paper
    before: Scene
    then: Similarity
    after: Scene
    now: Similarity

    @cached_property
    def trace(self) -> Image:
        """How clearly each place of the later photo looks different, (rows, cols) from 0 to 1."""
        if self._details is None:
            return np.zeros(self.after.labels.shape, np.float32)
        return _different(*self._details, self._same)

    @cached_property
    def _details(self) -> tuple[Image, Image] | None:
        """The earlier photo's detail, where the later one has it if nothing moved, and that one's; None if a photo's light is
        not known.
        """
        if self.before.detail is None or self.after.detail is None:
            return None
        old = _warped(self.before.detail, self._pixels_then(), self.after, cv2.INTER_LINEAR)
        return old, self.after.detail

    @cached_property
    def _now(self) -> LabelImage:
        """The class of the paper in the later photo where it is of one colour all around, else 0."""
        return _sound(self.after)

    @cached_property
    def _same(self) -> Mask:
        """Where both photos show paper of the same class, of one colour all around."""
        then = _warped(_sound(self.before), self._pixels_then(), self.after, cv2.INTER_NEAREST)
        return np.asarray((then == self._now) & self.judged)

    @cached_property
    def shown(self) -> Image:
        """The trace, widened by BORDER_REACH."""
        return np.asarray(cv2.dilate(self.trace, square(BORDER_REACH)), np.float32)

    @cached_property
    def judged(self) -> Mask:
        """Where the later photo shows paper of one colour all around."""
        return self._now > 0

    @cached_property
    def borders(self) -> Borders:
        """The borders of the paper where it has not moved."""
        return visible_borders(self.paper, self.after.grid, self.now)

    def unexplained(self, folded: Paper) -> float:
        """Length of lines (sheet units) that speak against a folded paper: what looks different though the same paper is
        seen there, and borders that came or went of which nothing is seen.
        """
        new = visible_borders(folded, self.after.grid, self.now)
        came, went = new.all & ~near(self.borders.all, MATCH), self.borders.all & ~near(new.all, MATCH)
        strange = self.trace[~near(came | went | self._changed(folded, new.topmost), BORDER_REACH)].sum()
        layers = (came & new.layers & ~near(self.borders.all, CLOSE)) | (
            went & self.borders.layers & ~near(new.all, CLOSE)
        )
        hidden = (1 - self._seen(layers & self.judged)).sum()
        unit = self.after.grid.pixels_per_unit
        return float(strange) / (ACROSS * unit) + FADED * self.after.sight * float(hidden) / (2 * unit)

    def _seen(self, borders: Mask) -> Image:
        """How clearly each pixel of borders looks different, by itself or its whole line, (n,) from 0 to 1."""
        clear = self.shown[borders]
        whole = self._faint.shown(borders)[borders] if self._faint else clear
        return np.asarray(np.maximum(clear, whole), np.float32)

    @cached_property
    def _faint(self) -> FaintLines | None:
        return FaintLines(*self._details, self._same) if self._details else None

    def _changed(self, folded: Paper, topmost: LabelImage) -> Mask:
        """Where other paper is on top than before."""
        faces = np.zeros(256, np.uint8)
        for face, origin in origins(self.paper, folded).items():
            if folded.isometries[face] == self.paper.isometries[origin]:
                faces[value_of(folded, face)] = value_of(self.paper, origin)
        return np.asarray(faces[topmost] != self.borders.topmost)

    def _pixels_then(self) -> Floats:
        """The map from pixels of the later photo to those of the earlier, (3, 3)."""
        still = np.array(self.then.rows) @ np.array(self.now.inverse().rows)
        return np.asarray(self.before.grid.matrix() @ still @ np.linalg.inv(self.after.grid.matrix()))


def near(mask: Mask, reach: int) -> Mask:
    """A mask widened by so many pixels."""
    return np.asarray(cv2.dilate(mask.astype(np.uint8), square(reach)) > 0)


def _different(old: Image, new: Image, same: Mask) -> Image:
    """How clearly two pictures differ, 0 to 1, by more than a shift of a pixel and the noise of both make: pixel by pixel or,
    where that shows little of it, along lines of any direction, which blurs their ends.
    """
    inside = cv2.erode(same.astype(np.uint8), square(1)) > 0
    if not inside.any():
        return np.zeros(same.shape, np.float32)
    along = (_clear(cv2.filter2D(old, -1, k), cv2.filter2D(new, -1, k), same) for k in averages())
    sharp = np.where(inside, _clear(old, new, same), np.float32(0))
    faint = np.where(inside, reduce(np.maximum, along), np.float32(0))
    return sharp if float(sharp.sum()) > LEAST_SHARP_SHARE * float(faint.sum()) else faint


def _clear(old: Image, new: Image, same: Mask) -> Image:
    """How clearly two pictures differ, 0 to 1, by more than a shift of a pixel and the noise of both make."""
    over = np.maximum(new - cv2.dilate(old, square(1)), old - cv2.dilate(new, square(1)))
    under = np.maximum(cv2.erode(old, square(1)) - new, cv2.erode(new, square(1)) - old)
    usual = max(LEAST_USUAL_DIFFERENCE, 1.4826 * float(np.median(np.abs(new - old)[same])))
    low, high = CLEAR_DIFFERENCE
    return np.asarray(np.clip((np.maximum(over, under) / usual - low) / (high - low), 0, 1), np.float32)


def _sound(scene: Scene) -> LabelImage:
    """The class of the paper where it is of one colour all around, else 0."""
    classes = np.where(scene.known, scene.labels, 7).astype(np.uint8)
    alike = cv2.erode(classes, square(2)) == cv2.dilate(classes, square(2))
    return np.where(alike & scene.paper, classes, 0).astype(np.uint8)


def square(reach: int) -> LabelImage:
    """A square of ones that reaches so many pixels to each side."""
    return np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)


def _warped(image: Image | LabelImage, matrix: Floats, scene: Scene, how: int) -> Image:
    """An image of the photo before, at the pixels of the later one."""
    size = (scene.grid.cols, scene.grid.rows)
    return np.asarray(cv2.warpAffine(image, matrix[:2], size, flags=how | cv2.WARP_INVERSE_MAP))
