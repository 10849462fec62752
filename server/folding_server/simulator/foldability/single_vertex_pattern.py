"""Crease patterns of which all creases meet in one vertex: a layer order without comparing every face with every other."""

from dataclasses import dataclass
from math import tau

import numpy as np
import shapely

from folding_server.arrays import Bools, Floats, Ints
from folding_server.geometry.graph import component_of
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
from folding_server.simulator.foldability.tolerances import first_tolerance
from folding_server.simulator.validity.contacts import overlapping

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
    each other, or fewer. Marks may divide sectors, and creases, into several.
    """
    folded = sum(letter in FOLDED_ASSIGNMENTS for letter in flat.pattern.edges_assignment)
    for around in sectors_around(flat.pattern, MANY_CREASES) if folded >= MANY_CREASES else ():
        sectors = _sectors_of_faces(flat, around)
        if sectors is not None and _within(flat, around, sectors):
            return _found_order(flat, around, sectors)
    return None


def _found_order(flat: FlatFaces, around: VertexSectors, sectors: Ints) -> SectorOrder | None:
    for equal in reversed(list(tolerances())):
        stack = sector_stack(around, equal)
        if stack is not None and not layers_cross(around, stack, equal):
            return _order(flat, around, sectors, stack, equal)
    return None


def _sectors_of_faces(flat: FlatFaces, around: VertexSectors) -> Ints | None:
    """The sector that each face lies in, by its marks and creases; None if there are others."""
    faces, count = range(len(flat.outlines)), len(around.angles)
    joined = component_of(faces, [(c.left, c.right) for c in flat.creases if not c.folded])
    sector_of = {joined[face]: k for k, corners in enumerate(around.corners) for face in corners}
    if len(sector_of) != count or any(joined[face] not in sector_of for face in faces):
        return None
    sectors = np.array([sector_of[joined[face]] for face in faces], int)
    beside = {frozenset({k, (k + 1) % count}): letter for k, letter in enumerate(around.letters)}
    alike = all(
        beside.get(frozenset(sectors[[crease.left, crease.right]].tolist())) == crease.assignment
        for crease in flat.creases
        if crease.folded
    )
    return sectors if alike else None


def _within(flat: FlatFaces, around: VertexSectors, sectors: Ints) -> bool:
    """Whether each face lies between the two directions of its sector, as seen from the vertex."""
    cycles = flat.pattern.cycles
    first = [cycles[corners[0]] for corners in around.corners]
    starts = np.array([cycle[(cycle.index(around.vertex) + 1) % len(cycle)] for cycle in first], int)
    vertex, sector = np.concatenate(cycles), np.repeat(sectors, [len(cycle) for cycle in cycles])
    vertex, sector = vertex[vertex != around.vertex], sector[vertex != around.vertex]
    arms = np.array(flat.pattern.vertices_coords, float) - flat.pattern.vertices_coords[around.vertex]
    turns = np.arctan2(arms[:, 1], arms[:, 0])
    turned = (turns[vertex] - turns[starts[sector]] + ASIDE) % tau
    return bool((turned <= np.array(around.angles)[sector] + 2 * ASIDE).all())


def _order(
    flat: FlatFaces, around: VertexSectors, sectors: Ints, stack: list[int], equal: float
) -> SectorOrder:
    """A stack of sectors as a layer order of the faces, with the first face of the pattern front up."""
    upwards = np.array(stack[::-1] if flat.mirrored[around.corners[0][0]] else stack, int)
    reach = sector_reach(around)[upwards]
    height = np.argsort(upwards)[sectors]
    numbers = np.argsort(height, kind="stable")
    marked = len(sectors) > len(stack)
    if marked:
        lower, upper = _lying(flat, height)
    else:
        below = np.zeros((len(numbers), len(numbers)), bool)
        below[np.ix_(numbers, numbers)] = _overlapping(reach, equal)
        lower, upper = np.nonzero(below)
    lying = tuple(zip(lower.tolist(), upper.tolist(), strict=True))
    return SectorOrder(lying, tuple(numbers.tolist()), not marked and _only(around, upwards, reach, equal))


def _lying(flat: FlatFaces, height: Ints) -> tuple[Ints, Ints]:
    """The lower and the upper of all overlapping faces of different heights, sorted."""
    outlines = np.array([shapely.Polygon(outline) for outline in flat.outlines])
    i, j = overlapping(outlines, first_tolerance(flat))
    i, j = i[height[i] != height[j]], j[height[i] != height[j]]
    lower, upper = np.where(height[i] < height[j], (i, j), (j, i))
    order = np.lexsort((upper, lower))
    return lower[order], upper[order]


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
