"""What differs between two small pictures of one scene, whatever the light and the noise do."""

from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from folding_server.arrays import Float32s, Mask, RgbImage

SmallImage = Float32s
"""A small RGB picture, float32, shape (height, width, 3), values 0 to 255."""

LEAST_STEP = 10.0
MOST_STEP = 28.0
NUDGED_PART = 0.04
"""The furthest that a nudge moves a corner of the picture, as a part of its longer side."""
_ROUNDS = 40
_NOISE_FACTOR = 6.0
_DARK = 12.0
_SPARSE = 3


def soften(image: RgbImage) -> SmallImage:
    """The picture as floats, with the finest grain smoothed away."""
    return cast("SmallImage", cv2.blur(image.astype(np.float32), (3, 3)))


def changed_pixels(before: SmallImage, after: SmallImage, least_step: float = LEAST_STEP) -> Mask:
    """Where two pictures differ by more than light, noise and `least_step`; shape (height, width).

    The light may change as a whole: each channel is first brought to one level by its median ratio, which is
    right as long as half of the picture has not changed. The noise is read off the median difference.
    """
    sparse = (slice(None, None, _SPARSE), slice(None, None, _SPARSE))
    gain = _gain(before[sparse], after[sparse])
    step = _widest(np.abs(after - _in_light(before, gain)))
    noise = 1.4826 * float(np.median(step[sparse]))
    return step > min(max(_NOISE_FACTOR * noise, least_step), MOST_STEP)


def _widest(steps: Float32s) -> Float32s:
    """The largest of the three channels, shape without the last axis."""
    return np.maximum(np.maximum(steps[..., 0], steps[..., 1]), steps[..., 2])


def solid_area(mask: Mask, least: float, ring: Mask | None = None) -> int:
    """The pixels of `mask` in regions of at least `least` pixels, thin lines not counted.

    With `ring`, regions that reach into it are not counted: what comes in over the border is a hand.
    """
    labels, areas = _pieces(mask)
    outer = set(np.unique(labels[ring]).tolist()) if ring is not None else set()
    counted = (area for label, area in enumerate(areas) if label > 0 and label not in outer)
    return int(sum(area for area in counted if area >= least))


def reaching(mask: Mask, ring: Mask) -> Mask:
    """The regions of `mask` that reach into `ring`, thin lines not counted."""
    labels, _ = _pieces(mask)
    found: Mask = np.isin(labels, np.setdiff1d(labels[ring], [0]))
    return found


def _pieces(mask: Mask) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The number of the region of each pixel, 0 for none, and the area of each; thin lines are left out."""
    solid = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    joined = cv2.morphologyEx(solid, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
    _, labels, stats, _ = cv2.connectedComponentsWithStats(joined, connectivity=8)
    return np.asarray(labels, np.int32), np.asarray(stats[:, cv2.CC_STAT_AREA], np.int32)


def nudged_back(before: SmallImage, after: SmallImage, shown: Mask | None = None) -> SmallImage | None:
    """`after` moved onto `before` as well as a small motion of the whole picture can; None if none fits.

    The motion is rigid, found by the enhanced correlation coefficient (Evangelidis and Psarakis, 2008) of
    what is `shown`. What it brings in over the border is taken from `before`.
    """
    height, width = before.shape[:2]
    start = np.eye(2, 3, dtype=np.float32)
    enough = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, _ROUNDS, 1e-4)
    mask = None if shown is None else shown.astype(np.uint8)
    try:
        _, motion = cv2.findTransformECC(
            _grey(before), _grey(after), start, cv2.MOTION_EUCLIDEAN, enough, mask, 5
        )
    except cv2.error:
        return None
    corners = np.array([[0, 0, 1], [width, 0, 1], [0, height, 1], [width, height, 1]], np.float32)
    moved = np.abs(corners @ motion.T - corners[:, :2]).max()
    if moved > NUDGED_PART * max(height, width):
        return None
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = (width, height)
    back = cv2.warpAffine(after, motion, size, before.copy(), flags, cv2.BORDER_TRANSPARENT)
    return cast("SmallImage", back)


def _grey(picture: SmallImage) -> Float32s:
    return np.asarray(picture.mean(axis=2), np.float32)


def border_ring(shape: tuple[int, ...]) -> Mask:
    """The outermost twentieth of a picture, at least 3 pixels wide."""
    height, width = shape[:2]
    wide = max(3, min(height, width) // 20)
    ring = np.ones((height, width), np.bool_)
    ring[wide:-wide, wide:-wide] = False
    return ring


def usual(samples: Float32s, within: float = LEAST_STEP) -> Float32s:
    """The value that each pixel has most often, shape (pixels, 3), from samples of shape (count, pixels, 3).

    A bare table is the same each time it is seen, once all samples are brought to one level of light; hands
    and sleeves hardly ever are.
    """
    typical = np.median(samples, axis=0)
    levelled = np.stack([_in_light(sample, _gain(sample, typical)) for sample in samples])
    votes = np.stack([(_widest(np.abs(levelled - one)) < within).sum(axis=0) for one in levelled])
    winners: Float32s = levelled[votes.argmax(axis=0), np.arange(samples.shape[1])]
    return winners


def _gain(before: SmallImage, after: SmallImage) -> Float32s:
    """How much brighter each channel has become: the median ratio, the darkest pixels counting less."""
    ratio = (after + _DARK) / (before + _DARK)
    return cast("Float32s", np.median(ratio.reshape(-1, 3), axis=0).astype(np.float32))


def _in_light(picture: SmallImage, gain: Float32s) -> SmallImage:
    """The picture in another light."""
    return cast("SmallImage", picture * gain + _DARK * (gain - 1))
