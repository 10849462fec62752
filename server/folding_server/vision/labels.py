"""The classes of a label image, one per pixel, as uint8.

When both sides of the sheet look the same a photo can only say "paper": such label images use FRONT for all
of the paper, and whoever compares them folds a prediction the same way with :func:`as_one_colour`.
"""

import numpy as np
import numpy.typing as npt

from folding_server.arrays import Mask

BACKGROUND = 0
FRONT = 1
BACK = 2
UNKNOWN = 255
"""Hidden by something that is neither paper nor table, or undecidable: never counts against a hypothesis."""

NAMES = {BACKGROUND: "background", FRONT: "front side", BACK: "back side", UNKNOWN: "something unknown"}

LabelImage = npt.NDArray[np.uint8]
"""A label image, (rows, cols) uint8."""


def is_paper(labels: LabelImage) -> Mask:
    """Where a label image shows paper, either side up."""
    paper: Mask = (labels == FRONT) | (labels == BACK)
    return paper


def as_one_colour(labels: LabelImage) -> LabelImage:
    """The same label image for a sheet whose sides look alike: BACK becomes FRONT."""
    return np.asarray(np.where(labels == BACK, FRONT, labels), np.uint8)
