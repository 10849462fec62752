"""What moved between two photos, told by the images in between: the moving side of a fold, whatever lies where."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Float32s, Image, Mask
from folding_server.vision.colours import to_lab
from folding_server.vision.labels import BACKGROUND, UNKNOWN, is_paper
from folding_server.vision.seeing import Observation, SequenceObserver

LEAST_CHANGE, NOISY_CHANGE = 3.5, 7.0
"""Distances in Lab from which a pixel no longer shows what it did, changes of the light allowed for: in still pictures
and in noisy ones, or where a pattern drifts.
"""
USUAL = 4.0
"""So many times the usual distance is a change."""
AROUND_HANDS = 0.04
"""Sheet units around hands in which shadows and blur tell nothing."""
AT_EDGES = 0.03
"""Sheet units from the edge of the paper in which the table may show because the sheet drifted."""


@dataclass(frozen=True)
class ObservedMovement:
    """Where the paper of one photo stayed or moved on the way to the next, on that photo's grid.

    ``moved`` (rows, cols) float32 is the share, 0 to 1, of the images in between in which a pixel of the paper no
    longer shows what it did, ``turned`` of those in which it shows the other side, ``bared`` of those in which it
    shows the table; ``watched`` (rows, cols) uint8 in how many of the ``images`` no hand hid it. Where that is 0 nothing is
    known and the others are 0. All are 0 off the paper.
    """

    before: Observation
    moved: Image
    turned: Image
    bared: Image
    watched: npt.NDArray[np.uint8]
    images: int


def movement(
    observer: SequenceObserver, frame: int, pixels_per_unit: float = 64.0
) -> ObservedMovement | None:
    """What moved between photos ``frame`` - 1 and ``frame``; None if the sequence has no images in between."""
    images = observer.between(frame, pixels_per_unit)
    return disturbed(observer.frame(frame - 1, pixels_per_unit), images) if images else None


def disturbed(before: Observation, images: Sequence[Observation]) -> ObservedMovement:
    """Where the paper of a photo looks different in later images of the same grid."""
    scale = before.grid.pixels_per_unit
    paper = cv2.erode(is_paper(before.labels).astype(np.uint8), _square(AT_EDGES * scale)) > 0
    free = [paper & ~_near_hands(image) for image in images]
    bare = [image.labels == BACKGROUND for image in images]
    turned = [is_paper(image.labels) & (image.labels != before.labels) for image in images]
    moved = [_different(before, image, clear) for image, clear in zip(images, free, strict=True)]
    watched = np.asarray(np.sum(free, axis=0), np.uint8)
    shares = [_share(shown, free) for shown in (moved, turned, bare)]
    return ObservedMovement(before, shares[0], shares[1], shares[2], watched, len(images))


def _share(shown: Sequence[Mask], free: Sequence[Mask]) -> Image:
    """The share of the images in which something shows, of those in which nothing hides it."""
    times = np.sum([a & b for a, b in zip(shown, free, strict=True)], axis=0, dtype=np.float32)
    return np.asarray(times / np.maximum(np.sum(free, axis=0), 1), np.float32)


def _near_hands(image: Observation) -> Mask:
    """Where hands are, or near."""
    hidden = (image.labels == UNKNOWN).astype(np.uint8)
    return np.asarray(cv2.dilate(hidden, _square(AROUND_HANDS * image.grid.pixels_per_unit)) > 0)


def _square(reach: float) -> npt.NDArray[np.uint8]:
    """A square that reaches so many pixels from its middle, at least one."""
    side = 2 * max(1, round(reach)) + 1
    return np.ones((side, side), np.uint8)


def _different(before: Observation, image: Observation, free: Mask) -> Mask:
    """Pixels that look different; the light may have changed as a whole."""
    step = _soft(image) - _soft(before)
    if free.any():
        step = step - np.median(step[free], axis=0) * _calm(step[free])
    distance = np.linalg.norm(step, axis=-1)
    usual = float(np.median(distance[free])) if free.any() else 0.0
    return np.asarray(distance > np.clip(USUAL * usual, LEAST_CHANGE, NOISY_CHANGE))


def _calm(steps: Float32s) -> float:
    """1 if most of the pixels changed alike, as light makes them, else 0."""
    spread = np.linalg.norm(steps - np.median(steps, axis=0), axis=1)
    return float(
        np.median(spread) < NOISY_CHANGE / 2 and np.linalg.norm(np.median(steps, axis=0)) < 2 * NOISY_CHANGE
    )


def _soft(seen: Observation) -> Image:
    return to_lab(np.asarray(cv2.blur(seen.rgb, (3, 3)), np.uint8))
