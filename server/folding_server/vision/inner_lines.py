"""Creases and layer edges inside the paper: faint lines that no class border shows."""

import cv2
import numpy as np

from folding_server.vision.colours import Image
from folding_server.vision.photos import Picture
from folding_server.vision.segmentation import Bools

FULL_STRENGTH = 12.0
"""Grey levels (of 255) beyond the paper's grain at which a line counts fully."""
RIM = 0.02
"""Sheet units along the borders of a class that are left out: they are blurred, and shadows lie there."""

_NEAR, _FAR = 0.006, 0.03


def inner_lines(rgb: Picture, shares: Image, unknown: Bools, pixels_per_unit: float) -> Image:
    """Strength, 0 to 1, of lines within one side of the paper, (rows, cols).

    A line is a ridge, darker or lighter than both its sides, or a step between them.
    """
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    strength = np.zeros_like(grey)
    for side in (1, 2):
        own = ((shares[..., side] > 0.9) & ~unknown).astype(np.uint8)
        if own.any():
            strength += _lines_within(grey, own, pixels_per_unit)
    return strength


def _lines_within(grey: Image, own: cv2.typing.MatLike, pixels_per_unit: float) -> Image:
    near, far = max(0.7, _NEAR * pixels_per_unit), _FAR * pixels_per_unit
    fine, coarse = _blur_within(grey, own, near), _blur_within(grey, own, far)
    slope = cv2.magnitude(cv2.Sobel(fine, cv2.CV_32F, 1, 0), cv2.Sobel(fine, cv2.CV_32F, 0, 1)) / 8
    raw = np.abs(fine - coarse) + slope * near
    rim = 2 * max(1, round(RIM * pixels_per_unit)) + 1
    core = cv2.erode(own, np.ones((rim, rim), np.uint8)) > 0
    if not core.any():
        return np.zeros_like(grey)
    grain = 2.5 * float(np.median(raw[core]))
    return np.asarray(np.where(core, np.clip((raw - grain) / FULL_STRENGTH, 0, 1), 0), np.float32)


def _blur_within(grey: Image, own: cv2.typing.MatLike, sigma: float) -> Image:
    """Gaussian blur that takes only a class's own pixels into account."""
    weight = own.astype(np.float32)
    total = cv2.GaussianBlur(grey * weight, (0, 0), sigma)
    return np.asarray(total / np.maximum(cv2.GaussianBlur(weight, (0, 0), sigma), 1e-3), np.float32)
