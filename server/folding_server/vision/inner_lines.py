"""Creases and layer edges inside the paper: faint lines that no border of a class shows."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi

import cv2
import numpy as np

from folding_server.arrays import Image, Mask, RgbImage
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.borders import visible_borders
from folding_server.vision.grid import Grid
from folding_server.vision.resampling import resampled
from folding_server.vision.sheet_lines import SheetLines

RIM = 0.018
"""Sheet units along the borders of a class that are left out: they are blurred, and shadows lie there."""
CURLED_RIM = 0.05
"""The same where flaps may stand up and the camera comes as near as it likes: the paper is shaded where it rounds a fold, and beside a
flap lies its shadow.
"""
HAND_SHADOW = 0.05
"""Sheet units around whatever is in the way that are left out: its blurred edge and its shadow look like lines."""
FAINTEST, FULL = 4.5, 11.0
"""Responses, in deviations of the paper's grain, from which a line is seen and at which it counts fully."""
GRAIN_QUANTILE = 85
"""Percent of the paper whose responses are grain or pattern, not lines."""
LINE_TOLERANCE = 0.025
"""Sheet units that a predicted line may lie beside a seen one."""
TOLD_STRENGTH, TOLD_LENGTH = 0.3, 0.12
"""Strength, and length in sheet units, from which a seen line is worth a word."""

_ORIENTATIONS = 12
"""Directions of the filters that find lines, over 180 degrees."""
_ACROSS, _ALONG, _SLOW = 0.0045, 0.03, 0.04
"""Width and length of these filters, and the blur of what light does slowly (sheet units)."""


def inner_lines(rgb: RgbImage, shares: Image, unknown: Mask, pixels_per_unit: float) -> Image:
    """Strength, 0 to 1, of straight lines within one side of the paper, (rows, cols).

    A line is a ridge, darker or lighter than both its sides, or a step between them. ``shares`` (rows, cols,
    3) and ``unknown`` (rows, cols) belong to the same pixels as the picture.
    """
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    strength = np.zeros(grey.shape, np.float32)
    reach = 2 * max(1, round(HAND_SHADOW * pixels_per_unit)) + 1
    shadowed = cv2.dilate(unknown.astype(np.uint8), np.ones((reach, reach), np.uint8)) > 0
    for side in (1, 2):
        own = ((shares[..., side] > 0.9) & ~shadowed).astype(np.uint8)
        rim = 2 * max(1, round(RIM * pixels_per_unit)) + 1
        core = cv2.erode(own, np.ones((rim, rim), np.uint8))
        left, upper, width, height = cv2.boundingRect(core)
        if width and height:
            window = slice(upper, upper + height), slice(left, left + width)
            strength[window] += _lines_within(grey[window], own[window], core[window] > 0, pixels_per_unit)
    return np.asarray(strength, np.float32)


def _lines_within(grey: Image, own: cv2.typing.MatLike, core: Mask, pixels_per_unit: float) -> Image:
    """Strength of lines in a window; ``own`` is paper of one side, ``core`` the part away from its rim."""
    weight = own.astype(np.float32)
    slow = _SLOW * pixels_per_unit
    smooth = cv2.GaussianBlur(grey * weight, (0, 0), slow) / np.maximum(
        cv2.GaussianBlur(weight, (0, 0), slow), 1e-3
    )
    detail = (grey - smooth) * weight
    strongest = np.zeros_like(grey)
    for kernel in _kernels(max(0.9, _ACROSS * pixels_per_unit), max(3.0, _ALONG * pixels_per_unit)):
        response = np.abs(cv2.filter2D(detail, cv2.CV_32F, kernel))
        median, high = np.percentile(response[core], (50, GRAIN_QUANTILE))
        grain = max(1.4826 * float(median), float(high) / 1.44, 0.15)
        np.maximum(strongest, response / grain, out=strongest)
    return np.asarray(
        np.where(core, np.clip((strongest - FAINTEST) / (FULL - FAINTEST), 0, 1), 0), np.float32
    )


def _kernels(across: float, along: float) -> Iterator[Image]:
    """Ridge and step filters of unit power in every direction, square kernels."""
    radius = int(np.ceil(2 * along))
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1].astype(np.float64)
    for k in range(_ORIENTATIONS):
        angle = pi * k / _ORIENTATIONS
        u, v = x * np.cos(angle) + y * np.sin(angle), -x * np.sin(angle) + y * np.cos(angle)
        length = np.exp(-0.5 * (u / along) ** 2)
        ridge = (1 - (v / across) ** 2) * np.exp(-0.5 * (v / across) ** 2) * length
        step = v * np.exp(-0.5 * (v / (1.5 * across)) ** 2) * length
        for kernel in (ridge - ridge.mean(), step):
            yield (kernel / np.linalg.norm(kernel)).astype(np.float32)


@dataclass(frozen=True)
class LineMatch:
    """How a photo's inner lines and a state's visible layer edges and creases fit together.

    ``agreement``, -1 to 1: 1 if all seen lines are predicted, 0 if nothing is seen or no more than chance
    explains, below 0 if seen lines lie where none are predicted. ``missing``: seen lines that the state
    lacks, each as its middle in pixels (column, row) and its length in sheet units, longest first.
    """

    agreement: float
    missing: tuple[tuple[float, float, float], ...]

    @property
    def longest_missing(self) -> float:
        """Length in sheet units of the longest line that the state lacks, 0 if there is none."""
        return self.missing[0][2] if self.missing else 0.0


NO_LINES = LineMatch(0.0, ())


def match_lines(
    paper: Paper,
    motion: Similarity,
    edges: Image,
    grid: Grid,
    core: Mask,
    known: SheetLines | None = None,
) -> LineMatch:
    """Compare a photo's :func:`inner_lines` with a state; ``core`` is where both show the same side, ``known`` the lines that the flat
    sheet had.
    """
    width = 2 * max(1, round(LINE_TOLERANCE * grid.pixels_per_unit)) + 1
    borders = visible_borders(paper, grid, motion)
    near = cv2.dilate(borders.all.astype(np.uint8), np.ones((width, width), np.uint8)) > 0
    if known is not None:
        near |= known.shown(paper, borders.topmost, grid, motion)
    seen = np.where(core, edges, 0)
    total, expected = float(seen.sum()), float((near & core).sum()) / max(float(core.sum()), 1.0)
    if total < 0.05 * grid.pixels_per_unit or expected >= 1:
        return LineMatch(0.0, ())
    explained = float(seen[near].sum()) / total
    agreement = min(max((explained - expected) / (1 - expected), -1.0), 1.0)
    return LineMatch(agreement, tuple(_long_lines((seen > TOLD_STRENGTH) & ~near, grid.pixels_per_unit)))


def _long_lines(mask: Mask, pixels_per_unit: float) -> list[tuple[float, float, float]]:
    """The long connected lines of a mask: middle column and row, length in sheet units, longest first."""
    count, _, stats, centres = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    lines = []
    for i in range(1, count):
        size = float(np.hypot(stats[i, cv2.CC_STAT_WIDTH], stats[i, cv2.CC_STAT_HEIGHT])) / pixels_per_unit
        if size >= TOLD_LENGTH:
            lines.append((float(centres[i][0]), float(centres[i][1]), size))
    return sorted(lines, key=lambda line: line[2], reverse=True)


def thick_core(labels_agree: Mask, pixels_per_unit: float, rim: float = RIM) -> Mask:
    """Away from the rim of where photo and prediction show the same side of the paper."""
    width = 2 * max(1, round(rim * pixels_per_unit)) + 1
    return np.asarray(cv2.erode(labels_agree.astype(np.uint8), np.ones((width, width), np.uint8)) > 0)


def strongest_near(edges: Image, old: Grid, new: Grid) -> Image:
    """Inner lines of one grid on another, thin lines kept at full strength."""
    reach = max(1, round(old.pixels_per_unit / new.pixels_per_unit))
    return np.asarray(resampled(cv2.dilate(edges, np.ones((reach, reach), np.uint8)), old, new), np.float32)
