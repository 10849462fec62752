"""Creases that a sheet has before its first photo: of folds that were made and undone."""

import numpy as np

from folding_server.geometry.line import Point
from folding_server.photographer.levels import Level
from folding_server.photographer.rng import stream

EarlierCrease = tuple[Point, Point]
"""A crease by its ends on the sheet."""


def earlier_creases(seed: int, level: Level, sheet: tuple[float, float]) -> tuple[EarlierCrease, ...]:
    """Some of the lines that models begin with: diagonals, halves and quarters of a sheet (width, height); none at levels without."""
    if level.precreases == 0:
        return ()
    w, h = sheet
    halves = [((w / 2, 0.0), (w / 2, h)), ((0.0, h / 2), (w, h / 2))]
    diagonals = [((0.0, 0.0), (w, h)), ((0.0, h), (w, 0.0))]
    quarters = [((w * part, 0.0), (w * part, h)) for part in (0.25, 0.75)]
    known: list[EarlierCrease] = [*halves, *diagonals, *quarters]
    rng: np.random.Generator = stream(seed, "earlier creases")
    count = int(rng.integers(1, level.precreases + 1))
    return tuple(known[number] for number in sorted(rng.permutation(len(known))[:count]))
