"""Where a photo and a diagram differ: connected regions, how large they are and how far a side is off, in words."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from folding_server.arrays import ByteMask, Float32s, Indices, Mask
from folding_server.vision.labels import BACK, BACKGROUND, FRONT, NAMES, LabelImage, is_paper

PaperBox = tuple[float, float, float, float]
"""Left, upper, width, height in pixels."""

BORDER_NOISE = 0.012
"""Width, in sheet units, of disagreement that is put down to the photo; two pixels always are."""
LEAST_BORDER_NOISE = 2.0
"""The same in pixels, at least."""
INMOST = 0.8
"""Share of a region's greatest depth from which a pixel may tell its place."""
MOST_THIN = 2
"""Regions no wider than that which are told when there are no others to tell."""


@dataclass(frozen=True)
class Discrepancy:
    """One connected region in which photo and diagram differ, in sheet units and units squared.

    ``beyond`` is how far the paper of the one reaches there beyond that of the other, 0 where both have paper.
    """

    seen: int
    predicted: int
    area: float
    width: float
    place: str
    beyond: float = 0.0

    def __str__(self) -> str:
        sight, diagram = NAMES[self.seen], NAMES[self.predicted]
        size = f"area {self.area:.3f}, {self.width:.2f} wide"
        off = "long" if self.seen == BACKGROUND else "short"
        much = f"the diagram is {self.beyond:.2f} too {off}, " if self.beyond else ""
        return f"{self.place}: {much}the photo shows {sight} where the diagram has {diagram} ({size})"


def discrepancies(predicted: LabelImage, seen: LabelImage, pixels_per_unit: float) -> tuple[Discrepancy, ...]:
    """The regions wider than border noise in which photo and diagram differ, largest area first."""
    return _differences(
        predicted, seen, pixels_per_unit, max(BORDER_NOISE * pixels_per_unit, LEAST_BORDER_NOISE)
    )


def thin_discrepancies(
    predicted: LabelImage, seen: LabelImage, pixels_per_unit: float
) -> tuple[Discrepancy, ...]:
    """The largest regions, however thin: what disagrees if nothing is wider than border noise."""
    return _differences(predicted, seen, pixels_per_unit, 0.0)[:MOST_THIN]


def _differences(
    predicted: LabelImage, seen: LabelImage, pixels_per_unit: float, noise: float
) -> tuple[Discrepancy, ...]:
    """The regions more than so many pixels wide, largest area first."""
    found: list[Discrepancy] = []
    box = box_about(is_paper(predicted) | is_paper(seen))
    for here in (BACKGROUND, FRONT, BACK):
        for there in (BACKGROUND, FRONT, BACK):
            mask = ((seen == here) & (predicted == there)).astype(np.uint8)
            if here == there or not mask.any():
                continue
            far = _beyond(is_paper(predicted if here != BACKGROUND else seen), here, there)
            found += _regions(mask, far, (here, there), pixels_per_unit, box, noise)
    return tuple(sorted(found, key=lambda d: d.area, reverse=True))


def _beyond(paper: Mask, here: int, there: int) -> Float32s:
    """The distance, in pixels, of every pixel from the paper of the side that falls short; 0 if both have paper."""
    if BACKGROUND not in (here, there) or not paper.any():
        return np.zeros(paper.shape, np.float32)
    return np.asarray(cv2.distanceTransform((~paper).astype(np.uint8), cv2.DIST_L2, 5), np.float32)


def _regions(
    mask: ByteMask,
    far: Float32s,
    classes: tuple[int, int],
    pixels_per_unit: float,
    box: PaperBox,
    noise: float,
) -> list[Discrepancy]:
    depth = np.asarray(cv2.distanceTransform(mask, cv2.DIST_L2, 5), np.float32)
    count, numbered, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=4)
    rows, cols = np.nonzero(mask)
    region = np.asarray(numbered, np.int32)[rows, cols]
    deepest, farthest = np.zeros((2, count), np.float32)
    np.maximum.at(deepest, region, depth[rows, cols])
    np.maximum.at(farthest, region, far[rows, cols])
    widths = 2 * deepest - 0.5
    found = []
    for i in np.flatnonzero(widths > noise):
        pixel = _inmost(cols[region == i], rows[region == i], depth)
        area = float(stats[i, cv2.CC_STAT_AREA]) / pixels_per_unit**2
        width, beyond = float(widths[i]) / pixels_per_unit, float(farthest[i]) / pixels_per_unit
        found.append(Discrepancy(*classes, area, width, place_of(pixel, box), beyond))
    return found


def _inmost(cols: Indices, rows: Indices, depth: Float32s) -> tuple[int, int]:
    """Of a region's deepest pixels the one nearest to its middle: (column, row)."""
    deep = depth[rows, cols]
    away = np.hypot(cols - cols.mean(), rows - rows.mean())
    best = int(np.where(deep >= INMOST * deep.max(), away, np.inf).argmin())
    return int(cols[best]), int(rows[best])


def box_about(paper: Mask) -> PaperBox:
    """The box about all paper."""
    rows, cols = np.nonzero(paper)
    if not len(rows):
        return 0.0, 0.0, float(paper.shape[1]), float(paper.shape[0])
    return float(cols.min()), float(rows.min()), float(np.ptp(cols)) + 1, float(np.ptp(rows)) + 1


def place_of(pixel: Sequence[float], box: PaperBox) -> str:
    """Where a pixel (column, row) lies in the paper's box, in words."""
    left, upper, width, height = box
    column = min(2, int(3 * (pixel[0] - left) / width))
    row = min(2, int(3 * (pixel[1] - upper) / height))
    words = [("upper", "", "lower")[row], ("left", "", "right")[column]]
    return " ".join(word for word in words if word) or "centre"
