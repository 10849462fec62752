"""A pinhole camera over a table: world units are sheet sides, z is up, the table is z = 0.

Pixels: x right, y down, the image's upper left corner at (0, 0), so that the first pixel's centre is (0.5,
0.5).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, radians, sin
from typing import cast

import numpy as np

from folding_server.arrays import Floats

Matrix = Floats


@dataclass(frozen=True)
class Camera:
    """x_camera = R x_table + t with y down and z forward; K maps to homogeneous pixels. K and R 3x3, t 3."""

    K: Matrix
    R: Matrix
    t: Matrix

    @property
    def table_to_pixel(self) -> Matrix:
        """Homography from the table plane (z = 0) to pixels, scaled to end in 1."""
        return scaled(self.K @ np.column_stack([self.R[:, 0], self.R[:, 1], self.t]))

    def project(self, points: Sequence[Sequence[float]] | Matrix) -> Matrix:
        """Pixels (n, 2) of points (n, 3) over the table."""
        seen = (np.asarray(points, float).reshape(-1, 3) @ self.R.T + self.t) @ self.K.T
        return seen[:, :2] / seen[:, 2:]


def scaled(homography: Matrix) -> Matrix:
    """The same homography with 1 as its last entry."""
    return cast("Matrix", homography / homography[2, 2])


def looking_down(
    size: tuple[int, int],
    focal: float,
    distance: float,
    tilt: float,
    azimuth: float,
    roll: float,
    look_at: tuple[float, float] = (0.0, 0.0),
) -> Camera:
    """A camera that looks at a point of the table, the origin unless another is given, from ``distance``.

    ``size`` (width, height) and ``focal`` in pixels; ``tilt`` from straight down, the ``azimuth`` on the
    table it leans towards and ``roll`` about its own axis in degrees.
    """
    width, height = size
    K = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1.0]])
    upright = np.diag([1.0, -1.0, -1.0])
    R = _about_z(roll) @ upright @ _leaning(tilt, azimuth)
    return Camera(K, R, np.array([0, 0, distance]) - R @ np.array([*look_at, 0.0]))


def _about_z(degrees: float) -> Matrix:
    c, s = cos(radians(degrees)), sin(radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def _leaning(tilt: float, azimuth: float) -> Matrix:
    """Rotation that brings the direction of a leaning camera (tilt from z towards azimuth) onto z."""
    c, s = cos(radians(tilt)), sin(radians(tilt))
    about_y = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    return cast("Matrix", _about_z(azimuth) @ about_y @ _about_z(-azimuth))
