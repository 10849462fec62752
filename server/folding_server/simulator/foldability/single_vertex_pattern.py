"""Crease patterns of which all creases meet in one vertex: a layer order without comparing every face with every other."""

from dataclasses import dataclass
from math import atan2, tau

import numpy as np

from folding_server.arrays import Bools, Floats, Ints
from folding_server.simulator.foldability.equations import FacePair
from folding_server.simulator.foldability.flat_faces import FlatFaces
from folding_server.simulator.foldability.pattern import FOLDED_ASSIGNMENTS
from folding_server.simulator.foldability.sectors import VertexSectors, sectors_around
from folding_server.simulator.foldability.single_vertex import (
    layers_cross,
    sector_reach,
    sector_stack,
    tolerances,
)

MANY_CREASES = 150
"""Creases at the vertex from which on the order is found so: for fewer the general way takes less than half a second."""
ASIDE = 1e-3
"""Radians by which a face may reach out of its sector by rounding."""


@dataclass(frozen=True)
class SectorOrder:
    """A layer order: ``lying`` (lower, upper) of all overlapping faces, ``stack`` all faces bottom to top, and whether it is
    certain that there is no other.
    """

    lying: tuple[FacePair, ...]
    stack: tuple[int, ...]
    only: bool


def single_vertex_order(flat: FlatFaces) -> SectorOrder | None:
    """A layer order of a pattern of which all creases, many of them, meet in one vertex; None of any other pattern.

    What holds near the vertex holds everywhere, as every face stays within its sector: further out the same layers lie on
    each other, or fewer.
    """
    around = _single_vertex(flat)
    if around is None:
        return None
    for equal in reversed(list(tolerances())):
        stack = sector_stack(around, equal)
        if stack is not None and not layers_cross(around, stack, equal):
            return _order(flat, around, stack, equal)
    return None


def _single_vertex(flat: FlatFaces) -> VertexSectors | None:
    """The sectors around the vertex in which all creases meet, if there is one and each sector is one face."""
    pattern = flat.pattern
    folded = sum(letter in FOLDED_ASSIGNMENTS for letter in pattern.edges_assignment)
    if folded < MANY_CREASES:
        return None
    for around in sectors_around(pattern, folded):
        faces = [face for corners in around.corners for face in corners]
        if len(faces) == len(around.angles) == len(pattern.cycles) and _within(flat, around):
            return around
    return None


def _within(flat: FlatFaces, around: VertexSectors) -> bool:
    """Whether each face lies between the two directions of its sector, as seen from the vertex."""
    x, y = flat.pattern.vertices_coords[around.vertex]
    for (face,), angle in zip(around.corners, around.angles, strict=True):
        cycle = flat.pattern.cycles[face]
        start = cycle.index(around.vertex)
        turns = [
            atan2(v - y, u - x)
            for u, v in (flat.pattern.vertices_coords[w] for w in (*cycle[start + 1 :], *cycle[:start]))
        ]
        if any((turn - turns[0] + ASIDE) % tau > angle + 2 * ASIDE for turn in turns):
            return False
    return True


def _order(flat: FlatFaces, around: VertexSectors, stack: list[int], equal: float) -> SectorOrder:
    """A stack of sectors as a layer order of the faces, with the first face of the pattern front up."""
    faces = np.array([face for (face,) in around.corners], int)
    upwards = np.array(stack[::-1] if flat.mirrored[int(faces[0])] else stack, int)
    reach = sector_reach(around)[upwards]
    numbers = faces[upwards]
    below = np.zeros((len(numbers), len(numbers)), bool)
    below[np.ix_(numbers, numbers)] = _overlapping(reach, equal)
    lower, upper = np.nonzero(below)
    lying = tuple(zip(lower.tolist(), upper.tolist(), strict=True))
    return SectorOrder(lying, tuple(numbers.tolist()), _only(around, upwards, reach, equal))


def _overlapping(reach: Floats, equal: float) -> Bools:
    """(n, n): whether the sector at each height overlaps one higher up by more than ``equal`` radians."""
    common = np.minimum(reach[:, None, 1], reach[None, :, 1]) - np.maximum(
        reach[:, None, 0], reach[None, :, 0]
    )
    return np.asarray(np.triu(common > equal, 1))


def _only(around: VertexSectors, upwards: Ints, reach: Floats, equal: float) -> bool:
    """Whether letters say of each two sectors on each other which is lower, and all overlap in one place."""
    count = len(upwards)
    apart = np.abs(np.diff(upwards))
    beside = (apart == 1) | ((apart == count - 1) & around.closed)
    lettered = "U" not in around.letters
    return bool(lettered and beside.all() and reach[:, 1].min() - reach[:, 0].max() > equal)
