"""A raster over the table plane, in sheet units: x right, y up; row 0 is the uppermost."""

from dataclasses import dataclass
from math import ceil
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from folding_server.arrays import Floats

Scalar = TypeVar("Scalar", bound=np.generic)

Reach = tuple[float, float, float, float]
"""Left, bottom, right, top of a part of the plane, in sheet units."""
FIELD_OF_VIEW: Reach = (-0.8, -0.8, 1.8, 1.8)
"""Left, bottom, right, top of the part of the plane that folding one unit square normally stays in."""


@dataclass(frozen=True)
class Grid:
    """``rows`` x ``cols`` square pixels whose outer upper-left corner is at (``left``, ``top``).

    Pixel coordinates are (column, row) and whole at pixel centres, as OpenCV has them.
    """

    left: float
    top: float
    pixels_per_unit: float
    rows: int
    cols: int

    @property
    def right(self) -> float:
        """x of the outer right border."""
        return self.left + self.cols / self.pixels_per_unit

    @property
    def bottom(self) -> float:
        """y of the outer lower border."""
        return self.top - self.rows / self.pixels_per_unit

    def to_pixel(self, points: npt.ArrayLike) -> Floats:
        """Plane points (..., 2) to (column, row)."""
        xy = np.asarray(points, dtype=np.float64)
        scale = self.pixels_per_unit
        return np.stack(
            [(xy[..., 0] - self.left) * scale - 0.5, (self.top - xy[..., 1]) * scale - 0.5], axis=-1
        )

    def to_plane(self, pixels: npt.ArrayLike) -> Floats:
        """(column, row) points (..., 2) to the plane."""
        uv = np.asarray(pixels, dtype=np.float64)
        scale = self.pixels_per_unit
        return np.stack(
            [self.left + (uv[..., 0] + 0.5) / scale, self.top - (uv[..., 1] + 0.5) / scale], axis=-1
        )

    def under(self, points: npt.ArrayLike, image: npt.NDArray[Scalar]) -> npt.NDArray[Scalar]:
        """The value of an image (rows, cols) of this grid under each plane point (..., 2), (...); 0 outside."""
        pixels = np.rint(self.to_pixel(points)).astype(np.intp)
        cols, rows = pixels[..., 0], pixels[..., 1]
        inside = (cols >= 0) & (rows >= 0) & (cols < self.cols) & (rows < self.rows)
        seen = image[np.where(inside, rows, 0), np.where(inside, cols, 0)]
        return np.where(inside, seen, np.zeros(1, image.dtype))

    def matrix(self) -> Floats:
        """The 3x3 affine matrix of :meth:`to_pixel`."""
        s = self.pixels_per_unit
        return np.array([[s, 0, -self.left * s - 0.5], [0, -s, self.top * s - 0.5], [0, 0, 1.0]])


def grid_over(pixels_per_unit: float, reach: Reach = FIELD_OF_VIEW) -> Grid:
    """The grid that covers (left, bottom, right, top) at a resolution."""
    left, bottom, right, top = reach
    rows = ceil((top - bottom) * pixels_per_unit - 1e-9)
    cols = ceil((right - left) * pixels_per_unit - 1e-9)
    return Grid(left, top, pixels_per_unit, rows, cols)
