"""Whether the camera stood still between photos: told by the grain of the table."""

from statistics import median

import cv2
import numpy as np

from folding_server.arrays import Image, Mask
from folding_server.vision.appearance import ColourModels
from folding_server.vision.colours import to_lab
from folding_server.vision.grid import grid_over
from folding_server.vision.photos import Photos
from folding_server.vision.pose import Pose
from folding_server.vision.segmentation import class_costs

STANDING = (1.0, 1.0)
"""Scales at which later photos may show the paper if the camera stood still."""
HAND_HELD = (0.8, 1.25)
"""The same if it may have moved."""
SAME_TABLE = 0.08
"""Correlation of the table's grain from which it is the same table in the same place."""

_COARSE = 48.0
"""Pixels per sheet unit at which two photos of the table are held against each other."""
_MOST_PHOTOS = 6
"""Photos that are looked at, spread over the sequence."""
_SHINE = 5.0
"""Pixels of blur below which light on the table is its grain."""
_LEAST_TABLE = 0.1
"""Share of the view in which both photos must show the table."""


def scales_of(photos: Photos, pose: Pose, palette: ColourModels) -> tuple[float, float]:
    """The scales, relative to frame 1, at which later photos may show the paper.

    A table without any grain cannot tell; then the camera may have moved.
    """
    later = np.arange(2, photos.frame_count + 1)
    chosen = later[:: max(1, -(-len(later) // _MOST_PHOTOS))]
    if not len(chosen):
        return STANDING
    first = _grain(photos, 1, pose, palette)
    likeness = [_correlation(first, _grain(photos, int(frame), pose, palette)) for frame in chosen]
    return STANDING if median(likeness) >= SAME_TABLE else HAND_HELD


def _grain(photos: Photos, frame: int, pose: Pose, palette: ColourModels) -> tuple[Image, Mask]:
    """How the table's lightness departs from its surroundings, and where the table is seen.

    What varies slowly is left out: shine and vignetting may belong to the camera.
    """
    grid = grid_over(_COARSE)
    rgb, seen = pose.rectify(photos.photo(frame), grid)
    lab = to_lab(rgb)
    table = seen & (class_costs(lab, grid, palette).argmin(axis=-1) == 0)
    table = cv2.erode(table.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    light = np.where(table, lab[..., 0], np.median(lab[..., 0][table]) if table.any() else 0).astype(
        np.float32
    )
    weight = cv2.GaussianBlur(table.astype(np.float32), (0, 0), _SHINE)
    smooth = cv2.GaussianBlur(light * table, (0, 0), _SHINE) / np.maximum(weight, 1e-3)
    return np.asarray(light - smooth, np.float32), table


def _correlation(first: tuple[Image, Mask], second: tuple[Image, Mask]) -> float:
    """Correlation of two grains where both show the table; 0 where neither has any."""
    both = first[1] & second[1]
    if both.mean() < _LEAST_TABLE:
        return 0.0
    a, b = first[0][both], second[0][both]
    a, b = np.clip(a - a.mean(), -12, 12), np.clip(b - b.mean(), -12, 12)
    power = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / power if power > 0.01 * len(a) else 0.0
