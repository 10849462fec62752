"""Border pixels show two classes at once: which two, and how much of each, told by their light."""

from itertools import combinations

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.vision.appearance import Look, coordinates
from folding_server.vision.colours import Image, lab_to_linear, to_linear
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACK, BACKGROUND, FRONT, Labels
from folding_server.vision.photos import Picture

Bools = npt.NDArray[np.bool_]

CLASSES = (BACKGROUND, FRONT, BACK)
BAND = 5
"""Pixels across of the neighbourhood in which a class may be part of a mixture."""
DEEPEST_CAST = 0.3
"""Least share of its light that a shadow between two layers leaves the lower one."""
_OTHER_PAIR = 0.02
"""Linear light by which a mixture of two other classes must fit better than one that has the pixel's own."""
_NEAR, _FAR = 1e-3, 1e-6
"""Weight of the class's light far away, and of what the palette says, against its light close by."""


def mixtures(labels: Labels, unknown: Bools, rgb: Picture, lights: npt.NDArray[np.float32]) -> Image:
    """Shares (rows, cols, 3) of table, front and back; border pixels are split between two of them.

    ``lights`` (3, rows, cols, 3) is what :func:`class_lights` says of them.
    """
    shares = np.stack([labels == value for value in CLASSES], axis=-1).astype(np.float32)
    spread = cv2.dilate(shares * (~unknown)[..., None], np.ones((BAND, BAND), np.uint8))
    rows, cols = np.nonzero((spread.sum(axis=-1) > 1.5) & ~unknown)
    if len(rows):
        pixels = to_linear(rgb)[rows, cols]
        shares[rows, cols] = _split(pixels, lights[:, rows, cols], spread[rows, cols] > 0, labels[rows, cols])
    return shares


def class_lights(
    labels: Labels, unknown: Bools, rgb: Picture, looks: tuple[Look, ...], grid: Grid
) -> npt.NDArray[np.float32]:
    """The linear light (3, rows, cols, 3) that each class shows around each pixel.

    ``looks`` say what light to expect of a class where none of it is near.
    """
    light = to_linear(rgb)
    expected = [lab_to_linear(look.surfaces[0].on(*coordinates(grid))) for look in looks]
    expected += [np.zeros_like(light)] * (len(CLASSES) - len(expected))
    owns = [(labels == value) & ~unknown for value in CLASSES]
    return np.stack([_local_mean(light, own, far) for own, far in zip(owns, expected, strict=True)])


def _split(
    pixels: Image, means: npt.NDArray[np.float32], near: Bools, own: Labels
) -> npt.NDArray[np.float32]:
    """Shares (N, 3) of pixels (N, 3) as mixtures of the two near classes that explain them best."""
    count = len(pixels)
    best = np.full(count, np.inf, np.float32)
    shares = np.zeros((count, len(CLASSES)), np.float32)
    for first, second in combinations(range(len(CLASSES)), 2):
        ends = _shaded(pixels, means, ~near[:, 0], first, second)
        part, residual = _between(pixels, *ends)
        cost = residual + _OTHER_PAIR * ((own != first) & (own != second))
        better = near[:, first] & near[:, second] & (cost < best)
        best = np.where(better, cost, best)
        shares[better] = 0
        shares[better, first], shares[better, second] = 1 - part[better], part[better]
    lone = ~np.isfinite(best)
    shares[lone, own[lone]] = 1
    return shares


def _between(pixels: Image, first: Image, second: Image) -> tuple[Image, Image]:
    """How far from the first light to the second each pixel lies, 0 to 1, and how far beside, both (N,)."""
    step = second - first
    part = np.einsum("ij,ij->i", pixels - first, step) / np.maximum(np.einsum("ij,ij->i", step, step), 1e-9)
    part = np.clip(part, 0, 1).astype(np.float32)
    beside = np.linalg.norm(pixels - first - part[:, None] * step, axis=-1)
    return part, np.asarray(beside, np.float32)


def _shaded(
    pixels: Image, means: npt.NDArray[np.float32], inner: Bools, first: int, second: int
) -> tuple[Image, Image]:
    """The lights of two classes; within the paper, where one layer may shade the other, as dark as fits."""
    ends = []
    for mean in (means[first], means[second]):
        share = np.einsum("ij,ij->i", pixels, mean) / np.maximum(np.einsum("ij,ij->i", mean, mean), 1e-9)
        share = np.where(inner, np.clip(share, DEEPEST_CAST, 1.0), 1.0)
        ends.append((mean * share[:, None]).astype(np.float32))
    return ends[0], ends[1]


def _local_mean(light: Image, own: Bools, expected: Image) -> Image:
    """Mean light of a class's own pixels, away from its borders, in the neighbourhood of each pixel."""
    core = cv2.erode(own.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(np.float32)
    weighted = np.dstack([light * core[..., None], core])
    total = np.asarray(cv2.blur(weighted, (15, 15)), np.float32)
    wide = cv2.blur(cv2.resize(weighted, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA), (25, 25))
    total += _NEAR * np.asarray(cv2.resize(wide, (light.shape[1], light.shape[0])), np.float32)
    total += _FAR * np.dstack([expected, np.ones(own.shape, np.float32)])
    return np.asarray(total[..., :3] / total[..., 3:], np.float32)
