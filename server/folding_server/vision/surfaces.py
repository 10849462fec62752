"""A colour that varies smoothly, as a lamp makes it: robust fits of low-order polynomials."""

from dataclasses import dataclass

import numpy as np

from folding_server.arrays import Float32s, Floats

_TERMS = {0: 1, 1: 3, 2: 6}
_SAMPLES = 12_000
"""Pixels that a surface is fitted to, at most."""
_ROUNDS = 5
"""Rounds in which outliers are weighted down."""


def basis(x: Floats, y: Floats, order: int) -> Floats:
    """The monomials up to an order of coordinates of any shape, on a new last axis."""
    ones = np.ones_like(x)
    terms = [ones, x, y, x * x, x * y, y * y][: _TERMS[order]]
    return np.stack(terms, axis=-1)


@dataclass(frozen=True)
class Surface:
    """A polynomial colour surface with the spread of the colours about it.

    ``coefficients`` is (terms, 3); ``covariance`` (3, 3); ``span`` bounds the coordinates (low x, low y, high
    x, high y): beyond them the surface goes on flat.
    """

    order: int
    coefficients: Floats
    covariance: Floats
    span: tuple[float, float, float, float]

    def at(self, x: Floats, y: Floats) -> Float32s:
        """The colour at coordinates of any shape, (..., 3) float32."""
        low_x, low_y, high_x, high_y = self.span
        terms = basis(np.clip(x, low_x, high_x), np.clip(y, low_y, high_y), self.order)
        return (terms.astype(np.float32) @ self.coefficients.astype(np.float32)).astype(np.float32)

    def on(self, columns: Floats, rows: Floats) -> Float32s:
        """The colour over a raster with these column and row coordinates, (rows, cols, 3) float32."""
        low_x, low_y, high_x, high_y = self.span
        x, y = np.meshgrid(np.clip(columns, low_x, high_x), np.clip(rows, low_y, high_y))
        return self.at(x, y)


def fit_surface(x: Floats, y: Floats, colours: Floats, order: int) -> Surface:
    """Fit (N,) coordinates and (N, 3) colours; outliers up to nearly half of the samples are ignored."""
    step = max(1, len(x) // _SAMPLES)
    x, y, colours = x[::step], y[::step], np.asarray(colours[::step], np.float64)
    terms = basis(x, y, order)
    coefficients = np.zeros((terms.shape[1], 3))
    coefficients[0] = np.median(colours, axis=0)
    weights = np.ones(len(x))
    for _ in range(_ROUNDS):
        residual = colours - terms @ coefficients
        distance = np.linalg.norm(residual, axis=1)
        scale = max(1.4826 * float(np.median(distance)), 0.5)
        weights = np.clip(1 - (distance / (3.5 * scale)) ** 2, 0, None) ** 2
        weighted = terms * weights[:, None]
        ridge = 1e-6 * len(x) * np.eye(terms.shape[1])
        coefficients = np.linalg.solve(terms.T @ weighted + ridge, weighted.T @ colours)
    residual = (colours - terms @ coefficients)[weights > 0]
    covariance = residual.T @ residual / max(len(residual), 1)
    span = (float(x.min()), float(y.min()), float(x.max()), float(y.max()))
    return Surface(order, coefficients, covariance, span)
