"""The table as the first photo shows it around the flat sheet: what looks the same later is table, what does not
is something else. Of use where the table has grain, lines or stains and the camera has hardly moved.
"""

from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np

from folding_server.arrays import Floats, Image, Mask
from folding_server.vision.appearance import Look, coordinates, pixel_cost, shaded_distance
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACK, FRONT, LabelImage
from folding_server.vision.surfaces import Surface, fit_surface

SHADOW_MARGIN = 0.025
"""Sheet units about the flat sheet that are left out: its shadow lies there."""
BETTER = 0.75
"""Share of the smooth surface's residual that the memory's may have, to be of use."""
STANDS = 0.7
"""The same, pixel by pixel, for the camera to stand where it stood: there it is at most 0.45 on tables with grain, and
under cameras that moved at least 0.84 (``--rendered``, ``--tutorials`` and the examples).
"""
MISPLACED_BY, MISPLACED_SAMPLES = 12, 3000
"""Pixels by which a camera has moved for certain, and samples by which it is told whether the table would show that."""
UNLIKE_TABLE, FEWEST_MARKS = 9.0, 0.004
"""Cost from which a part of the table is a mark on it, and the share of the table that marks must have."""
WIDEST_MARK, MARK_COST = 0.03, 9.0
"""Width of a mark in sheet units, and cost of its colour, at most."""
MARK_UNSEEN = 4.0
"""Cost, in nats, of saying that a mark goes on where the first photo did not show the table: as much as of saying that there is a shadow."""
STEADYING = 0.03
"""Width, in sheet units, over which departures from the memory are averaged: noise and grain even out."""
LARGEST_CAMERA_SHIFT = 3
"""Pixels by which the camera may have moved the table between photos."""


@dataclass(frozen=True)
class TableMemory:
    """``lab`` (rows, cols, 3) of the first photo, ``known`` (rows, cols) where it shows the table.

    ``marks`` is the colour of what is drawn on the table, such as the lines of a cutting mat, if anything is.
    """

    lab: Image
    known: Mask
    marks: Surface | None

    def mark_cost(self, lab: Image, grid: Grid) -> Image | None:
        """How badly each pixel fits a mark where the table was not seen, (rows, cols), in nats; None if nothing is drawn on the table."""
        if self.marks is None:
            return None
        return MARK_UNSEEN + pixel_cost(
            lab, self.marks.on(*coordinates(grid)), self.marks.covariance, shadows=False
        )

    def like_marks(self, lab: Image, labels: LabelImage, grid: Grid) -> Mask:
        """Thin parts of what was taken for a side of the paper that may as well be marks on the table."""
        thin = np.zeros(labels.shape, bool)
        if self.marks is None:
            return thin
        side = max(3, round(WIDEST_MARK * grid.pixels_per_unit)) | 1
        for value in (FRONT, BACK):
            own = (labels == value).astype(np.uint8)
            thin |= (own > 0) & (cv2.morphologyEx(own, cv2.MORPH_OPEN, np.ones((side, side), np.uint8)) == 0)
        cost = pixel_cost(lab, self.marks.on(*coordinates(grid)), self.marks.covariance)
        return np.asarray(thin & (cost < MARK_COST))


@dataclass(frozen=True)
class Recalled:
    """What one photo should show if all of it were table.

    ``expected`` (rows, cols, 3) Lab, the nearest that a pixel's neighbourhood in memory allows; ``covariance``
    (3, 3) of what is left; ``known`` (rows, cols) where the memory reaches. ``departure`` (rows, cols) is how far, in
    Lab, the picture is from the memory on the average around each pixel, 0 where nothing is known. ``stands`` says that
    pixels fit the memory so well that the camera must stand where it stood.
    """

    expected: Image
    covariance: Floats
    known: Mask
    departure: Image
    stands: bool

    def cost(self, lab: Image, shadows: bool = True) -> Image:
        """How badly each pixel fits the remembered table, in nats."""
        return pixel_cost(lab, self.expected, self.covariance, shadows)

    def strangeness(self, lab: Image) -> Image:
        """Distance in Lab from the remembered table, lit or shaded."""
        return shaded_distance(lab, self.expected)


def remember(lab: Image, seen: Mask, grid: Grid, table: Look) -> TableMemory:
    """The memory of the first photo, where the flat sheet is the unit square."""
    x, y = np.meshgrid(*coordinates(grid))
    known = (np.maximum(np.abs(x), np.abs(y)) * 1.3 > 0.5 + SHADOW_MARGIN) & seen
    marked = known & (table.cost(lab, grid) > UNLIKE_TABLE)
    drawn = marked.sum() > FEWEST_MARKS * known.sum()
    marks = fit_surface(x[marked], y[marked], lab[marked].astype(np.float64), 1) if drawn else None
    return TableMemory(lab, np.asarray(known), marks)


def recall(memory: TableMemory, lab: Image, seen: Mask, grid: Grid, table: Look) -> Recalled | None:
    """What a photo would show of the remembered table; None if that tells no more than a smooth surface."""
    known = memory.known & seen
    step = max(1, round(grid.pixels_per_unit / 48))
    x, y = np.meshgrid(*coordinates(grid))
    sample = np.zeros(known.shape, bool)
    sample[
        LARGEST_CAMERA_SHIFT:-LARGEST_CAMERA_SHIFT:step, LARGEST_CAMERA_SHIFT:-LARGEST_CAMERA_SHIFT:step
    ] = True
    sample &= known
    if sample.sum() < 200:
        return None
    xs, ys, own = x[sample], y[sample], lab[sample].astype(np.float64)
    shift, light = _registered(memory.lab, sample, xs, ys, own)
    moved = np.roll(memory.lab, shift, axis=(0, 1)) + light.on(*coordinates(grid))
    expected = np.clip(lab, cv2.erode(moved, np.ones((3, 3))), cv2.dilate(moved, np.ones((3, 3))))
    rest = own - expected[sample]
    left, pixelwise, smooth = (
        float(np.median(np.linalg.norm(r, axis=1)))
        for r in (rest, own - moved[sample], own - table.surfaces[0].at(xs, ys))
    )
    if left > BETTER * smooth:
        return None
    usual = np.linalg.norm(rest, axis=1) < 3 * max(left, 1.0)
    covariance = rest[usual].T @ rest[usual] / max(int(usual.sum()), 1)
    departure = _departure(lab - moved, known, grid)
    stands = pixelwise < STANDS * min(smooth, _misplaced(memory.lab, sample, xs, ys, own))
    return Recalled(np.asarray(expected, np.float32), covariance, known, departure, stands)


def _misplaced(remembered: Image, sample: Mask, x: Floats, y: Floats, own: Floats) -> float:
    """How badly, in Lab, the memory fits at a place where the camera does not stand: 0 on a table that looks alike everywhere."""
    rows, cols = np.nonzero(sample)
    step = max(1, len(rows) // MISPLACED_SAMPLES)
    rows, cols, x, y, own = rows[::step], cols[::step], x[::step], y[::step], own[::step]
    left = []
    for down, right in ((MISPLACED_BY, MISPLACED_BY), (-MISPLACED_BY, MISPLACED_BY)):
        there = (rows - down).clip(0, sample.shape[0] - 1), (cols - right).clip(0, sample.shape[1] - 1)
        difference = own - remembered[there]
        light = fit_surface(x, y, difference, 2)
        left.append(float(np.median(np.linalg.norm(difference - light.at(x, y), axis=1))))
    return min(left)


def _departure(difference: Image, known: Mask, grid: Grid) -> Image:
    """The length of the mean difference (rows, cols, 3) around each known pixel."""
    side = max(3, round(STEADYING * grid.pixels_per_unit)) | 1
    weight = known.astype(np.float32)
    total = cv2.blur(difference * weight[..., None], (side, side))
    share = np.maximum(cv2.blur(weight, (side, side)), 1e-3)
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", total, total)) / share * weight, np.float32)


def _registered(
    remembered: Image, sample: Mask, x: Floats, y: Floats, own: Floats
) -> tuple[tuple[int, int], Surface]:
    """The whole shift (rows, cols) and change of light with which memory explains samples (N, 3) best."""
    rows, cols = np.nonzero(sample)
    best: tuple[float, tuple[int, int], Floats] | None = None
    for down, right in product(range(-LARGEST_CAMERA_SHIFT, LARGEST_CAMERA_SHIFT + 1), repeat=2):
        difference = own - remembered[rows - down, cols - right]
        spread = float(np.median(np.linalg.norm(difference - np.median(difference, axis=0), axis=1)))
        if best is None or spread < best[0]:
            best = spread, (down, right), difference
    assert best is not None
    return best[1], fit_surface(x, y, best[2], 2)
