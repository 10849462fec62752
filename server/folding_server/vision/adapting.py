"""The looks of table and paper under the light of one photo."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from folding_server.vision.appearance import Look, Palette, coordinates, pixel_cost
from folding_server.vision.colours import Image
from folding_server.vision.grid import Floats, Grid
from folding_server.vision.mixing import Bools
from folding_server.vision.obstacles import touching_edge
from folding_server.vision.surfaces import Surface, fit_surface

SHADOW_FREE = 4.0
"""Cost below which a pixel shows its class in plain light."""
ODD_LIGHT = 12.0
"""The same before it is known how the light has changed."""
FARTHEST_SHIFT = 12.0
"""How far, in Lab, light may move a side's colour between photos."""
ONE_LIGHT = 9.0
"""How far apart, in Lab, the same light may move the colours of both sides: by more, one is something else's, a hand's."""
FEWEST = 40
"""Pixels that are surely of a class from which it can be fitted."""


@dataclass(frozen=True)
class _Sample:
    """Every few pixels of a photo: ``lab`` (rows, cols, 3) at the coordinates ``x``, ``y`` (rows, cols)."""

    lab: Image
    x: npt.NDArray[np.float64]
    y: npt.NDArray[np.float64]

    def cost(self, look: Look) -> Image:
        """A look's cost at each pixel."""
        costs = [pixel_cost(self.lab, s.at(self.x, self.y), s.covariance) for s in look.surfaces]
        return np.asarray(np.minimum.reduce(costs), np.float32)


def adapt(lab: Image, seen: Bools, grid: Grid, palette: Palette) -> Palette:
    """The palette under this photo's light: the table fitted afresh, the sides of the sheet shifted."""
    step = max(1, round(grid.pixels_per_unit / 32))
    coarse_seen = seen[::step, ::step]
    x, y = np.meshgrid(*(axis[::step] for axis in coordinates(grid)))
    sample = _Sample(np.ascontiguousarray(lab[::step, ::step]), x, y)
    tuned = palette
    for limit in (ODD_LIGHT, SHADOW_FREE):
        costs = np.stack([sample.cost(look) for look in tuned.looks], axis=-1)
        nearest, least = costs.argmin(axis=-1), costs.min(axis=-1)
        sure = coarse_seen & (least < limit)
        sure &= (nearest == 0) | ~touching_edge(sure & (nearest > 0), coarse_seen)
        own = [sure & (nearest == k) for k in range(costs.shape[-1])]
        sides = _shifted(tuned.looks[1:], sample, own[1:])
        tuned = Palette(_table(tuned.table, sample, own[0]), sides[0], sides[1] if len(sides) > 1 else None)
    return tuned


def _table(look: Look, sample: _Sample, own: Bools) -> Look:
    """The table fitted to the pixels that are surely its own; as it was if they are few, or it has several surfaces."""
    if own.sum() < FEWEST or len(look.surfaces) > 1:
        return look
    fitted = fit_surface(sample.x[own], sample.y[own], sample.lab[own].astype(np.float64), 2)
    spread = 0.5 * (fitted.covariance + look.surfaces[0].covariance)
    return Look((Surface(2, fitted.coefficients, spread, fitted.span),))


def _shifted(looks: Sequence[Look], sample: _Sample, owned: Sequence[Bools]) -> list[Look]:
    """The sides of the sheet as light has moved them; if it seems to move them apart, both as that of which more is seen."""
    shifts = [_shift(look, sample, own) for look, own in zip(looks, owned, strict=True)]
    if len(shifts) > 1 and all(s.any() for s in shifts) and np.linalg.norm(shifts[0] - shifts[1]) > ONE_LIGHT:
        most = max(range(len(shifts)), key=lambda k: int(owned[k].sum()))
        shifts = [shifts[most]] * len(shifts)
    return [
        Look(tuple(_moved(surface, shift) for surface in look.surfaces))
        for look, shift in zip(looks, shifts, strict=True)
    ]


def _shift(look: Look, sample: _Sample, own: Bools) -> Floats:
    """How light has moved a side's colour, (3,), by the pixels that are surely its own; 0 where that cannot be told."""
    if own.sum() < FEWEST or len(look.surfaces) > 1:
        return np.zeros(3)
    expected = look.surfaces[0].at(sample.x[own], sample.y[own])
    shift = np.median(sample.lab[own] - expected, axis=0).astype(np.float64)
    return np.asarray(shift * min(1.0, FARTHEST_SHIFT / max(float(np.linalg.norm(shift)), 1e-9)))


def _moved(surface: Surface, shift: Floats) -> Surface:
    coefficients = surface.coefficients.copy()
    coefficients[0] += shift
    return Surface(surface.order, coefficients, surface.covariance, surface.span)
