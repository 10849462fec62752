"""Small regions of a class: noise and blurred borders, or parts of the paper that peep out behind others."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Bools, Float32s, Image, Mask
from folding_server.vision.appearance import Look, pixel_cost
from folding_server.vision.colours import lab_to_linear, linear_to_lab
from folding_server.vision.grid import Grid
from folding_server.vision.labels import LabelImage
from folding_server.vision.mixing import CLASSES

SMALLEST_REGION = 0.0012
"""Area, in sheet units squared, of the smallest region that is believed without further evidence."""
THINNEST_REGION = 3
"""Pixels across below which a region may be nothing but the blurred border of two others, however long it is."""
EVIDENCE = 30.0
"""Nats, over all its pixels, by which a smaller region must be better explained with its class than without."""
INNER_EVIDENCE = 60.0
"""The same for a region within the other side of the paper; one within the table is never believed."""
CHANCE = 2.0
"""Nats by which a pixel may be better explained by chance."""
MOST_PER_PIXEL = 8.0
"""Nats that one pixel can give, or take, at most."""
DOUBTED_COST, CLEARLY = 8.0, 6.0
"""Cost of a pixel's class from which another one is tried, and by how many nats that must be better."""
CLASS_NEIGHBOURHOOD = 5
"""Pixels across of the neighbourhood whose classes may explain a pixel otherwise."""
RegionNumbers = npt.NDArray[np.signedinteger]


@dataclass(frozen=True)
class ClassEvidence:
    """What tells small regions: the picture in Lab, each class's cost (rows, cols, classes), light (3, rows, cols,
    3) and look.
    """

    lab: Image
    costs: Image
    lights: Float32s
    looks: tuple[Look, ...]


def with_thin_parts(labels: LabelImage, unknown: Mask, evidence: ClassEvidence) -> LabelImage:
    """Pixels of the paper that only a side which is not near explains, alone or for the most part, take that side.

    Smoothing loses parts of the other side that are a pixel or two wide.
    """
    near = _near(labels, unknown)
    own = np.take_along_axis(evidence.costs, np.minimum(labels, evidence.costs.shape[-1] - 1)[..., None], -1)
    doubtful = (own[..., 0] > DOUBTED_COST) & (near[..., 1:].max(axis=-1) > 0) & ~unknown
    rows, cols = np.nonzero(doubtful)
    if not len(rows):
        return labels
    restored = labels.copy()
    best = np.full(len(rows), CLEARLY, np.float32)
    for side in range(1, len(evidence.looks)):
        gains = _gains(rows, cols, near[rows, cols] > 0, side, evidence, least=0.5)
        better = gains > best
        restored[rows[better], cols[better]] = side
        best = np.maximum(best, gains)
    return restored


def _near(labels: LabelImage, unknown: Mask) -> npt.NDArray[np.uint8]:
    """Which classes there are around each pixel, (rows, cols, 3)."""
    own = np.stack([(labels == k) & ~unknown for k in CLASSES], axis=-1).astype(np.uint8)
    return np.asarray(
        cv2.dilate(own, np.ones((CLASS_NEIGHBOURHOOD, CLASS_NEIGHBOURHOOD), np.uint8)), np.uint8
    )


def without_specks(labels: LabelImage, unknown: Mask, grid: Grid, evidence: ClassEvidence) -> LabelImage:
    """Regions too small or too thin to believe take the class that surrounds them."""
    smallest = SMALLEST_REGION * grid.pixels_per_unit**2
    specks = np.zeros(labels.shape, bool)
    for value in range(len(evidence.looks)):
        own = ((labels == value) & ~unknown).astype(np.uint8)
        _, numbered, stats, _ = cv2.connectedComponentsWithStats(own, connectivity=4)
        thick = cv2.erode(own, np.ones((THINNEST_REGION, THINNEST_REGION), np.uint8), borderValue=1)
        thickness = np.bincount(numbered[thick > 0], minlength=len(stats))
        small = np.flatnonzero((stats[:, cv2.CC_STAT_AREA] < smallest) | (thickness == 0))
        small = small[small > 0]
        if len(small):
            believed = _believed(np.asarray(numbered, np.int32), small, value, labels, unknown, evidence)
            specks |= np.isin(numbered, np.setdiff1d(small, believed))
    return fill(labels, specks)


def fill(labels: LabelImage, holes: Mask) -> LabelImage:
    """Pixels in holes take the class of the nearest pixel outside."""
    if not holes.any() or holes.all():
        return labels
    _, nearest = cv2.distanceTransformWithLabels(
        holes.astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    values = np.zeros(int(nearest.max()) + 1, np.uint8)
    values[nearest[~holes]] = labels[~holes]
    return np.where(holes, values[nearest], labels)


def _believed(
    numbered: RegionNumbers,
    small: RegionNumbers,
    value: int,
    labels: LabelImage,
    unknown: Mask,
    evidence: ClassEvidence,
) -> RegionNumbers:
    """Those of the small regions of a class that the picture speaks for."""
    rows, cols = np.nonzero(np.isin(numbered, small))
    near = _near(labels, unknown)[rows, cols]
    near[:, value] = 0
    gains = _gains(rows, cols, near > 0, value, evidence)
    regions = numbered[rows, cols]
    total = np.bincount(regions, np.clip(gains - CHANCE, -MOST_PER_PIXEL, MOST_PER_PIXEL))
    touched = np.stack([np.bincount(regions, near[:, k]) > 0 for k in range(len(CLASSES))])
    needed = np.where(touched.sum(axis=0) > 1, EVIDENCE, np.where(touched[0], np.inf, INNER_EVIDENCE))
    return np.asarray([i for i in small if total[i] >= needed[i]], np.int32)


def _gains(
    rows: RegionNumbers,
    cols: RegionNumbers,
    near: Bools,
    value: int,
    evidence: ClassEvidence,
    least: float = 0.0,
) -> Image:
    """By how many nats each pixel (N,) is better explained with a class than by the others near it (N, 3).

    ``least`` is the least share of the pixel that the class must have.
    """
    pixels, costs = evidence.lab[rows, cols], evidence.costs[rows, cols]
    lights = evidence.lights[:, rows, cols]
    others = [k for k in range(costs.shape[-1]) if k != value]
    without = np.where(near[:, others], costs[:, others], np.inf).min(axis=-1)
    for first, second in combinations(others, 2):
        mixed = _mixed_cost(pixels, lights, first, second, evidence.looks)
        without = np.minimum(without, np.where(near[:, first] & near[:, second], mixed, np.inf))
    own = costs[:, value]
    for other in others:
        mixed = _mixed_cost(pixels, lights, other, value, evidence.looks, least)
        own = np.minimum(own, np.where(near[:, other], mixed, np.inf))
    return np.asarray(np.where(np.isfinite(without), without - own, 0.0), np.float32)


def _mixed_cost(
    pixels: Image,
    lights: Float32s,
    first: int,
    second: int,
    looks: Sequence[Look],
    least: float = 0.0,
) -> Image:
    """The cost (N,) of pixels (N, 3, Lab) as mixtures of two classes' lights (3, N, 3), the second's share at least so."""
    covariance = 0.5 * (looks[first].surfaces[0].covariance + looks[second].surfaces[0].covariance)
    step = lights[second] - lights[first]
    part = np.einsum("ij,ij->i", lab_to_linear(pixels[None])[0] - lights[first], step)
    part = np.clip(part / np.maximum(np.einsum("ij,ij->i", step, step), 1e-9), max(least, 0.03), 0.97)
    mixed = linear_to_lab(lights[first] + part[:, None] * step)
    return pixel_cost(pixels, mixed, covariance, shadows=False)
