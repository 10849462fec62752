"""Lines inside the paper: the borders of layers that a state predicts against those that a photo shows.

Front on front and back on back look alike in a label image; the border of the upper layer still shows as a line. It
tells a flip from an unfold, and which of two hidden layers moved.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from folding_server.arrays import Image, Mask
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.borders import visible_borders
from folding_server.vision.registration.scene import Scene

FULLY_SEEN = 0.2
"""An edge of this strength (0 to 1) counts as fully seen."""
EDGE_TOLERANCE = 2
"""Pixels by which a seen line may be beside the predicted one."""
LEAST_INSIDE = 4
"""Pixels from the border of a class within which lines are not judged: RIM, and a pixel."""
USUAL_SIGHT = 0.8
"""The chance that a layer border shows where no photo has told."""
HALF_LENGTH = 0.3
"""Length of lines (sheet units) at which they count half as much as very long ones."""


@dataclass(frozen=True)
class InnerLines:
    """``missing``: share of predicted layer borders that the photo lacks; ``extra``: share of lines it has besides;
    ``shown``: share that it shows.

    Each from 0 to 1, weighted down where there is little line to judge by.
    """

    missing: float
    extra: float
    shown: float = 0.0

    @property
    def contradiction(self) -> float:
        """What is missing and what is extra together, 0 to 2."""
        return self.missing + self.extra


def inner_edge_agreement(paper: Paper, scene: Scene, motion: Similarity) -> InnerLines:
    """How the layer borders of a paper under a motion agree with the lines that a photo shows inside it."""
    if scene.edges is None:
        return InnerLines(0.0, 0.0)
    seen, judged, explained = _lines(paper, scene, motion)
    strong = np.where((seen >= 1.0) & _inside(scene, scene.shaded), seen, 0.0)
    per_unit = scene.grid.pixels_per_unit
    total = float(strong.sum())
    extra = float(strong[~explained].sum()) / total if total else 0.0
    shown = _shown(seen, judged)
    predicted = _weight(np.count_nonzero(judged) / (2 * per_unit))
    return InnerLines(
        scene.sight * (1 - shown) * predicted, extra * _weight(total / (4 * per_unit)), shown * predicted
    )


def sight(paper: Paper, scene: Scene, motion: Similarity) -> float:
    """The chance that the border of a layer shows in a sequence, 0 to 1, judged by a photo whose state is known."""
    if scene.edges is None:
        return 1.0
    seen, judged, _ = _lines(paper, scene, motion)
    length = np.count_nonzero(judged) / (2 * scene.grid.pixels_per_unit)
    return (length * _shown(seen, judged) + HALF_LENGTH * USUAL_SIGHT) / (length + HALF_LENGTH)


def _lines(paper: Paper, scene: Scene, motion: Similarity) -> tuple[Image, Mask, Mask]:
    """How strongly lines are seen, 0 to 1; where predicted layer borders can be judged; and what lies near any."""
    edges = np.zeros_like(scene.labels, np.float32) if scene.edges is None else scene.edges
    predicted = visible_borders(paper, scene.grid, motion)
    seen = np.where(scene.known, np.minimum(edges / FULLY_SEEN, 1.0), 0.0).astype(np.float32)
    wide = np.ones((2 * EDGE_TOLERANCE + 3, 2 * EDGE_TOLERANCE + 3), np.uint8)
    explained = cv2.dilate(predicted.all.astype(np.uint8), wide) > 0
    if scene.sheet_lines is not None:
        explained |= scene.sheet_lines.shown(paper, predicted.topmost, scene.grid, motion)
    return seen, predicted.layers & _inside(scene), explained


def _shown(seen: Image, judged: Mask) -> float:
    """The share of the judged pixels with a seen line near; 1 if there are none."""
    near_seen = cv2.dilate(seen, np.ones((2 * EDGE_TOLERANCE + 1, 2 * EDGE_TOLERANCE + 1), np.uint8))
    return float(near_seen[judged].mean()) if judged.any() else 1.0


def _weight(length: float) -> float:
    return length / (length + HALF_LENGTH)


def _inside(scene: Scene, margin: float = 0.0) -> Mask:
    """The paper well away from its outline, from colour borders and from what is unknown, where lines can be judged: by LEAST_INSIDE
    pixels, and by a margin in sheet units.
    """
    classes = np.where(scene.known, scene.labels, 7).astype(np.uint8)
    width = 2 * max(LEAST_INSIDE, round(margin * scene.grid.pixels_per_unit)) + 1
    kernel = np.ones((width, width), np.uint8)
    return np.asarray((cv2.erode(classes, kernel) == cv2.dilate(classes, kernel)) & scene.paper)
