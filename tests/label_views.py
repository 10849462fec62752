"""Photos as the solver sees them, drawn from known papers: label images with drift, noise and holes, no camera."""

from dataclasses import dataclass

import cv2
import numpy as np
from folding_server.geometry.isometry import Isometry, turn
from folding_server.simulator import Paper
from folding_server.vision.grid import grid_over
from folding_server.vision.labels import UNKNOWN, as_one_colour
from folding_server.vision.registration.scene import Scene, Views
from paper_drawings import label_image, layer_lines

REACH = (-0.6, -0.6, 1.6, 1.6)
LINE_WIDTH = 2.0
"""Pixels that the dark line is wide at which a layer ends."""


@dataclass(frozen=True)
class Spoiling:
    """What is wrong with the photo: drift (sheet units, degrees), share of wrong pixels, and a hidden disc."""

    shift: tuple[float, float] = (0.0, 0.0)
    degrees: float = 0.0
    noise: float = 0.0
    hidden: tuple[float, float, float] | None = None

    @property
    def motion(self) -> Isometry:
        """The drift as a motion of the plane."""
        return Isometry(1, 0, 0, 1, *self.shift).after(turn(self.degrees, (0.5, 0.5)))


CLEAN = Spoiling()


def views(paper: Paper, spoiling: Spoiling = CLEAN, seed: int = 0) -> Views:
    """A paper seen coarse and fine."""
    return Views(scene(paper, 64, spoiling, seed), scene(paper, 160, spoiling, seed + 1))


def lit_scene(paper: Paper, motion: Isometry, seed: int, slope: float = 0.0, line: float = 25.0) -> Scene:
    """A paper of one colour on both sides as a photo shows it: dark lines where layers end, light that falls off to one
    side by ``slope`` a sheet unit, and grain.
    """
    chance = np.random.default_rng(seed)
    grid = grid_over(256, REACH)
    labels = as_one_colour(label_image(paper, grid, motion))
    light = (
        170
        + slope * np.linspace(REACH[0], REACH[2], grid.cols, dtype=np.float32)[None]
        + np.zeros_like(labels)
    )
    light = light - line * layer_lines(paper, grid, motion, LINE_WIDTH) + chance.normal(0, 1.5, labels.shape)
    return Scene(grid, labels, False, light=cv2.GaussianBlur(light.astype(np.float32), (0, 0), 0.8))


def scene(paper: Paper, pixels_per_unit: float, spoiling: Spoiling, seed: int) -> Scene:
    """A paper as a label image."""
    chance = np.random.default_rng(seed)
    grid = grid_over(pixels_per_unit, REACH)
    labels = label_image(paper, grid, spoiling.motion)
    wrong = chance.random(labels.shape) < spoiling.noise
    labels[wrong] = chance.integers(0, 3, int(wrong.sum()))
    labels = cv2.medianBlur(labels, 3)
    if spoiling.hidden is not None:
        x, y, radius = spoiling.hidden
        col, row = grid.to_pixel((x, y))
        cv2.circle(labels, (round(col), round(row)), round(radius * pixels_per_unit), UNKNOWN, -1)
    return Scene(grid, labels)
