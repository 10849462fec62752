"""A rectified photo to labels: table, front, back, unknown, with outlines that are right below the pixel."""

from dataclasses import dataclass
from functools import reduce

import cv2
import numpy as np

from folding_server.arrays import Image, Mask, RgbImage
from folding_server.vision.adapting import adapt
from folding_server.vision.appearance import ColourModels
from folding_server.vision.colours import to_lab
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACKGROUND, LabelImage, is_paper
from folding_server.vision.mixing import class_lights, mixtures
from folding_server.vision.obstacles import ObstacleView, fingertips, obstacles, sleeves
from folding_server.vision.specks import SMALLEST_REGION, ClassEvidence, with_thin_parts, without_specks
from folding_server.vision.table_memory import TableMemory, recall

SURROUNDED = 0.9
"""The share of a piece's rim that is unknown if what hides the paper is all around it."""
SMOOTHING = 3.5
"""How strongly neighbours pull towards the same class."""


@dataclass(frozen=True)
class Segmented:
    """``shares`` (rows, cols, 3): how much of each pixel is table, front, back, 0 where it is ``unknown`` (rows, cols);
    ``clearness`` (rows, cols), 0 to 1: how much better than the others a pixel's class explains it. ``same_table`` says that
    the table has the grain and marks that it had in the first photo, where it had them.
    """

    shares: Image
    unknown: Mask
    clearness: Image
    same_table: bool


def smoothed_lab(rgb: RgbImage) -> Image:
    """The picture in Lab, its finest noise smoothed away."""
    return to_lab(np.asarray(cv2.GaussianBlur(rgb, (3, 3), 0), np.uint8))


def segment(
    rgb: RgbImage,
    seen: Mask,
    grid: Grid,
    palette: ColourModels,
    memory: TableMemory | None = None,
    *,
    mixed: int = 1,
) -> Segmented:
    """Segment a rectified photo whose pixels within the photo are ``seen``; ``mixed`` is how many pixels on either side of a
    border show some of both classes.
    """
    lab = smoothed_lab(rgb)
    tuned = adapt(lab, seen, grid, palette)
    recalled = None if memory is None else recall(memory, lab, seen, grid, tuned.table)
    costs = class_costs(lab, grid, tuned)
    marks = None if memory is None else memory.mark_cost(lab, grid)
    if marks is not None:
        costs[..., 0] = np.minimum(costs[..., 0], marks)
    if recalled is not None:
        costs[..., 0] = np.where(recalled.known, recalled.cost(lab), costs[..., 0])
    hidden = obstacles(ObstacleView(lab, rgb, costs, seen, grid, tuned, recalled))
    unknown = hidden | ~seen
    shares = _smooth(costs)
    labels = shares.argmax(axis=-1).astype(np.uint8)
    if memory is not None:
        labels[memory.like_marks(lab, labels, grid)] = BACKGROUND
    unknown |= fingertips(np.asarray((labels == BACKGROUND) & ~unknown), hidden, grid)
    unknown |= sleeves(labels, unknown, seen, grid)
    lights = class_lights(labels, unknown, rgb, tuned.looks, grid, mixed)
    evidence = ClassEvidence(lab, costs, lights, tuned.looks)
    labels = with_thin_parts(labels, unknown, evidence)
    if memory is not None:
        labels[memory.like_marks(lab, labels, grid)] = BACKGROUND
    labels = without_specks(labels, unknown, grid, evidence)
    unknown |= _one_sheet(labels, unknown, grid)
    shares = mixtures(labels, unknown, rgb, lights)
    shares[unknown] = 0
    return Segmented(shares, unknown, _clearness(costs, labels), recalled is not None and recalled.stands)


def _clearness(costs: Image, labels: LabelImage) -> Image:
    """By how much the class of each pixel is more probable than the next, as its colour alone tells."""
    chosen = np.take_along_axis(costs, labels[..., None].astype(np.intp), -1)
    others = np.where(np.arange(costs.shape[-1]) == labels[..., None], np.float32(np.inf), costs)
    return np.asarray(np.tanh(np.clip(others.min(axis=-1) - chosen[..., 0], 0, 20) / 2), np.float32)


def class_costs(lab: Image, grid: Grid, palette: ColourModels) -> Image:
    """The cost of each class at each pixel, (rows, cols, 2 or 3)."""
    return np.stack([look.cost(lab, grid) for look in palette.looks], axis=-1)


def _smooth(costs: Image) -> Image:
    """Mean field of a Potts model on the costs: the share of each class, (rows, cols, classes)."""
    pull = np.asarray(-0.4 * np.minimum(costs, 25.0), np.float32)
    shares = _softmax(pull)
    for _ in range(3):
        shares = _softmax(pull + SMOOTHING * np.asarray(cv2.blur(shares, (5, 5)), np.float32))
    return shares


def _softmax(energies: Image) -> Image:
    planes = [energies[..., k] for k in range(energies.shape[-1])]
    highest = reduce(np.maximum, planes)
    raised = [np.exp(plane - highest) for plane in planes]
    total = reduce(np.add, raised)
    return np.stack([plane / total for plane in raised], axis=-1)


def _one_sheet(labels: LabelImage, unknown: Mask, grid: Grid) -> Mask:
    """Paper colour that is no sheet: not joined to the largest piece, even under what hides it, or a speck there, or a part
    of a sleeve.
    """
    paper = is_paper(labels) & ~unknown
    reach = max(3, round(0.06 * grid.pixels_per_unit)) | 1
    joined = cv2.dilate((paper | unknown).astype(np.uint8), np.ones((reach, reach), np.uint8))
    _, numbered = cv2.connectedComponents(joined, connectivity=4)
    if not paper.any():
        return np.zeros(labels.shape, bool)
    sizes = np.bincount(numbered[paper])
    apart = numbered != int(sizes.argmax())
    _, pieces, stats, _ = cv2.connectedComponentsWithStats(paper.astype(np.uint8))
    areas = stats[:, cv2.CC_STAT_AREA]
    none = _specks_beside(paper, pieces, areas, unknown, grid) | _hemmed_in(paper, pieces, areas, unknown)
    return np.asarray(paper & (apart | none[pieces]))


def _hemmed_in(paper: Mask, numbered: cv2.typing.MatLike, areas: cv2.typing.MatLike, unknown: Mask) -> Mask:
    """Which of the numbered pieces, other than the largest, are nearly surrounded by what is unknown."""
    count = len(areas)
    around = cv2.dilate(numbered.astype(np.uint16), np.ones((3, 3), np.uint8)) * ~paper
    rims = np.bincount(around.ravel(), minlength=count)
    hidden = np.bincount(around[unknown], minlength=count) >= SURROUNDED * rims
    hidden[[0, 1 + int(areas[1:].argmax())]] = False
    return np.asarray(hidden)


def _specks_beside(
    paper: Mask, numbered: cv2.typing.MatLike, areas: cv2.typing.MatLike, unknown: Mask, grid: Grid
) -> Mask:
    """Which of the numbered pieces are too small to believe and touch something unknown."""
    beside = cv2.dilate(unknown.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    touching = np.zeros(len(areas), bool)
    touching[np.unique(numbered[beside & paper])] = True
    return np.asarray((areas < SMALLEST_REGION * grid.pixels_per_unit**2) & touching)
