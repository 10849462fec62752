"""How far a label image is from the truth: by class, in thin parts, and under hands."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACK, BACKGROUND, FRONT, UNKNOWN, LabelImage, as_one_colour, is_paper
from folding_server.vision.outline import Outline
from folding_server.vision.pose import Pose
from folding_server.vision.raster import draw_labels
from folding_server.vision.seeing import Observation
from shapely import LineString, Polygon, unary_union

Bools = npt.NDArray[np.bool_]
Score = dict[str, float | None]
Pixel = tuple[float, float]

FINE = 4
THIN = 0.04
"""Sheet units below which a part of one class is thin."""
THINNEST = 2.0
"""Pixels of the photo from which a thin part can be asked for."""
LOST = 0.3
"""Share of a thin part's pixels below which it counts as lost."""
SHORTEST_BORDER = 40
"""Pixels of border from which its shift is told."""
SMALLEST = 12
"""Pixels of the label image that a thin part must have to count: the tips of corners have fewer."""


@dataclass(frozen=True)
class Truth:
    """What one photo shows, from its entry in a sequence's ``truth.json``."""

    folder: Path
    frame: dict[str, Any]
    pose: Pose
    grid: Grid

    def drawn(self, finer: int = 1) -> LabelImage:
        """The true labels on the grid, or on one so many times finer."""
        pixels = self.frame.get("vertex_pixels") or self.frame["camera"]["vertex_pixels"]
        plane = self.pose.to_plane(np.array(list(pixels.values())) - 0.5).tolist()
        places = dict(zip(pixels, plane, strict=True))
        polygons = [[tuple(places[str(v)]) for v in self.frame["faces"][str(f)]] for f in self.frame["order"]]
        backs = [bool(self.frame["orientations"][str(f)]) for f in self.frame["order"]]
        return draw_labels(polygons, backs, _finer(self.grid, finer))

    @cached_property
    def labels(self) -> LabelImage:
        """The true labels."""
        return self.drawn()

    def lenient(self, seen: LabelImage) -> LabelImage:
        """The true labels, where half a pixel is allowed for."""
        fine = self.drawn(2)
        agrees = np.stack([fine[i::2, j::2] for i in (0, 1) for j in (0, 1)]) == seen
        return np.where(agrees.any(axis=0), seen, self.labels).astype(np.uint8)

    @cached_property
    def hand(self) -> Bools | None:
        """The pixels that a hand hides, None if the truth tells of no hand or not where it is."""
        name = (self.frame.get("hand") or {}).get("mask")
        if name is None:
            return None
        mask = cv2.imread(str(self.folder / name), cv2.IMREAD_GRAYSCALE)
        if mask is None:
            message = f"{self.folder / name} cannot be read"
            raise OSError(message)
        rgb = np.asarray(cv2.cvtColor(mask, cv2.COLOR_GRAY2RGB), np.uint8)
        rectified, inside = self.pose.rectify(rgb, self.grid)
        return np.asarray((rectified[..., 0] > 127) & inside)

    def thin(self, value: int) -> Bools:
        """Thin parts of a class that the photo is fine enough to show."""
        mask = (self.drawn(FINE) == value).astype(np.uint8)
        scale = FINE * self.grid.pixels_per_unit
        shown = _opened(mask, THINNEST / self.pose.pixels_per_unit * scale)
        thin = shown & ~_opened(mask, THIN * scale)
        return np.asarray(thin[FINE // 2 :: FINE, FINE // 2 :: FINE])


def _finer(grid: Grid, factor: int) -> Grid:
    return replace(
        grid,
        pixels_per_unit=grid.pixels_per_unit * factor,
        rows=grid.rows * factor,
        cols=grid.cols * factor,
    )


def _opened(mask: npt.NDArray[np.uint8], width: float) -> Bools:
    side = max(1, round(width)) | 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    return np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel) > 0)


def scores(seen: Observation, truth: Truth) -> Score:
    """Shares of pixels, 0 to 1, None where there is nothing to score.

    ``accuracy``: known paper pixels labelled right; ``unknown``: true paper, not under a hand, that is
    unknown; ``front``, ``back``: intersection over union; ``thin_recall``: thin parts labelled right,
    ``thin_lost`` how many hardly are; ``false_share``: paper pixels of a class that is not there nor beside;
    ``hand_paper``, ``hand_table``: a hand's pixels taken for paper or for the table; ``inner_shift``: pixels by which
    borders between the two sides of the paper lie too far towards the darker one.
    """
    free = np.ones(seen.labels.shape, bool) if truth.hand is None else ~_grown(truth.hand, 5)
    labels, known = seen.labels, seen.labels != UNKNOWN
    true = truth.labels if seen.two_coloured else as_one_colour(truth.labels)
    lenient = truth.lenient(labels) if seen.two_coloured else as_one_colour(truth.lenient(labels))
    union = (is_paper(true) | is_paper(labels)) & known & free
    paper = is_paper(true) & free
    return {
        "accuracy": float((lenient == labels)[union].mean()) if union.any() else None,
        "unknown": float((~known)[paper].mean()) if paper.any() else None,
        "front": _iou(true == FRONT, labels == FRONT, known & free),
        "back": _iou(true == BACK, labels == BACK, known & free),
        **_thin_scores(labels, truth, free, seen.two_coloured),
        "false_share": _false(labels, true, free),
        **_hand_scores(labels, truth.hand),
        "inner_shift": _inner_shift(seen, truth.labels, known & free) if seen.two_coloured else None,
    }


def _inner_shift(seen: Observation, true: LabelImage, where: Bools) -> float | None:
    border = int(((true == FRONT) & _grown(true == BACK, 3) & where).sum())
    if border < SHORTEST_BORDER:
        return None
    light = {side: float(seen.rgb[true == side].mean()) for side in (FRONT, BACK)}
    dark, bright = sorted(light, key=lambda side: light[side])
    brightened = int(((true == dark) & (seen.labels == bright) & where).sum())
    darkened = int(((true == bright) & (seen.labels == dark) & where).sum())
    return (brightened - darkened) / border


def _iou(first: Bools, second: Bools, where: Bools) -> float | None:
    union = int(((first | second) & where).sum())
    return float((first & second & where).sum()) / union if union > 20 else None


def _thin_scores(labels: LabelImage, truth: Truth, free: Bools, two_coloured: bool) -> Score:
    if not two_coloured:
        return {"thin_recall": None, "thin_lost": 0.0}
    right, all_, lost = 0, 0, 0
    for value in (FRONT, BACK):
        thin = truth.thin(value) & free
        count, numbered = cv2.connectedComponents(thin.astype(np.uint8))
        sizes = np.bincount(numbered.ravel(), minlength=count)[1:]
        hits = np.bincount(numbered[thin & (labels == value)], minlength=count)[1:]
        large = sizes >= SMALLEST
        right, all_ = right + int(hits[large].sum()), all_ + int(sizes[large].sum())
        lost += int((hits[large] < LOST * sizes[large]).sum())
    return {"thin_recall": right / all_ if all_ else None, "thin_lost": float(lost)}


def _false(labels: LabelImage, true: LabelImage, free: Bools) -> float | None:
    wrong = np.zeros(labels.shape, bool)
    for value in (FRONT, BACK):
        wrong |= (labels == value) & ~_grown(true == value, 3)
    paper = int((is_paper(true) & free).sum())
    return float((wrong & free).sum()) / paper if paper else None


def _hand_scores(labels: LabelImage, hand: Bools | None) -> Score:
    if hand is None:
        return {"hand_paper": None, "hand_table": None}
    core = cv2.erode(hand.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    if not core.any():
        return {"hand_paper": None, "hand_table": None}
    return {
        "hand_paper": float(is_paper(labels)[core].mean()),
        "hand_table": float((labels == BACKGROUND)[core].mean()),
    }


def _grown(mask: Bools, side: int) -> Bools:
    return np.asarray(cv2.dilate(mask.astype(np.uint8), np.ones((side, side), np.uint8)) > 0)


def outline_score(outlines: Sequence[Outline], truth: Truth) -> Score:
    """``outline_pixels``: median distance of the sides seen from the true outline, in pixels of the photo."""
    pixels = truth.frame.get("vertex_pixels") or truth.frame["camera"]["vertex_pixels"]
    cycles = [[pixels[str(v)] for v in truth.frame["faces"][str(f)]] for f in truth.frame["order"]]
    true = unary_union([Polygon(cycle).buffer(0.01, join_style="mitre") for cycle in cycles]).boundary
    errors = [
        true.distance(LineString(side).interpolate(at, normalized=True))
        for outline in outlines
        for side in _sides(outline, truth.pose)
        for at in np.linspace(0.05, 0.95, 19)
    ]
    return {"outline_pixels": float(np.median(errors)) if errors else None}


def _sides(outline: Outline, pose: Pose) -> Iterator[tuple[Pixel, Pixel]]:
    """The two ends, in pixels of the photo as its truth has them, of each side that is seen."""
    corners = [(float(x), float(y)) for x, y in pose.to_photo(outline.corners) + 0.5]
    for i, seen in enumerate(outline.seen):
        if seen:
            yield corners[i], corners[(i + 1) % len(corners)]
