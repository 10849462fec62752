"""How sharp a photo is where it matters: across the outline of the paper."""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import cv2
import numpy as np

from folding_server.arrays import Floats, RgbImage

SEARCH_REACH = 0.06
"""Sheet sides on either side of an edge that are looked at: wider edges count as so wide."""
LEAST_REACH = 4.0
"""Pixels that are looked at in any case."""
PIECE = 0.15
"""Sheet sides of an edge that are looked at together: longer pieces would show how crooked the edge is."""
LEAST_CONTRAST = 14.0
"""sRGB steps between both sides of an edge that it takes to tell its width from noise."""
CLEAR_STEP = 0.08
"""Part of a side at each end that is left out, where other edges are near."""
MIDDLE_SHARE = 0.75
"""Quantile of the widths that counts: a photo that is moved is sharp along half of the edges."""
SAMPLE_STEP = 0.5
"""Pixels between the samples of a profile."""
PixelSide = tuple[Floats, Floats]
"""The ends of a straight piece of outline, (2,) each, in pixels: column and row."""


def edge_width(rgb: RgbImage, sides: Iterable[PixelSide], pixels_per_unit: float) -> float | None:
    """The width of the edges between paper and table, in sheet sides; None if none has contrast enough.

    Of each piece of a side the mean profile across it is taken. Its width is the step from table to paper divided by the
    steepest slope, which for an edge blurred by a Gaussian is 2.5 deviations, and which a soft shadow beside a sharp edge does not
    widen (the 10-90 % rise of ISO 12233, 2.56 deviations, would be). The widest quarter of the pieces is left out.
    """
    widths = [
        width
        for start, end in sides
        for piece in _pieces(start, end, pixels_per_unit)
        if (width := _width(rgb, *piece, pixels_per_unit)) is not None
    ]
    return float(np.quantile(widths, MIDDLE_SHARE)) / pixels_per_unit if widths else None


def _pieces(start: Floats, end: Floats, unit: float) -> Iterator[PixelSide]:
    """A side without its ends, cut into pieces."""
    along = np.asarray(end) - np.asarray(start)
    length = float(np.hypot(*along))
    count = max(1, round(length * (1 - 2 * CLEAR_STEP) / (PIECE * unit)))
    cuts = np.linspace(CLEAR_STEP, 1 - CLEAR_STEP, count + 1)
    if length * (cuts[1] - cuts[0]) < LEAST_REACH:
        return
    for first, last in pairwise(cuts):
        yield start + first * along, start + last * along


def _width(rgb: RgbImage, start: Floats, end: Floats, unit: float) -> float | None:
    """The width in pixels of the edge along a piece; None where table and paper are too much alike, or it leaves the picture."""
    reach = max(LEAST_REACH, SEARCH_REACH * unit)
    profile = _profile(rgb, start, end, reach)
    if profile is None:
        return None
    margin = max(1, len(profile) // 5)
    contrast = profile[-margin:].mean(axis=0) - profile[:margin].mean(axis=0)
    step = float(np.linalg.norm(contrast))
    if step < LEAST_CONTRAST:
        return None
    slope = np.gradient(profile @ (contrast / step), SAMPLE_STEP)
    return min(step / float(np.abs(slope).max()), 2 * reach)


def _profile(rgb: RgbImage, start: Floats, end: Floats, reach: float) -> Floats | None:
    """The mean colours (N, 3) across a piece, from one side of it to the other."""
    along = end - start
    length = float(np.hypot(*along))
    across = np.array([-along[1], along[0]]) / length
    at = np.linspace(0, 1, max(2, round(length)))[:, None, None]
    offsets = np.arange(-reach, reach + SAMPLE_STEP, SAMPLE_STEP)[None, :, None]
    places = (start + at * along + offsets * across).astype(np.float32)
    rows, cols = rgb.shape[:2]
    inside = (places >= 0).all() and (places[..., 0] <= cols - 1).all() and (places[..., 1] <= rows - 1).all()
    if not inside:
        return None
    seen = cv2.remap(rgb, places[..., 0], places[..., 1], cv2.INTER_LINEAR)
    return np.asarray(seen.reshape(*places.shape[:2], 3).mean(axis=0), np.float64)
