"""What moved between two photos, told by the images in between: the moving side of a fold, whatever lies where."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.vision.colours import Image, to_lab
from folding_server.vision.labels import UNKNOWN, is_paper
from folding_server.vision.mixing import Bools
from folding_server.vision.seeing import Eyes, SeenFrame

CHANGED = 9.0
"""Distance in Lab from which a pixel no longer shows what it did, changes of the light allowed for."""
AROUND_HANDS = 0.04
"""Sheet units around hands in which shadows and blur tell nothing."""


@dataclass(frozen=True)
class Movement:
    """Where the paper of one photo stayed or moved on the way to the next, on that photo's grid.

    ``moved`` (rows, cols) float32 is the share, 0 to 1, of the images in between in which a pixel of the paper no
    longer shows what it did; ``watched`` (rows, cols) uint8 in how many of them no hand hid it. Where that is 0
    nothing is known and ``moved`` is 0. Both are 0 off the paper.
    """

    before: SeenFrame
    moved: Image
    watched: npt.NDArray[np.uint8]


def movement(eyes: Eyes, frame: int, pixels_per_unit: float = 64.0) -> Movement | None:
    """What moved between photos ``frame`` - 1 and ``frame``; None if the sequence has no images in between."""
    images = eyes.between(frame, pixels_per_unit)
    return disturbed(eyes.frame(frame - 1, pixels_per_unit), images) if images else None


def disturbed(before: SeenFrame, images: Sequence[SeenFrame]) -> Movement:
    """Where the paper of a photo looks different in later images of the same grid."""
    paper = is_paper(before.labels)
    reach = 2 * max(1, round(AROUND_HANDS * before.grid.pixels_per_unit)) + 1
    changes = np.zeros(paper.shape, np.float32)
    watched = np.zeros(paper.shape, np.uint8)
    for image in images:
        hidden = cv2.dilate((image.labels == UNKNOWN).astype(np.uint8), np.ones((reach, reach), np.uint8)) > 0
        free = paper & ~hidden
        watched += free.astype(np.uint8)
        changes += free & _different(before, image, free)
    return Movement(before, np.asarray(changes / np.maximum(watched, 1), np.float32), watched)


def _different(before: SeenFrame, image: SeenFrame, free: Bools) -> Bools:
    """Pixels that look different; the light may have changed as a whole."""
    step = _soft(image) - _soft(before)
    if free.any():
        step = step - np.median(step[free], axis=0) * _calm(step[free])
    return np.asarray(np.linalg.norm(step, axis=-1) > CHANGED)


def _calm(steps: npt.NDArray[np.float32]) -> float:
    """1 if most of the pixels changed alike, as light makes them, else 0."""
    spread = np.linalg.norm(steps - np.median(steps, axis=0), axis=1)
    return float(np.median(spread) < CHANGED / 2 and np.linalg.norm(np.median(steps, axis=0)) < 2 * CHANGED)


def _soft(seen: SeenFrame) -> Image:
    return to_lab(np.asarray(cv2.blur(seen.rgb, (3, 3)), np.uint8))
