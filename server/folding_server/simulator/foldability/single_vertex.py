"""Whether the creases around a vertex fold flat by themselves, and how their layers lie."""

from collections.abc import Iterator

import numpy as np

from folding_server.arrays import Floats, Ints
from folding_server.simulator.foldability.crimping import crimped_stack
from folding_server.simulator.foldability.letter_choice import chosen_letters
from folding_server.simulator.foldability.sectors import VertexSectors

WIDEST_DIFFERENCE = 2e-3
"""Radians by which angles that are meant to be equal may differ at most, as for big-little-big."""
NEXT_TIMES = 0.25
"""Each next tolerance of angles, times the one before."""
TOLERANCES = 6
"""How many tolerances of angles are tried: the finest is 2e-6 radians, 1e-6 of a sheet's side."""


def tolerances(off: float = 0.0) -> Iterator[float]:
    """By how much equal angles may differ, in radians, coarse to fine."""
    for k in range(TOLERANCES):
        yield (WIDEST_DIFFERENCE + off) * NEXT_TIMES**k


def sector_stack(around: VertexSectors, equal: float) -> list[int] | None:
    """The sectors around a vertex bottom to top when folded flat, the first one front up; None if they cannot be.

    Angles that differ by less than ``equal`` radians count as equal.
    """
    letters = list(around.letters)
    if "U" in letters:
        chosen = chosen_letters(around.angles, letters, equal, closed=around.closed)
        if chosen is None:
            return None
        letters = chosen
    above = [(letter == "V") != (k % 2 == 1) for k, letter in enumerate(letters)]
    return crimped_stack(around.angles, above, equal, closed=around.closed)


def sector_reach(around: VertexSectors) -> Floats:
    """(n, 2): from where to where each sector reaches when folded flat, in radians, the smaller first."""
    turned = np.where(np.arange(len(around.angles)) % 2, -1.0, 1.0)
    ends = np.concatenate([[0.0], np.cumsum(turned * around.angles)])
    return np.sort(np.stack([ends[:-1], ends[1:]], axis=1), axis=1)


def layers_cross(around: VertexSectors, stack: list[int], equal: float) -> bool:
    """Whether a stack has layers that pass through a crease, or creases on one line that interleave.

    This is what ``constraints`` asks, of angles instead of faces: taco-tortilla and taco-taco.
    """
    reach, rank = sector_reach(around), np.argsort(stack)
    creases = np.arange(len(around.letters))
    before, after = creases, (creases + 1) % len(around.angles)
    at = np.where(creases % 2 == 0, reach[creases, 1], reach[creases, 0])
    low, high = np.minimum(rank[before], rank[after]), np.maximum(rank[before], rank[after])
    return any(
        _crosses(crease, at, low, high, equal)
        or _spanned(at[crease], low[crease], high[crease], reach, rank, equal)
        for crease in range(len(creases))
    )


def _spanned(at: float, low: int, high: int, reach: Floats, rank: Ints, equal: float) -> bool:
    """Whether a sector between the two beside a crease reaches across it."""
    between = (rank > low) & (rank < high)
    return bool((between & (reach[:, 0] < at - equal) & (reach[:, 1] > at + equal)).any())


def _crosses(crease: int, at: Floats, low: Ints, high: Ints, equal: float) -> bool:
    """Whether another crease on the same line, open to the same side, has one of its sectors between the two of this one."""
    beside = (np.abs(at - at[crease]) < equal) & (np.arange(len(at)) % 2 == crease % 2)
    inside = [(row > low[crease]) & (row < high[crease]) for row in (low, high)]
    outside = [(row < low[crease]) | (row > high[crease]) for row in (low, high)]
    return bool((beside & (inside[0] & outside[1] | inside[1] & outside[0])).any())
