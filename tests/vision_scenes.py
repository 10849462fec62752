"""Small painted photos with a known truth, and photos from files, as sequences that can be seen."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
import numpy.typing as npt
from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.geometry.isometry import IDENTITY, Isometry
from folding_server.photographer.color_spaces import floats, to_linear, to_srgb
from folding_server.simulator.paper import Paper
from folding_server.vision.grid import Grid
from paper_drawings import shares

SIDE = 360
"""Pixels of a painted photo; the sheet is half as wide."""
GRID = Grid(-0.5, 1.5, SIDE / 2, SIDE, SIDE)
"""Where the painted camera, straight above the table, sees the plane."""


@dataclass(frozen=True)
class PhotoList:
    """Photos held in memory."""

    photos: Sequence[RgbImage] = field(repr=False)
    front_color: str | None = None
    back_color: str | None = None
    name: str = "the test"

    @property
    def frame_count(self) -> int:
        """How many there are."""
        return len(self.photos)

    def photo(self, frame: int) -> RgbImage:
        """One of them, counted from 1."""
        if not 1 <= frame <= len(self.photos):
            raise PhotoError(f"frame {frame} is not in 1..{len(self.photos)}")
        return self.photos[frame - 1]


@dataclass(frozen=True)
class Look:
    """sRGB colours of a painted scene, and how far a lamp darkens the right side (0 to 1)."""

    front: tuple[int, int, int] = (240, 235, 220)
    back: tuple[int, int, int] = (190, 60, 50)
    table: tuple[int, int, int] = (70, 80, 90)
    lamp: float = 0.25


def paint(paper: Paper, look: Look, motion: Isometry = IDENTITY, seed: int = 0) -> RgbImage:
    """A photo of a folded sheet: flat colours, their light slightly blurred, under a lamp and with noise."""
    colours = np.array([look.table, look.front, look.back], np.float32)
    light = np.einsum("kyx,kc->yxc", shares(paper, GRID, motion), to_linear(colours))
    light = cv2.GaussianBlur(light, (0, 0), 0.7)
    picture = to_srgb(floats(light)) * (1 - look.lamp * np.linspace(0, 1, SIDE)[None, :, None])
    noise = np.random.default_rng(seed).normal(0, 2.0, picture.shape)
    return np.clip(picture + noise, 0, 255).astype(np.uint8)


def read_rgb(path: object) -> RgbImage:
    """A picture file as RGB."""
    bgr = cv2.imread(str(path))
    assert bgr is not None
    return np.ascontiguousarray(bgr[..., ::-1])


def share_right(labels: npt.NDArray[np.uint8], truth: npt.NDArray[np.uint8]) -> float:
    """Share of known pixels on seen or true paper whose label is true."""
    known = labels != 255
    union = ((truth > 0) | (labels > 0)) & known
    return float((labels == truth)[union].mean())
