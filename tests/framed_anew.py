"""Photos of a folded sheet on a plain table, each from a pinhole camera of its own: drawn by cairo, projected by the textbook."""

from dataclasses import dataclass
from math import cos, radians, sin

import cv2
import numpy as np
import numpy.typing as npt
from folding_server.arrays import RgbImage
from folding_server.photographer.color_spaces import floats, to_linear, to_srgb
from folding_server.simulator.paper import Paper
from folding_server.vision.grid import Grid
from paper_drawings import shares
from vision_scenes import Look

SIDE, FOCAL = 700, 900.0
"""Pixels of the square pictures, and of the camera's focal length."""
TABLE = Grid(-2.0, 3.0, 160.0, 800, 800)
"""The part of the table that is painted."""
Matrix = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Standpoint:
    """A camera at a distance (sheet sides) from the point of the table it looks at, rolled and tilted (degrees), the tilt towards
    a direction (degrees); ``aside`` (pixels) is where in the picture that point is.
    """

    distance: float = 2.6
    roll: float = 0.0
    tilt: float = 0.0
    towards: float = 0.0
    aside: tuple[float, float] = (0.0, 0.0)
    look_at: tuple[float, float] = (0.5, 0.5)

    @property
    def homography(self) -> Matrix:
        """(3, 3), from the table to pixels, column and row, whole at their centres."""
        a, t, r = radians(self.towards), radians(self.tilt), radians(self.roll)
        down = np.diag([1.0, -1.0, -1.0])
        about = np.array([[cos(r), -sin(r), 0], [sin(r), cos(r), 0], [0, 0, 1]])
        axis = np.array([[cos(a), -sin(a), 0], [sin(a), cos(a), 0], [0, 0, 1]])
        lean = axis @ np.array([[1, 0, 0], [0, cos(t), -sin(t)], [0, sin(t), cos(t)]]) @ axis.T
        turned = lean @ about @ down
        shift = self.distance * np.array([self.aside[0] / FOCAL, self.aside[1] / FOCAL, 1.0])
        origin = shift - turned @ np.array([*self.look_at, 0.0])
        middle = (SIDE - 1) / 2
        lens = np.array([[FOCAL, 0, middle], [0, FOCAL, middle], [0, 0, 1.0]])
        return lens @ np.column_stack([turned[:, :2], origin])

    def pixels(self, points: npt.ArrayLike) -> Matrix:
        """Points of the table (N, 2) in the picture."""
        plane = (
            np.column_stack([np.asarray(points, float), np.ones(len(np.asarray(points)))]) @ self.homography.T
        )
        return np.asarray(plane[:, :2] / plane[:, 2:])


def photo(paper: Paper, standpoint: Standpoint, look: Look = Look(), seed: int = 0) -> RgbImage:
    """What a camera there sees."""
    colours = np.array([look.table, look.front, look.back], np.float32)
    light = np.einsum("kyx,kc->yxc", shares(paper, TABLE), to_linear(colours))
    matrix = standpoint.homography @ np.linalg.inv(TABLE.matrix())
    plain = to_linear(colours)[0]
    seen = cv2.warpPerspective(
        light.astype(np.float32), matrix, (SIDE, SIDE), flags=cv2.INTER_AREA, borderValue=plain.tolist()
    )
    noise = np.random.default_rng(seed).normal(0, 1.5, seen.shape)
    return np.asarray(np.clip(to_srgb(floats(cv2.GaussianBlur(seen, (0, 0), 0.6))) + noise, 0, 255), np.uint8)
