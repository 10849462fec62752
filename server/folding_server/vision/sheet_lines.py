"""Lines that the flat sheet shows before anything is folded: creases of earlier folds, above all. They move with the paper, and say
nothing of its layers.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from folding_server.arrays import ByteMask, Image, Mask
from folding_server.geometry.point_batch import transformed
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.borders import value_of
from folding_server.vision.grid import Grid

SHEET_GRID = Grid(0.0, 1.0, 160.0, 160, 160)
"""The unit square, as finely as the solver looks at photos."""
LEAST_STRENGTH = 0.06
"""Strength, 0 to 1, from which a line of the flat sheet is known: a third of what makes one count fully later."""
LINE_REACH = 0.015
"""Sheet units beside such a line that belong to it: in later photos it may seem so far off."""
MOST_COVERED = 0.3
"""If more of the sheet is covered by lines they are a pattern, and nothing is known of creases."""
MOST_FACES = 254
"""Papers of more faces are drawn without telling all of them apart."""


@dataclass(frozen=True)
class SheetLines:
    """``near`` (rows, cols) of SHEET_GRID: where such lines are."""

    near: Mask

    def shown(self, paper: Paper, topmost: ByteMask, grid: Grid, motion: Similarity) -> Mask:
        """Where a folded paper under a motion shows these lines on a grid, (rows, cols); ``topmost`` is that of its
        :func:`folding_server.vision.borders.visible_borders` there.
        """
        found = np.zeros((grid.rows, grid.cols), np.bool_)
        if not self.near.any() or len(paper.order) > MOST_FACES:
            return found
        rows, cols = np.nonzero(topmost)
        seen = topmost[rows, cols]
        places = transformed(grid.to_plane(np.stack([cols, rows], axis=1)), motion.inverse())
        for face in paper.order:
            own = seen == value_of(paper, face)
            on_sheet = transformed(places[own], paper.isometries[face].inverse())
            found[rows[own], cols[own]] = SHEET_GRID.under(on_sheet, self.near)
        return found


def sheet_lines(edges: Image, grid: Grid) -> SheetLines:
    """The lines of a flat sheet, whose strength (rows, cols), 0 to 1, the first photo shows on a grid."""
    cols, rows = np.meshgrid(np.arange(SHEET_GRID.cols), np.arange(SHEET_GRID.rows))
    strength = grid.under(SHEET_GRID.to_plane(np.stack([cols, rows], axis=-1)), edges)
    reach = 2 * round(LINE_REACH * SHEET_GRID.pixels_per_unit) + 1
    strong = (strength > LEAST_STRENGTH).astype(np.uint8)
    near = cv2.dilate(strong, np.ones((reach, reach), np.uint8)) > 0
    return SheetLines(np.asarray(near if near.mean() <= MOST_COVERED else np.zeros_like(near)))
