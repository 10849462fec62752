"""How well a predicted label image explains a photo's: the fast inner loop of every search."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACK, BACKGROUND, FRONT, UNKNOWN, Labels, as_one_colour, is_paper

MARGIN = 0.03
"""Width, in sheet units, of the table around the paper that counts too."""


@dataclass(frozen=True)
class Target:
    """A photo's label image on a grid, with what every comparison with it needs worked out once."""

    labels: Labels
    grid: Grid
    two_coloured: bool = True

    @cached_property
    def known(self) -> npt.NDArray[np.uint8]:
        """1 where the class is known."""
        return np.asarray(self.labels != UNKNOWN, np.uint8)

    @cached_property
    def zone(self) -> npt.NDArray[np.uint8]:
        """1 on and around the seen paper."""
        return self.widened(is_paper(self.labels).astype(np.uint8))

    @cached_property
    def paper_pixels(self) -> int:
        """How many pixels show paper."""
        return int(is_paper(self.labels).sum())

    @cached_property
    def centre(self) -> tuple[float, float] | None:
        """Centroid of the seen paper in sheet units, None if there is none."""
        rows, cols = np.nonzero(is_paper(self.labels))
        if not len(rows):
            return None
        x, y = self.grid.to_plane(np.array([cols.mean(), rows.mean()]))
        return float(x), float(y)

    @cached_property
    def coarser(self) -> "Target":
        """The same at a third of the resolution: the most frequent class of each 3 x 3 pixels."""
        rows, cols = self.grid.rows // 3, self.grid.cols // 3
        blocks = self.labels[: rows * 3, : cols * 3].reshape(rows, 3, cols, 3)
        values = (BACKGROUND, FRONT, BACK, UNKNOWN)
        counts = np.stack([(blocks == value).sum(axis=(1, 3)) for value in values])
        labels = np.array(values, np.uint8)[counts.argmax(axis=0)]
        grid = Grid(self.grid.left, self.grid.top, self.grid.pixels_per_unit / 3, rows, cols)
        return Target(labels, grid, self.two_coloured)

    def widened(self, mask: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
        """A mask and the margin around it."""
        reach = 2 * max(1, round(MARGIN * self.grid.pixels_per_unit)) + 1
        return np.asarray(cv2.dilate(mask, np.ones((reach, reach), np.uint8)), np.uint8)


def agreement(predicted: Labels, target: Target) -> float:
    """Share of the known pixels on and around predicted and seen paper whose class agrees; 0 if none.

    If the sides look alike in the photo, all paper counts as one class.
    """
    if not target.two_coloured:
        predicted = as_one_colour(predicted)
    paper = np.asarray(cv2.threshold(predicted, 0, 1, cv2.THRESH_BINARY)[1], np.uint8)
    zone = cv2.bitwise_and(cv2.bitwise_or(target.widened(paper), target.zone), target.known)
    total = cv2.countNonZero(zone)
    return 1.0 - wrong_pixels(predicted, target) / total if total else 0.0


def wrong_pixels(predicted: Labels, target: Target) -> int:
    """How many known pixels have another class than predicted."""
    differs = cv2.compare(predicted, target.labels, cv2.CMP_NE)
    return int(cv2.countNonZero(cv2.bitwise_and(differs, target.known)))
