"""The looks of table and paper under the light of one photo."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from folding_server.arrays import Bools, Floats, Image, Mask
from folding_server.vision.appearance import BLACK, ColourModels, Look, coordinates, pixel_cost
from folding_server.vision.colours import lab_to_rgb, skin
from folding_server.vision.grid import Grid
from folding_server.vision.obstacles import touching_edge
from folding_server.vision.surfaces import Surface, fit_surface

SHADOW_FREE = 4.0
"""Cost below which a pixel shows its class in plain light."""
ODD_LIGHT = 12.0
"""The same before it is known how the light has changed."""
FARTHEST_SHIFT = 12.0
"""How far, in Lab, light may move a side's colour between photos."""
ONE_LIGHT = 5.0
"""How much otherwise, in Lab, than the table's the light may move a colour like skin's: by more, it is a hand that is seen."""
FEWEST_CLASS_PIXELS, FEWEST_LIKELY = 40, 0.1
"""Pixels that are surely of a class from which it can be fitted, and the share of them that one light must explain."""


@dataclass(frozen=True)
class _Sample:
    """Every few pixels of a photo: ``lab`` (rows, cols, 3) at the coordinates ``x``, ``y`` (rows, cols)."""

    lab: Image
    x: Floats
    y: Floats

    @cached_property
    def skin(self) -> Bools:
        """Pixels whose colour skin can have, (rows, cols)."""
        return _skin(self.lab)

    def cost(self, look: Look) -> Image:
        """A look's cost at each pixel."""
        costs = [pixel_cost(self.lab, s.at(self.x, self.y), s.covariance) for s in look.surfaces]
        return np.asarray(np.minimum.reduce(costs), np.float32)


def adapt(lab: Image, seen: Mask, grid: Grid, palette: ColourModels) -> ColourModels:
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
        sides = _shifted(tuned.looks, sample, own)
        tuned = ColourModels(
            _table(tuned.table, sample, own[0]), sides[0], sides[1] if len(sides) > 1 else None
        )
    return tuned


def _table(look: Look, sample: _Sample, own: Bools) -> Look:
    """The table fitted to the pixels that are surely its own; as it was if they are few, or it has several surfaces."""
    if own.sum() < FEWEST_CLASS_PIXELS or len(look.surfaces) > 1:
        return look
    fitted = fit_surface(sample.x[own], sample.y[own], sample.lab[own].astype(np.float64), 2)
    spread = 0.5 * (fitted.covariance + look.surfaces[0].covariance)
    return Look((Surface(2, fitted.coefficients, spread, fitted.span),))


def _shifted(looks: Sequence[Look], sample: _Sample, owned: Sequence[Bools]) -> list[Look]:
    """The sides of the sheet, given with the table before them, as light has moved them.

    A hand must not pass for paper in another light: skin tells nothing of a side of another colour, and a side of about that
    colour is believed to have moved as the table has.
    """
    sides = []
    table = _shift(_left(looks[0], sample, owned[0]))
    for look, own in zip(looks[1:], owned[1:], strict=True):
        if len(look.surfaces) > 1:
            sides.append(look)
            continue
        if _is_skin(look):
            shift = _believed(_left(look, sample, own), table, _lightness(look) / _lightness(looks[0]))
        else:
            shift = _shift(_left(look, sample, own & ~sample.skin))
        sides.append(Look((_moved(look.surfaces[0], shift),)))
    return sides


def _believed(left: Floats, table: Floats, ratio: float) -> Floats:
    """A side's shift by those of its pixels (N, 3) for which light that has moved the table so can be the reason; if they are
    few, what such light does to the side.

    Light adds to all colours alike, or in proportion to how light they are: ``ratio`` times as much as to the table.
    """
    low, high = sorted((1.0, ratio))
    along = np.clip(left @ table / max(float(table @ table), 1e-9), low, high)
    likely = left[np.linalg.norm(left - along[:, None] * table, axis=1) <= ONE_LIGHT]
    return (
        _shift(likely) if len(likely) >= max(FEWEST_CLASS_PIXELS, FEWEST_LIKELY * len(left)) else table * low
    )


def _is_skin(look: Look) -> bool:
    """Whether the colour of a look is one that skin can have."""
    return bool(_skin(look.surfaces[0].coefficients[:1].reshape(1, 1, 3)).any())


def _skin(lab: npt.NDArray[np.floating]) -> Bools:
    """Pixels in Lab, (rows, cols, 3), whose colour skin can have."""
    return skin(lab_to_rgb(lab).astype(np.uint8))


def _lightness(look: Look) -> float:
    """The lightness of a look in the middle of the table, from BLACK on."""
    return float(look.surfaces[0].coefficients[0][0] - BLACK[0])


def _left(look: Look, sample: _Sample, own: Bools) -> Floats:
    """What a look leaves of its pixels' colours, (N, 3)."""
    left = np.stack([sample.lab[own] - s.at(sample.x[own], sample.y[own]) for s in look.surfaces])
    nearest = np.linalg.norm(left, axis=-1).argmin(axis=0)
    return np.asarray(left[nearest, np.arange(left.shape[1])], np.float64)


def _shift(left: Floats) -> Floats:
    """How light has moved a colour, (3,), by what is left of pixels that are surely its own; 0 if they are few."""
    if len(left) < FEWEST_CLASS_PIXELS:
        return np.zeros(3)
    shift = np.median(left, axis=0)
    return np.asarray(shift * min(1.0, FARTHEST_SHIFT / max(float(np.linalg.norm(shift)), 1e-9)))


def _moved(surface: Surface, shift: Floats) -> Surface:
    coefficients = surface.coefficients.copy()
    coefficients[0] += shift
    return Surface(surface.order, coefficients, surface.covariance, surface.span)
