"""Where a folded state shows lines inside its silhouette: the borders of layers, and creases within them."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Mask
from folding_server.geometry.convex import Polygon
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.simulator.planes import planes
from folding_server.vision.grid import Grid
from folding_server.vision.raster import draw_values

_VALUES = 254
"""Layers are told apart by this many values; two that share one would have to lie beside each other to matter."""


@dataclass(frozen=True)
class Borders:
    """Masks (rows, cols), two pixels wide: ``layers`` between visible planes, ``creases`` within one plane.

    ``topmost`` (rows, cols) has the :func:`value_of` the topmost face, 0 where there is none.
    """

    layers: Mask
    creases: Mask
    topmost: npt.NDArray[np.uint8]

    @property
    def all(self) -> Mask:
        """Both kinds."""
        return np.asarray(self.layers | self.creases)


def visible_borders(paper: Paper, grid: Grid, motion: Similarity) -> Borders:
    """The lines that a paper shows on a grid under a motion."""
    outlines = [paper.polygon(f) for f in paper.order]
    plane_of = {face: 1 + i % _VALUES for i, group in enumerate(planes(paper)) for face in group}
    by_plane = draw_values(outlines, [plane_of[f] for f in paper.order], grid, motion)
    by_face = draw_values(outlines, [value_of(paper, f) for f in paper.order], grid, motion)
    creases = changes(by_face)
    layers = changes(by_plane)
    if (creases & ~layers).any():
        layers |= creases & _steps(outlines, grid, motion)
    return Borders(layers, np.asarray(creases & ~layers), by_face)


def _steps(outlines: Sequence[Polygon], grid: Grid, motion: Similarity) -> Mask:
    """Where layers end below: paper laid over their end shows its crease there as clearly as a border."""
    depth = np.zeros((grid.rows, grid.cols), np.uint8)
    for outline in outlines:
        depth += draw_values([outline], [1], grid, motion)
    depth = np.asarray(cv2.medianBlur(depth, 5))
    around = np.ones((5, 5), np.uint8)
    least = cv2.erode(np.where(depth > 0, depth, np.uint8(255)), around)
    return np.asarray(cv2.dilate(depth, around) > least)


def value_of(paper: Paper, face: int) -> int:
    """The value, 1 to 254, that a face is drawn with."""
    return 1 + paper.rank[face] % _VALUES


def changes(values: npt.NDArray[np.uint8]) -> Mask:
    """Where two neighbouring pixels, both drawn (above 0), differ; both are marked."""
    changed = np.zeros(values.shape, np.bool_)
    for here, there in (
        ((slice(None, -1), slice(None)), (slice(1, None), slice(None))),
        ((slice(None), slice(None, -1)), (slice(None), slice(1, None))),
    ):
        differ = (values[here] != values[there]) & (values[here] > 0) & (values[there] > 0)
        changed[here] |= differ
        changed[there] |= differ
    return changed
