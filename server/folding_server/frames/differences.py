"""What differs between two small pictures of one scene, whatever the light and the noise do."""

from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

Small = NDArray[np.float32]
"""A small RGB picture, float32, shape (height, width, 3), values 0 to 255."""
Mask = NDArray[np.bool_]

LEAST_STEP = 10.0
MOST_STEP = 28.0
_NOISE_FACTOR = 6.0
_DARK = 12.0
_SPARSE = 3


def soften(image: NDArray[np.uint8]) -> Small:
    """The picture as floats, with the finest grain smoothed away."""
    return cast("Small", cv2.blur(image.astype(np.float32), (3, 3)))


def difference(before: Small, after: Small, least_step: float = LEAST_STEP) -> Mask:
    """Where two pictures differ by more than light, noise and `least_step`; shape (height, width).

    The light may change as a whole: each channel is first brought to one level by its median ratio, which is
    right as long as half of the picture has not changed. The noise is read off the median difference.
    """
    sparse = (slice(None, None, _SPARSE), slice(None, None, _SPARSE))
    ratio = (after[sparse] + _DARK) / (before[sparse] + _DARK)
    gain = np.median(ratio.reshape(-1, 3), axis=0).astype(np.float32)
    step = _widest(np.abs(after - before * gain - _DARK * (gain - 1)))
    noise = 1.4826 * float(np.median(step[sparse]))
    return step > min(max(_NOISE_FACTOR * noise, least_step), MOST_STEP)


def _widest(steps: NDArray[np.float32]) -> NDArray[np.float32]:
    """The largest of the three channels, shape without the last axis."""
    return np.maximum(np.maximum(steps[..., 0], steps[..., 1]), steps[..., 2])


def regions(mask: Mask, least: float, ring: Mask | None = None) -> int:
    """How many separate regions of at least `least` pixels `mask` has, thin lines not counted.

    With `ring`, regions that reach into it are not counted: what comes in over the border is a hand.
    """
    solid = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    joined = cv2.morphologyEx(solid, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(joined, connectivity=8)
    reaching = set(np.unique(labels[ring])) if ring is not None else set()
    return sum(
        1 for label in range(1, count) if stats[label, cv2.CC_STAT_AREA] >= least and label not in reaching
    )


def border_ring(shape: tuple[int, ...]) -> Mask:
    """The outermost twentieth of a picture, at least 3 pixels wide."""
    height, width = shape[:2]
    wide = max(3, min(height, width) // 20)
    ring = np.ones((height, width), np.bool_)
    ring[wide:-wide, wide:-wide] = False
    return ring


def usual(samples: NDArray[np.float32], within: float = LEAST_STEP) -> NDArray[np.float32]:
    """The value that each pixel has most often, shape (pixels, 3), from samples of shape (count, pixels, 3).

    A bare table is the same each time it is seen; hands and sleeves hardly ever are.
    """
    votes = np.stack([(_widest(np.abs(samples - one)) < within).sum(axis=0) for one in samples])
    winners: NDArray[np.float32] = samples[votes.argmax(axis=0), np.arange(samples.shape[1])]
    return winners
