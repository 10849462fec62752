"""Lines too faint to be told pixel by pixel: the noise of pixels cancels along a line, what the line shows does not."""

from functools import cache
from math import cos, pi, sin

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Floats, Image, Indices, Mask

AVERAGED_LENGTH, AVERAGED_DIRECTIONS = 13, 12
"""Pixels along which pictures are averaged where no line is given, and in how many directions."""
FEWEST_LINE_PIXELS = 10
"""Lines of fewer pixels say nothing as a whole."""
LINE_SURROUNDINGS = 15
"""Pixels across of the neighbourhood against which a line is darker or lighter."""
LINE_CLEARNESS = (3.0, 6.0)
"""A line that stands out from lines beside it by so many times what those vary begins to count, and counts in full."""
FEWEST_BESIDE, MOSTLY = 6, 0.6
"""Lines beside needed to judge one, and the share of such a line that must lie where both photos can be compared."""
ON_ITSELF = 0.2
"""Share of a line that, moved along itself, may lie on the line as it was: more shows the line, not what lies beside it.

Of 2,500 random straight lines of 64 to 90 pixels, 1.5 times as strong as the noise of each photo, all are shown; without this
limit, 2 are not.
"""
_BESIDE = np.array([(y, x) for y in range(-21, 22, 7) for x in range(-21, 22, 7) if abs(x) + abs(y) > 10])
_HERE = np.array([(y, x) for y in (-1, 0, 1) for x in (-1, 0, 1)])
"""Shifts (rows, columns) to the lines beside one, and those by which it may be out of place."""
_LEAST_SPREAD = 0.1
"""Least spread of a place, as a share of its mean."""
_TINY = 1e-6
"""Keeps divisions finite."""


@cache
def averages() -> tuple[Image, ...]:
    """Kernels that average along a line in each direction."""
    return tuple(_average(pi * k / AVERAGED_DIRECTIONS) for k in range(AVERAGED_DIRECTIONS))


def _average(angle: float) -> Image:
    """A line through the middle of a kernel, spread over the pixels it runs between."""
    middle = AVERAGED_LENGTH // 2 + 1
    kernel = np.zeros((2 * middle + 1, 2 * middle + 1), np.float32)
    for along in np.linspace(-AVERAGED_LENGTH / 2, AVERAGED_LENGTH / 2, 4 * AVERAGED_LENGTH).tolist():
        x, y = middle + along * cos(angle), middle + along * sin(angle)
        left, upper = int(x), int(y)
        for col, across in ((left, 1 - x + left), (left + 1, x - left)):
            for row, down in ((upper, 1 - y + upper), (upper + 1, y - upper)):
                kernel[row, col] += across * down
    return np.asarray(kernel / kernel.sum(), np.float32)


class FaintLines:
    """How surely lines show in the difference of two pictures (rows, cols), where they can be compared (``same``)."""

    def __init__(self, old: Image, new: Image, same: Mask) -> None:
        self._weight = cv2.erode(same.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(np.float32)
        change = (new - old) * self._weight
        size = (LINE_SURROUNDINGS, LINE_SURROUNDINGS)
        around = cv2.blur(change, size) / np.maximum(cv2.blur(self._weight, size), _TINY)
        self._change = (change - around) * self._weight

    def shown(self, lines: Mask) -> Image:
        """How surely each connected part of a mask of lines shows as a whole, on its pixels, (rows, cols) from 0 to 1."""
        sure = np.zeros(lines.shape, np.float32)
        count, parts = cv2.connectedComponents(lines.astype(np.uint8), connectivity=8)
        for part in range(1, count):
            pixels = np.argwhere(parts == part)
            if len(pixels) >= FEWEST_LINE_PIXELS:
                sure[tuple(pixels.T)] = self._sure(pixels)
        return sure

    def _sure(self, line: Indices) -> float:
        """How surely a line (n, 2) shows: what it shows in the mean against what the same line shows beside."""
        here, _ = self._means(line, _HERE)
        shifts = (_BESIDE[:, None] + _HERE[None]).reshape(-1, 2)
        beside, there = (found.reshape(len(_BESIDE), -1) for found in self._means(line, shifts))
        comparable, apart = there.min(axis=1) > MOSTLY, self._on_itself(line) <= ON_ITSELF
        usual = np.abs(beside).max(axis=1)[comparable & apart]
        if len(usual) < FEWEST_BESIDE:
            return 0.0
        middle = float(np.median(usual))
        spread = 1.4826 * float(np.median(np.abs(usual - middle))) + _LEAST_SPREAD * middle
        low, high = LINE_CLEARNESS
        stands_out = (float(np.abs(here).max()) - middle) / max(spread, _TINY)
        return float(np.clip((stands_out - low) / (high - low), 0, 1))

    def _means(self, line: Indices, shifts: npt.NDArray[np.int_]) -> tuple[Floats, Floats]:
        """For each shift of a line the mean change along it, and the share of it that can be compared, both (n,)."""
        rows, cols, inside = self._shifted(line, shifts)
        weight = (self._weight[rows, cols] * inside).astype(np.float64)
        total = (self._change[rows, cols] * weight).sum(axis=1)
        return total / np.maximum(weight.sum(axis=1), 1.0), weight.mean(axis=1)

    def _on_itself(self, line: npt.NDArray[np.intp]) -> Floats:
        """The share of a line that each of the lines beside has in common with it, (n,): a straight line moved along itself
        is beside nothing.
        """
        own = np.zeros(self._weight.shape, np.uint8)
        own[tuple(line.T)] = 1
        rows, cols, inside = self._shifted(line, _BESIDE)
        near = cv2.dilate(own, np.ones((3, 3), np.uint8)) > 0
        return np.asarray((near[rows, cols] & inside).mean(axis=1), np.float64)

    def _shifted(
        self, line: npt.NDArray[np.intp], shifts: npt.NDArray[np.int_]
    ) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], Mask]:
        """Rows, columns and which of them lie in the picture, each (shifts, pixels); 0 where they do not."""
        rows, cols = (line[None] + shifts[:, None]).transpose(2, 0, 1)
        inside = (rows >= 0) & (cols >= 0) & (rows < self._weight.shape[0]) & (cols < self._weight.shape[1])
        return np.where(inside, rows, 0), np.where(inside, cols, 0), inside
