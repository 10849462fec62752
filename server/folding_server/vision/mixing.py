"""Border pixels show two classes at once: which two, and how much of each, told by their light."""

from itertools import combinations

import cv2
import numpy as np

from folding_server.arrays import Bools, Float32s, Floats, Image, Mask, RgbImage
from folding_server.vision.appearance import Look, coordinates
from folding_server.vision.colours import lab_to_linear, linear_from_table
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACK, BACKGROUND, FRONT, LabelImage

CLASSES = (BACKGROUND, FRONT, BACK)
BAND = 5
"""Pixels across of the neighbourhood in which a class may be part of a mixture."""
DEEPEST_CAST = 0.3
"""Least share of its light that a shadow between two layers leaves the lower one."""
_OTHER_PAIR = 0.02
"""Linear light by which a mixture of two other classes must fit better than one that has the pixel's own."""
FAR_NEIGHBOURHOOD, TREND_NEIGHBOURHOOD = 15, 9
"""Pixels across of the neighbourhood from which light is taken where none of the class is close by, and of that in which
it is seen to grow dark towards a border.
"""
MOST_DARKENED, STEEPER = 0.8, 1.5
"""The rim of a class is believed to be no darker than so, against what lies behind it; from there to the border the light
falls by this power of it.
"""
_BEHIND, _WIDE, _ELSEWHERE = 1e-2, 1e-3, 1e-6
"""Weight of the class's light farther away, far away, and of what the palette says, against its light close by."""
_STIFF, _RIGID = 0.02, 1e3
"""Squared light that a whole shadow within the paper, and beside it, must explain to be believed."""
_TINY = 1e-6
"""Keeps divisions finite."""


def mixtures(labels: LabelImage, unknown: Mask, rgb: RgbImage, lights: Float32s) -> Image:
    """Shares (rows, cols, 3) of table, front and back; border pixels are split between two of them.

    ``lights`` (3, rows, cols, 3) is what :func:`class_lights` says of them.
    """
    shares = np.stack([labels == value for value in CLASSES], axis=-1).astype(np.float32)
    spread = cv2.dilate(shares * (~unknown)[..., None], np.ones((BAND, BAND), np.uint8))
    rows, cols = np.nonzero((spread.sum(axis=-1) > 1.5) & ~unknown)
    if len(rows):
        pixels = linear_from_table(rgb)[rows, cols]
        shares[rows, cols] = _split(pixels, lights[:, rows, cols], spread[rows, cols] > 0, labels[rows, cols])
    return shares


def class_lights(
    labels: LabelImage, unknown: Mask, rgb: RgbImage, looks: tuple[Look, ...], grid: Grid, mixed: int = 1
) -> Float32s:
    """The linear light (3, rows, cols, 3) that each class shows around each pixel.

    ``looks`` say what light to expect of a class where none of it is near; ``mixed`` is how many pixels on either side
    of a border show some of both classes.
    """
    light = linear_from_table(rgb)
    expected = [lab_to_linear(look.surfaces[0].on(*coordinates(grid))) for look in looks]
    expected += [np.zeros_like(light)] * (len(CLASSES) - len(expected))
    owns = [(labels == value) & ~unknown for value in CLASSES]
    return np.stack([_local_mean(light, own, far, mixed) for own, far in zip(owns, expected, strict=True)])


def _split(pixels: Image, means: Float32s, near: Bools, own: LabelImage) -> Float32s:
    """Shares (N, 3) of pixels (N, 3) as mixtures of the two near classes that explain them best."""
    count = len(pixels)
    best = np.full(count, np.inf, np.float32)
    shares = np.zeros((count, len(CLASSES)), np.float32)
    for first, second in combinations(range(len(CLASSES)), 2):
        part, residual = _between(pixels, means[first], means[second], ~near[:, 0])
        cost = residual + _OTHER_PAIR * ((own != first) & (own != second))
        better = near[:, first] & near[:, second] & (cost < best)
        best = np.where(better, cost, best)
        shares[better] = 0
        shares[better, first], shares[better, second] = 1 - part[better], part[better]
    lone = ~np.isfinite(best)
    shares[lone, own[lone]] = 1
    return shares


def _between(pixels: Image, first: Image, second: Image, inner: Bools) -> tuple[Image, Image]:
    """How far from the first light to the second each pixel lies, 0 to 1, and how far beside, both (N,).

    Within the paper (``inner``), where one layer may shade the other, mixtures may be darker as a whole. Lights of nearly
    one hue explain the same by less of the brighter: the least shadow is believed.
    """
    aa, ab, bb = _product(first, first), _product(first, second), _product(second, second)
    ax, bx = _product(first, pixels), _product(second, pixels)
    stiff = np.where(inner, _STIFF, _RIGID)
    aa, ab, bb, ax, bx = (value + stiff for value in (aa, ab, bb, ax, bx))
    det = np.maximum(aa * bb - ab * ab, _TINY)
    a, b = (bb * ax - ab * bx) / det, (aa * bx - ab * ax) / det
    part = np.clip(b / np.maximum(a + b, _TINY), 0, 1)
    light = np.where(inner, np.clip(a + b, DEEPEST_CAST, 1.0), 1.0)
    mixed = light[:, None] * (first + part[:, None] * (second - first))
    return part.astype(np.float32), np.linalg.norm(pixels - mixed, axis=-1).astype(np.float32)


def _product(first: Image, second: Image) -> Floats:
    """The scalar product of each two lights (N, 3), (N,)."""
    return np.asarray(np.einsum("ij,ij->i", first, second), np.float64)


def _local_mean(light: Image, own: Mask, expected: Image, mixed: int) -> Image:
    """Mean light of a class's own pixels in the neighbourhood of each pixel, those close by before those farther away.

    Beside a border it is what the last pixels before it show, darkened on as they are against those behind them.
    """
    close, core = (_eroded(own, reach) for reach in (mixed, mixed + 1))
    inner = _weighted(light, core)
    far = np.asarray(cv2.blur(inner, (FAR_NEIGHBOURHOOD, FAR_NEIGHBOURHOOD)), np.float32)
    near = np.asarray(cv2.blur(_weighted(light, close), (BAND, BAND)), np.float32)
    near[..., :3] *= _darkening(light, close - core, core)[..., None]
    total = near + _BEHIND * far
    wide = cv2.resize(inner, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    wide = cv2.resize(cv2.blur(wide, (25, 25)), (light.shape[1], light.shape[0]))
    total += _WIDE * np.asarray(wide, np.float32)
    total += _ELSEWHERE * np.dstack([expected, np.ones(own.shape, np.float32)])
    return np.asarray(total[..., :3] / total[..., 3:], np.float32)


def _darkening(light: Image, rim: Image, core: Image) -> Image:
    """By how much to darken the rim of a class at its border, (rows, cols) up to 1: the shadow of what lies beside it grows
    on from what the rim shows against what lies behind it.
    """
    grey = light.mean(axis=-1)
    rim_light, rim_there = _mean_over(grey, rim)
    core_light, core_there = _mean_over(grey, core)
    ratio = np.clip(rim_light / np.maximum(core_light, _TINY), MOST_DARKENED, 1.0) ** STEEPER
    return np.asarray(
        cv2.blur(np.where(rim_there & core_there, ratio, np.float32(1)), (BAND, BAND)), np.float32
    )


def _mean_over(grey: Image, part: Image) -> tuple[Image, Mask]:
    """The mean light (rows, cols) of a part of the class around each pixel, and where there is any."""
    count = np.asarray(cv2.blur(part, (TREND_NEIGHBOURHOOD, TREND_NEIGHBOURHOOD)), np.float32)
    total = np.asarray(cv2.blur(grey * part, (TREND_NEIGHBOURHOOD, TREND_NEIGHBOURHOOD)), np.float32)
    return np.asarray(total / np.maximum(count, _TINY), np.float32), count > _TINY


def _eroded(own: Mask, reach: int) -> Image:
    kernel = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    return np.asarray(cv2.erode(own.astype(np.uint8), kernel), np.float32)


def _weighted(light: Image, weight: Image) -> Image:
    """Light where there is weight, with the weight as a fourth plane, (rows, cols, 4)."""
    return np.dstack([light * weight[..., None], weight])
