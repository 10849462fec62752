"""What faces and creases may touch, looked up once for one tolerance after the other."""

from functools import cached_property

import numpy as np
import shapely

from folding_server.arrays import Bools, Geometries, Ints
from folding_server.simulator.foldability.flat_faces import FlatFaces
from folding_server.simulator.foldability.pair_table import PairTable
from folding_server.simulator.validity.contacts import near_faces, near_pairs, overlap_by, run_through

HALVINGS = 6
"""How often the tolerance is halved in search of one at which nothing changes."""


class NearContacts:
    """Faces and creases of a flat-lying pattern that may touch, for a tolerance and finer ones, to its 64th part.

    What touches at a coarse tolerance does so at every finer one, and what does not at the finest does so at none: neither is looked
    at again. They are asked from coarse to fine.
    """

    def __init__(self, flat: FlatFaces, tolerance: float) -> None:
        self.flat, self.finest, self._asked = flat, tolerance / 2**HALVINGS, tolerance
        self.outlines: Geometries = np.array([shapely.Polygon(outline) for outline in flat.outlines])
        self.pairs = near_pairs(self.outlines)
        self.found: Bools | None = None

    def overlapping(self, tolerance: float) -> Ints:
        """(n, 2): the pairs i < j of faces that overlap by more than the tolerance, ascending."""
        if self.found is None:
            self.found = overlap_by(self.outlines, self.pairs, tolerance)
            kept = self.found.copy()
            kept[~kept] = overlap_by(self.outlines, self.pairs[:, ~kept], self.finest)
            self.pairs, self.found = self.pairs[:, kept], self.found[kept]
        else:
            found = self.found.copy()
            found[~found] = overlap_by(self.outlines, self.pairs[:, ~found], tolerance)
            self.found = found
        return np.ascontiguousarray(self.pairs[:, self.found].T)

    @cached_property
    def creases(self) -> Ints:
        """(2, n): creases with the faces that they may run through, of those that may overlap both faces beside the crease."""
        found = np.asarray(near_faces(self.flat.segments, self.outlines))
        table = PairTable(self.pairs.T, len(self.outlines))
        for beside in zip(*((crease.left, crease.right) for crease in self.flat.creases), strict=True):
            found = found[:, table.has(np.array(beside, int)[found[0]], found[1])]
        return found

    @cached_property
    def _runs(self) -> np.ndarray:
        """(n,): of ``creases``, 1 where one was found to run through the face, -1 where it does at no tolerance to come."""
        return np.zeros(self.creases.shape[1], np.int8)

    def run_through(self, chosen: Ints, tolerance: float) -> Bools:
        """(k,): whether those of ``creases`` with these numbers run through the inside of the face for more than the tolerance."""
        if tolerance > self._asked:
            return self._running(chosen, tolerance)
        self._asked = tolerance
        open_ = chosen[self._runs[chosen] == 0]
        found = self._running(open_, tolerance)
        self._runs[open_[found]] = 1
        rest = open_[~found]
        self._runs[rest[~self._running(rest, self.finest)]] = -1
        return np.asarray(self._runs[chosen] == 1)

    def _running(self, chosen: Ints, tolerance: float) -> Bools:
        return run_through(self.flat.segments, self.outlines, self.creases[:, chosen], tolerance)
