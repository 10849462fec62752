"""How well the outline of a reconstructed paper covers that of the true one."""

import numpy as np
import numpy.typing as npt
from folding_server.geometry.isometry import Isometry, turn
from folding_server.geometry.line import Point
from folding_server.simulator import Paper
from folding_server.vision.grid import Grid, grid_over
from folding_server.vision.labels import is_paper
from folding_server.vision.raster import draw_paper

Mask = npt.NDArray[np.bool_]
PIXELS_PER_UNIT = 160.0
MARGIN = 0.25
"""How far around the true paper is drawn, in sheet units."""
FREE_TURN = 15
"""Degrees by which the sheet may have drifted in the photos: that is not the paper's shape."""
HALVINGS = 5


def silhouette_iou(true: Paper, found: Paper) -> float:
    """Intersection over union of two silhouettes, 0 to 1.

    A small shift and turn (at most FREE_TURN degrees) are free, since the sheet drifts between photos.
    """
    grid = _grid_around(true)
    wanted = is_paper(draw_paper(true, grid))
    own, aim = _middle(found, _grid_around(found)), _middle(true, grid)

    def iou(shift_x: float, shift_y: float, degrees: float) -> float:
        motion = _shifted(turn(degrees, own), aim[0] - own[0] + shift_x, aim[1] - own[1] + shift_y)
        return _iou(wanted, is_paper(draw_paper(found, grid, motion)))

    best = max((iou(0.0, 0.0, float(a)), 0.0, 0.0, float(a)) for a in range(-FREE_TURN, FREE_TURN + 1))
    for halving in range(HALVINGS):
        x, y, a = best[1:]
        step, angle = 0.02 / 2**halving, 1.0 / 2**halving
        nearby = [
            (x + i * step, y + j * step, a + k * angle)
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
            for k in (-1, 0, 1)
        ]
        best = max(best, *((iou(*place), *place) for place in nearby))
    return best[0]


def _iou(first: Mask, second: Mask) -> float:
    return float((first & second).sum() / max(1, (first | second).sum()))


def _shifted(motion: Isometry, x: float, y: float) -> Isometry:
    return motion._replace(e=motion.e + x, f=motion.f + y)


def _grid_around(paper: Paper) -> Grid:
    points = np.array(list(paper.folded_vertices_coords.values()))
    (left, bottom), (right, top) = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    return grid_over(PIXELS_PER_UNIT, (float(left), float(bottom), float(right), float(top)))


def _middle(paper: Paper, grid: Grid) -> Point:
    """The centre of a silhouette's area."""
    rows, cols = np.nonzero(is_paper(draw_paper(paper, grid)))
    x, y = grid.to_plane((float(cols.mean()), float(rows.mean())))
    return float(x), float(y)
