"""Pictures of a comparison: the photo from above, its outline and the diagram's over it, disagreement hatched."""

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Mask, RgbImage
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.borders import visible_borders
from folding_server.vision.comparison import Match
from folding_server.vision.grid import Grid
from folding_server.vision.labels import UNKNOWN, is_paper
from folding_server.vision.outline import Outline
from folding_server.vision.raster import draw_paper
from folding_server.vision.seeing import Observation

OUTLINE = (255, 0, 200)
LAYER = (0, 200, 255)
SEEN = (60, 255, 60)
WRONG, BESIDE = (255, 40, 0), (255, 255, 255)
STRIPE = 6
"""Pixels across of the stripes, of both colours in turn, that mark disagreement on paper of any colour."""
TABLE_MARGIN = 0.12
"""Sheet units of table shown around the paper."""


def draw_overlay(
    paper: Paper, seen: Observation, match: Match, size: int = 768, outlines: Sequence[Outline] = ()
) -> RgbImage:
    """The rectified photo around the paper, longest side ``size`` pixels, RGB.

    Where the classes disagree it is hatched red and white; the diagram's silhouette is drawn in magenta, its
    visible layer edges and creases in cyan, and the sides of the photo's ``outlines``, in the plane of the table,
    in green where the photo shows them.
    """
    left, upper, right, lower = _window(match, seen)
    scale = size / max(right - left, lower - upper)
    grid = _part(seen.grid, left, upper, right, lower, scale)
    shape = (grid.cols, grid.rows)
    window = (slice(upper, lower), slice(left, right))
    picture = cv2.resize(seen.rgb[window], shape, interpolation=cv2.INTER_CUBIC).astype(np.float32)
    wrong = ((match.predicted != seen.labels) & (seen.labels != UNKNOWN))[window].astype(np.uint8)
    _hatch(picture, cv2.resize(wrong, shape, interpolation=cv2.INTER_NEAREST) > 0)
    silhouette, layers = visible_lines(paper, grid, match.alignment.motion)
    for outline in outlines:
        _draw_sides(picture, outline, grid)
    picture[layers] = LAYER
    picture[silhouette] = OUTLINE
    pixels: npt.NDArray[np.uint8] = np.clip(picture, 0, 255).astype(np.uint8)
    return pixels


def _hatch(picture: cv2.typing.MatLike, where: Mask) -> None:
    """Draw diagonal stripes over a part of a picture."""
    rows, cols = np.nonzero(where)
    red = ((rows + cols) // STRIPE % 2 == 0)[:, None]
    colour = np.where(red, WRONG, BESIDE).astype(np.float32)
    picture[rows, cols] += np.where(red, np.float32(0.6), np.float32(0.3)) * (colour - picture[rows, cols])


def _draw_sides(picture: cv2.typing.MatLike, outline: Outline, grid: Grid) -> None:
    """Draw the sides that are seen, sub-pixel, with smooth edges."""
    ends = np.rint(grid.to_pixel(np.array(outline.corners)) * 16).astype(int).tolist()
    for i, shown in enumerate(outline.seen):
        if shown:
            cv2.line(picture, ends[i], ends[(i + 1) % len(ends)], SEEN, 2, cv2.LINE_AA, 4)


def visible_lines(paper: Paper, grid: Grid, motion: Similarity) -> tuple[Mask, Mask]:
    """The diagram's silhouette, and the other borders of faces that nothing covers, as masks on a grid."""
    covered = is_paper(draw_paper(paper, grid, motion)).astype(np.uint8)
    silhouette = cv2.dilate(covered, np.ones((3, 3), np.uint8)) != cv2.erode(
        covered, np.ones((3, 3), np.uint8)
    )
    return np.asarray(silhouette), visible_borders(paper, grid, motion).all


def _window(match: Match, seen: Observation) -> tuple[int, int, int, int]:
    """Left, upper, right, lower pixels around all paper."""
    rows, cols = np.nonzero(is_paper(seen.labels) | is_paper(match.predicted))
    if not len(rows):
        return 0, 0, seen.grid.cols, seen.grid.rows
    margin = round(TABLE_MARGIN * seen.grid.pixels_per_unit)
    left, upper = max(0, int(cols.min()) - margin), max(0, int(rows.min()) - margin)
    return (
        left,
        upper,
        min(seen.grid.cols, int(cols.max()) + margin),
        min(seen.grid.rows, int(rows.max()) + margin),
    )


def _part(grid: Grid, left: int, upper: int, right: int, lower: int, scale: float) -> Grid:
    """The window of a grid, enlarged."""
    s = grid.pixels_per_unit
    rows, cols = max(1, round((lower - upper) * scale)), max(1, round((right - left) * scale))
    return Grid(grid.left + left / s, grid.top - upper / s, s * scale, rows, cols)
