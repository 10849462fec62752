"""A photo's label image in the photo's own coordinates, whatever the camera."""

from dataclasses import dataclass, replace
from math import ceil

import cv2
import numpy as np

from folding_server.arrays import Floats, Image, Mask, RgbImage
from folding_server.vision.adapting import adapt
from folding_server.vision.appearance import ColourModels, Look
from folding_server.vision.grid import FIELD_OF_VIEW, Grid, grid_over
from folding_server.vision.labels import UNKNOWN, LabelImage, is_paper
from folding_server.vision.pose import Pose
from folding_server.vision.pose_estimation.pinhole import PictureFrame
from folding_server.vision.registration.scene import Scene
from folding_server.vision.segmentation import Segmented, class_costs, segment, smoothed_lab
from folding_server.vision.surfaces import Surface

FIRST_LOOK = 96.0
"""Pixels per picture unit at which the paper is looked for: 250 along the longer side of the picture."""
PAPER_ACROSS = 160.0
"""Pixels across the paper at which it is then segmented: as many as the solver's fine view has across a sheet."""
WINDOW_MARGIN = 0.35
"""How far around the paper the second look goes, in shares of its extent: light and colour of the table are told there."""
LEAST_MARGIN = 0.1
"""The same at least, in picture units."""
LIKE_PAPER = 12.0
"""Cost, in nats, up to which a pixel may be paper in other light: as far as light is adapted to."""
LEAST_PIECE_SHARE, MOST_PIECES = 0.2, 3
"""Pieces of less than the first share of the largest are not the sheet; so many are looked at."""
BORDER_WIDTH = 5
"""Pixels across of a border between the two sides of the sheet at the first look, whose mixture may look like neither: parts that
are no farther apart are one piece.
"""
UNKNOWN_FROM = 0.5
"""Share of a pixel from which it is unknown if so much of it is."""
NOTHING_SEEN = 30
"""Pixels of paper at the first look below which there is none."""


@dataclass(frozen=True)
class PictureView:
    """The paper in one photo: its label image as a scene in the coordinates of ``frame``, and what that was made of."""

    frame: PictureFrame
    scene: Scene
    segmented: Segmented

    def rectified(self, pose: Pose, grid: Grid) -> Segmented:
        """The paper as seen straight from above by a camera, on a grid over the plane of the sheet. Beyond the window about the
        paper there is table.
        """
        own = self.scene.grid
        scale = pose.pixels_per_unit / self.frame.pixels_per_unit
        times = max(1, ceil(own.pixels_per_unit * scale / grid.pixels_per_unit - 0.25))
        fine = Grid(grid.left, grid.top, grid.pixels_per_unit * times, grid.rows * times, grid.cols * times)
        there = (
            own.matrix()
            @ self.frame.pose.to_plane_matrix
            @ pose.to_photo_matrix
            @ np.linalg.inv(fine.matrix())
        )

        def seen(image: Image, beyond: tuple[float, ...]) -> Image:
            flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
            warped = cv2.warpPerspective(
                image, there, (fine.cols, fine.rows), flags=flags, borderValue=beyond
            )
            small = cv2.resize(warped, (grid.cols, grid.rows), interpolation=cv2.INTER_AREA)
            return np.asarray(small if times > 1 else warped, np.float32)

        unknown = seen(self.segmented.unknown.astype(np.float32), (0.0,)) > UNKNOWN_FROM
        shares = np.where(unknown[..., None], np.float32(0), seen(self.segmented.shares, (1.0, 0.0, 0.0)))
        return Segmented(
            shares, np.asarray(unknown), seen(self.segmented.clearness, (1.0,)), same_table=False
        )


def picture_views(photo: RgbImage, palette: ColourModels) -> tuple[PictureView, ...]:
    """The views of a photo (rows, cols, 3), each as finely as its paper needs: one for each piece that has the colours of the
    sheet and may be it, the largest first. Empty if there is none.
    """
    frame = PictureFrame(photo.shape[1], photo.shape[0])
    anywhere_palette = anywhere(palette)
    grid = grid_over(FIRST_LOOK, FIELD_OF_VIEW)
    views = []
    for piece in _pieces(photo, frame, grid, anywhere_palette):
        closer = _around(piece, grid, frame)
        rgb, seen = frame.pose.rectify(photo, closer)
        own = _only(segment(rgb, seen, closer, anywhere_palette), closer, piece, grid)
        labels = _labels(own)
        if is_paper(labels).any():
            views.append(PictureView(frame, Scene(closer, labels, palette.back is not None), own))
    return tuple(views)


def _pieces(photo: RgbImage, frame: PictureFrame, grid: Grid, palette: ColourModels) -> list[Mask]:
    """Where there is something with the colours of the sheet: pieces by falling size, whole ones before those cut off."""
    rgb, seen = frame.pose.rectify(photo, grid)
    lab = smoothed_lab(rgb)
    costs = class_costs(lab, grid, adapt(lab, seen, grid, palette))
    like = (costs.argmin(axis=-1) > 0) & (costs.min(axis=-1) < LIKE_PAPER) & seen
    whole = cv2.morphologyEx(like.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    _, joined = cv2.connectedComponents(cv2.dilate(whole, np.ones((BORDER_WIDTH, BORDER_WIDTH), np.uint8)))
    numbered = joined * whole
    sizes = np.bincount(numbered.ravel(), minlength=2)[1:]
    if not len(sizes) or sizes.max() < NOTHING_SEEN:
        return []
    large = np.nonzero(sizes >= max(NOTHING_SEEN, LEAST_PIECE_SHARE * sizes.max()))[0]
    beyond = cv2.dilate((~seen).astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    beyond[[0, 1, -1, -2]] = beyond[:, [0, 1, -1, -2]] = True
    cut = [bool((beyond & (numbered == 1 + i)).any()) for i in large]
    order = sorted(zip(cut, -sizes[large], large, strict=True))
    return [np.asarray(numbered == 1 + i) for _, _, i in order[:MOST_PIECES]]


def _labels(found: Segmented) -> LabelImage:
    return np.where(found.unknown, UNKNOWN, found.shares.argmax(axis=-1)).astype(np.uint8)


def _only(found: Segmented, closer: Grid, piece: Mask, grid: Grid) -> Segmented:
    """What was segmented, with what is no part of a piece taken for something that hides the table."""
    cols, rows = np.meshgrid(np.arange(closer.cols), np.arange(closer.rows))
    places = closer.to_plane(np.stack([cols, rows], axis=-1))
    there = grid.under(places, cv2.dilate(piece.astype(np.uint8), np.ones((5, 5), np.uint8))) > 0
    unknown = found.unknown | (is_paper(_labels(found)) & ~there)
    return replace(found, unknown=unknown, shares=np.where(unknown[..., None], np.float32(0), found.shares))


def _around(paper: Mask, grid: Grid, frame: PictureFrame) -> Grid:
    """The window about the paper, as fine as is useful and the photo has it."""
    rows, cols = np.nonzero(paper)
    corners: Floats = grid.to_plane(
        [(cols.min() - 0.5, rows.max() + 0.5), (cols.max() + 0.5, rows.min() - 0.5)]
    )
    extent = float((corners[1] - corners[0]).max())
    margin = max(LEAST_MARGIN, WINDOW_MARGIN * extent)
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
