"""Pictures of a comparison: the photo from above, the diagram's outline over it, disagreement tinted."""

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.simulator.paper import Paper
from folding_server.simulator.plane_geometry import Isometry
from folding_server.vision.borders import visible_borders
from folding_server.vision.comparison import Match
from folding_server.vision.grid import Grid
from folding_server.vision.labels import UNKNOWN, is_paper
from folding_server.vision.photos import Picture
from folding_server.vision.raster import draw_paper
from folding_server.vision.seeing import SeenFrame

OUTLINE = (255, 0, 200)
LAYER = (0, 200, 255)
WRONG = (255, 40, 0)
MARGIN = 0.12
"""Sheet units of table shown around the paper."""


def draw_overlay(paper: Paper, seen: SeenFrame, match: Match, size: int = 768) -> Picture:
    """The rectified photo around the paper, longest side ``size`` pixels, RGB.

    Where the classes disagree it is tinted red; the diagram's silhouette is drawn in magenta, its visible
    layer edges and creases in cyan.
    """
    left, upper, right, lower = _window(match, seen)
    scale = size / max(right - left, lower - upper)
    grid = _part(seen.grid, left, upper, right, lower, scale)
    shape = (grid.cols, grid.rows)
    window = (slice(upper, lower), slice(left, right))
    picture = cv2.resize(seen.rgb[window], shape, interpolation=cv2.INTER_CUBIC).astype(np.float32)
    wrong = ((match.predicted != seen.labels) & (seen.labels != UNKNOWN))[window].astype(np.uint8)
    tint = cv2.resize(wrong, shape, interpolation=cv2.INTER_NEAREST) > 0
    picture[tint] = 0.45 * picture[tint] + 0.55 * np.array(WRONG, np.float32)
    silhouette, layers = visible_lines(paper, grid, match.alignment.motion)
    picture[layers] = LAYER
    picture[silhouette] = OUTLINE
    pixels: npt.NDArray[np.uint8] = np.clip(picture, 0, 255).astype(np.uint8)
    return pixels


def visible_lines(
    paper: Paper, grid: Grid, motion: Isometry
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """The diagram's silhouette, and the other borders of faces that nothing covers, as masks on a grid."""
    covered = is_paper(draw_paper(paper, grid, motion)).astype(np.uint8)
    silhouette = cv2.dilate(covered, np.ones((3, 3), np.uint8)) != cv2.erode(
        covered, np.ones((3, 3), np.uint8)
    )
    return np.asarray(silhouette), visible_borders(paper, grid, motion).all


def _window(match: Match, seen: SeenFrame) -> tuple[int, int, int, int]:
    """Left, upper, right, lower pixels around all paper."""
    rows, cols = np.nonzero(is_paper(seen.labels) | is_paper(match.predicted))
    if not len(rows):
        return 0, 0, seen.grid.cols, seen.grid.rows
    margin = round(MARGIN * seen.grid.pixels_per_unit)
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
