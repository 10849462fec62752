"""Where the sheet lies in the photo: the plane of the table and the picture, related by one homography."""

from dataclasses import dataclass
from functools import cached_property
from math import atan2, pi

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Floats, Mask, RgbImage
from folding_server.vision.grid import Grid

SHEET = ((0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0))
"""The corners of the flat sheet, vertices 1 to 4, clockwise from the upper left."""


@dataclass(frozen=True)
class Pose:
    """Where vertices 1 to 4 of the flat sheet lie in the photo.

    ``corners`` (4, 2) are (column, row), whole at pixel centres.
    """

    corners: tuple[tuple[float, float], ...]

    @cached_property
    def to_photo_matrix(self) -> Floats:
        """The 3x3 homography from the sheet plane to photo pixels."""
        source, target = np.array(SHEET, np.float32), np.array(self.corners, np.float32)
        return np.asarray(cv2.getPerspectiveTransform(source, target), np.float64)

    @cached_property
    def to_plane_matrix(self) -> Floats:
        """The 3x3 homography from photo pixels to the sheet plane."""
        return np.asarray(np.linalg.inv(self.to_photo_matrix), np.float64)

    @cached_property
    def pixels_per_unit(self) -> float:
        """Mean length of the sheet's sides in the photo, in pixels."""
        corners = np.array(self.corners)
        return float(np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1).mean())

    def to_photo(self, points: npt.ArrayLike) -> Floats:
        """Plane points (N, 2) to photo pixels."""
        return _project(self.to_photo_matrix, points)

    def to_plane(self, pixels: npt.ArrayLike) -> Floats:
        """Photo pixels (N, 2) to the plane."""
        return _project(self.to_plane_matrix, pixels)

    def rectify(self, rgb: RgbImage, grid: Grid) -> tuple[RgbImage, Mask]:
        """The photo seen straight from above on a grid, and which pixels lie within the photo."""
        shrink = max(1.0, self.pixels_per_unit / grid.pixels_per_unit)
        size = (max(1, round(rgb.shape[1] / shrink)), max(1, round(rgb.shape[0] / shrink)))
        source = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA) if shrink > 1.25 else rgb
        ratio_x, ratio_y = source.shape[1] / rgb.shape[1], source.shape[0] / rgb.shape[0]
        resize = np.array([[ratio_x, 0, 0.5 * ratio_x - 0.5], [0, ratio_y, 0.5 * ratio_y - 0.5], [0, 0, 1.0]])
        matrix = resize @ self.to_photo_matrix @ np.linalg.inv(grid.matrix())
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        shape = (grid.cols, grid.rows)
        picture = cv2.warpPerspective(source, matrix, shape, flags=flags, borderMode=cv2.BORDER_REPLICATE)
        whole = np.full(source.shape[:2], 255, np.uint8)
        seen = cv2.warpPerspective(whole, matrix, shape, flags=flags) > 250
        return np.asarray(picture, np.uint8), np.asarray(seen)


def pose_of(corners: Floats) -> Pose:
    """The pose for four corners (4, 2), clockwise on screen: the assignment that turns the sheet least.

    The photo is taken to be upright, so the picture's upper left corner is vertex 1.
    """
    turns = [abs(_turn(np.roll(corners, -k, axis=0))) for k in range(4)]
    first = int(np.argmin(np.round(turns, 6)))
    ordered = np.roll(corners, -first, axis=0)
    return Pose(tuple((float(x), float(y)) for x, y in ordered))


def _turn(corners: Floats) -> float:
    """By how much, in radians, corners 1 to 4 are turned from upright."""
    right = corners[1] - corners[0] + corners[2] - corners[3]
    angle = atan2(right[1], right[0])
    return (angle + pi) % (2 * pi) - pi


def _project(matrix: Floats, points: npt.ArrayLike) -> Floats:
    xy = np.asarray(points, np.float64).reshape(-1, 2)
    moved = np.column_stack([xy, np.ones(len(xy))]) @ matrix.T
    return np.asarray(moved[:, :2] / moved[:, 2:], np.float64)
