"""A photo's label image in the photo's own coordinates, whatever the camera."""

from dataclasses import dataclass, replace

import numpy as np

from folding_server.arrays import Floats, Mask, RgbImage
from folding_server.vision.appearance import ColourModels, Look
from folding_server.vision.fitting.scene import Scene
from folding_server.vision.grid import FIELD_OF_VIEW, Grid, grid_over
from folding_server.vision.labels import UNKNOWN, LabelImage, is_paper
from folding_server.vision.pose_estimation.pinhole import PictureFrame
from folding_server.vision.segmentation import segment
from folding_server.vision.surfaces import Surface

FIRST_LOOK = 96.0
"""Pixels per picture unit at which the paper is looked for: 250 along the longer side of the picture."""
PAPER_ACROSS = 120.0
"""Pixels across the paper at which its outline is then taken: finer moves the camera by less than the solver's own search."""
AROUND = 0.35
"""How far around the paper the second look goes, in shares of its extent: light and colour of the table are told there."""
LEAST_AROUND = 0.1
"""The same at least, in picture units."""
NOTHING_SEEN = 30
"""Pixels of paper at the first look below which there is none."""


@dataclass(frozen=True)
class PictureView:
    """The paper in one photo: its label image as a scene in the coordinates of ``frame``."""

    frame: PictureFrame
    scene: Scene


def look(photo: RgbImage, palette: ColourModels) -> PictureView | None:
    """The view of a photo (rows, cols, 3), as finely as its paper needs; None if no paper is seen."""
    frame = PictureFrame(photo.shape[1], photo.shape[0])
    spread = anywhere(palette)
    grid = grid_over(FIRST_LOOK, FIELD_OF_VIEW)
    paper = is_paper(_labels(photo, frame, grid, spread))
    if np.count_nonzero(paper) < NOTHING_SEEN:
        return None
    closer = _around(paper, grid, frame)
    labels = _labels(photo, frame, closer, spread)
    if not is_paper(labels).any():
        return None
    return PictureView(frame, Scene(closer, labels, palette.back is not None))


def _labels(photo: RgbImage, frame: PictureFrame, grid: Grid, palette: ColourModels) -> LabelImage:
    rgb, seen = frame.pose.rectify(photo, grid)
    found = segment(rgb, seen, grid, palette)
    labels = found.shares.argmax(axis=-1).astype(np.uint8)
    labels[found.unknown] = UNKNOWN
    return np.asarray(labels)


def _around(paper: Mask, grid: Grid, frame: PictureFrame) -> Grid:
    """The window about the paper, as fine as is useful and the photo has it."""
    rows, cols = np.nonzero(paper)
    corners: Floats = grid.to_plane(
        [(cols.min() - 0.5, rows.max() + 0.5), (cols.max() + 0.5, rows.min() - 0.5)]
    )
    extent = float((corners[1] - corners[0]).max())
    margin = max(LEAST_AROUND, AROUND * extent)
    fine = min(max(FIRST_LOOK, PAPER_ACROSS / extent), max(FIRST_LOOK, frame.pixels_per_unit))
    low = np.maximum(corners[0] - margin, FIELD_OF_VIEW[:2])
    high = np.minimum(corners[1] + margin, FIELD_OF_VIEW[2:])
    return grid_over(fine, (float(low[0]), float(low[1]), float(high[0]), float(high[1])))


def anywhere(palette: ColourModels) -> ColourModels:
    """The palette with a table that has its colours wherever it is seen: another camera sees another part of it."""
    surface = palette.table.surfaces[0]
    x, y = np.meshgrid(*[np.linspace(-1, 1, 15)] * 2)
    colours = surface.at(x, y).reshape(-1, 3).astype(np.float64)
    spread = surface.covariance + np.cov(colours.T)
    flat = Surface(0, np.median(colours, axis=0).reshape(1, 3), spread, (-1.0, -1.0, 1.0, 1.0))
    return replace(palette, table=Look((flat,)))
