"""Whether a picture is drawn: no photo is perfectly even over most of it."""

import numpy as np

from folding_server.arrays import RgbImage

DRAWN = 0.9
"""Share of even pixels that a drawing has. Photos of a table burnt out to white, at 400 pixels, come to 0.8."""
FEW_COLORS, COLOR_BITS = 4, 6
"""So many colours, told apart by so many bits a channel, cover COLORED of a drawing: paper, two sides, lines."""
COLORED = 0.85
"""Light falls off across a photo, so that even its even parts have many colours."""
MIDDLE_SIDE = 800
"""Pixels of the longest side of the part in the middle that is looked at, as it was taken: scaling down takes the grain away."""


def even_share(rgb: RgbImage) -> float:
    """The share of pixels that are as their right and lower neighbours, 0 to 1."""
    levels = _middle(rgb).astype(np.int16)
    right = np.abs(np.diff(levels, axis=1)).max(axis=2)[:-1]
    below = np.abs(np.diff(levels, axis=0)).max(axis=2)[:, :-1]
    return float(((right == 0) & (below == 0)).mean())


def is_drawing(rgb: RgbImage) -> bool:
    """Whether a picture is a drawing, such as a step of a diagram."""
    return even_share(rgb) >= DRAWN and _share_of_few_colors(_middle(rgb)) >= COLORED


def _middle(rgb: RgbImage) -> RgbImage:
    """The part in the middle that is looked at."""
    rows, cols = (max(0, (side - MIDDLE_SIDE) // 2) for side in rgb.shape[:2])
    return rgb[rows : rows + MIDDLE_SIDE, cols : cols + MIDDLE_SIDE]


def _share_of_few_colors(rgb: RgbImage) -> float:
    """The share of pixels that have one of the few most frequent colours."""
    coarse = (rgb >> (8 - COLOR_BITS)).astype(np.int32)
    numbers = (coarse[..., 0] << 2 * COLOR_BITS) + (coarse[..., 1] << COLOR_BITS) + coarse[..., 2]
    counts = np.sort(np.unique(numbers, return_counts=True)[1])
    return float(counts[-FEW_COLORS:].sum()) / numbers.size
