"""Lines inside the paper: the borders of layers that a state predicts against those that a photo shows.

Front on front and back on back look alike in a label image; the border of the upper layer still shows as a line. It
tells a flip from an unfold, and which of two hidden layers moved.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from folding_server.simulator.paper import Paper
from folding_server.simulator.plane_geometry import Isometry
from folding_server.vision.borders import visible_borders
from folding_server.vision.solver.scene import Mask, Scene

FAINT = 0.2
"""An edge of this strength (0 to 1) counts as fully seen."""
REACH = 2
"""Pixels by which a seen line may be beside the predicted one."""
HALF_LENGTH = 0.3
"""Length of lines (sheet units) at which they count half as much as very long ones."""


@dataclass(frozen=True)
class InnerLines:
    """``missing``: share of predicted layer borders that the photo lacks; ``extra``: share of lines it has besides.

    Each from 0 to 1, weighted down where there is little line to judge by.
    """

    missing: float
    extra: float

    @property
    def contradiction(self) -> float:
        """Both together, 0 to 2."""
        return self.missing + self.extra


def inner_lines(paper: Paper, scene: Scene, motion: Isometry) -> InnerLines:
    """How the layer borders of a paper under a motion agree with the lines that a photo shows inside it."""
    if scene.edges is None:
        return InnerLines(0.0, 0.0)
    predicted = visible_borders(paper, scene.grid, motion)
    seen = np.where(scene.known, np.minimum(scene.edges / FAINT, 1.0), 0.0).astype(np.float32)
    shape = (2 * REACH + 1, 2 * REACH + 1)
    near_seen = cv2.dilate(seen, np.ones(shape, np.uint8))
    judged = predicted.layers & _inside(scene)
    explained = cv2.dilate(predicted.all.astype(np.uint8), np.ones((2 * REACH + 3, 2 * REACH + 3), np.uint8)) > 0
    strong = np.where(seen >= 1.0, seen, 0.0)
    per_unit = scene.grid.pixels_per_unit
    missing = float(1 - near_seen[judged].mean()) if judged.any() else 0.0
    total = float(strong.sum())
    extra = float(strong[~explained].sum()) / total if total else 0.0
    return InnerLines(
        missing * _weight(np.count_nonzero(judged) / (2 * per_unit)), extra * _weight(total / (4 * per_unit))
    )


def _weight(length: float) -> float:
    return length / (length + HALF_LENGTH)


def _inside(scene: Scene) -> Mask:
    """The paper well away from its outline, from colour borders and from what is unknown, where lines can be judged."""
    classes = np.where(scene.known, scene.labels, 7).astype(np.uint8)
    kernel = np.ones((9, 9), np.uint8)
    return np.asarray((cv2.erode(classes, kernel) == cv2.dilate(classes, kernel)) & scene.paper)
