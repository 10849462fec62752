"""How the table and the two sides of the sheet look, and how badly a picture's pixels fit each of them."""

from dataclasses import dataclass

import numpy as np

from folding_server.arrays import Floats, Image
from folding_server.vision.grid import Grid
from folding_server.vision.surfaces import Surface

LAB_FLOOR = (6.0, 3.0, 3.0)
"""Variance that noise and compression add to L, a and b, at least."""
DEEPEST_SHADOW = 0.45
"""Least share of its distance from BLACK that a shadow leaves a colour."""
BLACK = np.array([-16, 0, 0], np.float32)
"""Where in Lab shadows end: light scales the distance of a colour from there."""
SHADOW_COST = 4.0
"""Cost, in nats, of saying that a pixel lies in shadow."""


def coordinates(grid: Grid) -> tuple[Floats, Floats]:
    """Column and row coordinates of a grid, about -1 to 1 over the part of the table that is used."""
    columns = grid.left + (np.arange(grid.cols) + 0.5) / grid.pixels_per_unit
    rows = grid.top - (np.arange(grid.rows) + 0.5) / grid.pixels_per_unit
    return np.asarray((columns - 0.5) / 1.3, np.float64), np.asarray((rows - 0.5) / 1.3, np.float64)


@dataclass(frozen=True)
class Look:
    """One class: surfaces for its colours (several if it is patterned) and whether shadows may fall on it."""

    surfaces: tuple[Surface, ...]

    def cost(self, lab: Image, grid: Grid, shadows: bool = True) -> Image:
        """How badly each pixel fits, (rows, cols), in nats; without ``shadows`` only plain light counts."""
        columns, rows = coordinates(grid)
        costs = [pixel_cost(lab, s.on(columns, rows), s.covariance, shadows) for s in self.surfaces]
        return np.asarray(np.minimum.reduce(costs), np.float32)

    def strangeness(self, lab: Image, grid: Grid) -> Image:
        """Distance in Lab of each pixel from the nearest lit or shaded colour of the class, (rows, cols)."""
        columns, rows = coordinates(grid)
        distances = [shaded_distance(lab, s.on(columns, rows)) for s in self.surfaces]
        return np.asarray(np.minimum.reduce(distances), np.float32)


@dataclass(frozen=True)
class ColourModels:
    """The colour models of table, front and back. ``back`` is None if the sides look alike or the back was never seen."""

    table: Look
    front: Look
    back: Look | None

    @property
    def looks(self) -> tuple[Look, ...]:
        """Table, front and, if there is one, back, in the order of their labels."""
        return (self.table, self.front) if self.back is None else (self.table, self.front, self.back)


def shaded_distance(lab: Image, expected: Image) -> Image:
    """Distance in Lab of each pixel from its expected colour, or what a shadow leaves of it, (rows, cols)."""
    ray, seen = expected - BLACK, lab - BLACK
    share = np.einsum("...i,...i->...", ray, seen) / np.einsum("...i,...i->...", ray, ray)
    residual = seen - ray * np.clip(share, DEEPEST_SHADOW, 1.05)[..., None]
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", residual, residual)), np.float32)


def pixel_cost(lab: Image, expected: Image, covariance: Floats, shadows: bool = True) -> Image:
    """Half the squared Mahalanobis distance, or the cost of a shadow of the expected colour if less."""
    inverse = np.linalg.inv(covariance + np.diag(LAB_FLOOR)).astype(np.float32)
    lit = _quadratic(lab - expected, inverse)
    if not shadows:
        return lit
    ray, seen = expected - BLACK, lab - BLACK
    share = np.einsum("...i,...i->...", ray, seen) / np.einsum("...i,...i->...", ray, ray)
    np.clip(share, DEEPEST_SHADOW, 1.0, out=share)
    shaded = _quadratic(seen - ray * share[..., None], inverse)
    shaded += SHADOW_COST * (1 + 2 * (1 - share))
    return np.minimum(lit, shaded)


def _quadratic(residual: Image, inverse: Image) -> Image:
    """0.5 r' A r for every pixel."""
    return np.asarray(0.5 * np.einsum("...i,...i->...", residual @ inverse, residual), np.float32)
