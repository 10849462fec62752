"""The conditions on layer orders, as equations between the orders of pairs of overlapping faces.

Write [x, y] for "x lies below y". A fold (a, b) and a face c that spans it: c is not between them, [a, c] = [b, c].
Two flat pairs, or a flat pair and a face that spans it, along one line: [a, c] = [b, d]. Two folds (a, b), (c, d) on one
side of a line do not interleave: an even number of [a, c], [b, c], [a, d], [b, d] holds. What remains is transitivity
among faces that share a cell; the search sees to that. (Taco-taco, taco-tortilla, tortilla-tortilla and transitivity of
Akitaya et al., "Simple folding is really hard", and of Flat-Folder.)
"""

from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import shapely

from folding_server.arrays import Geometries
from folding_server.simulator.foldability.equations import FacePair
from folding_server.simulator.foldability.flat_faces import FlatFaces
from folding_server.simulator.validity.contacts import along, cells, overlapping, shrunk, through

ConditionKind = Literal["taco-taco", "taco-tortilla", "tortilla-tortilla"]


@dataclass(frozen=True)
class Conditions:
    """``pairs`` i < j of overlapping faces; ``known`` pairs that assignments fix, lower face first; ``equal`` pairs of
    statements that are both true or both false; ``even`` quadruples of which an even number is true; ``cells``, for each
    face, a bit set of the cells it covers; ``reached``, for each face, when a walk from face to face comes to it;
    ``counts``, how many conditions of each kind there are, each counted once for the faces that it is about.
    """

    faces: int
    pairs: frozenset[FacePair]
    known: tuple[FacePair, ...]
    equal: frozenset[tuple[FacePair, FacePair]]
    even: frozenset[tuple[FacePair, FacePair, FacePair, FacePair]]
    cells: tuple[int, ...]
    reached: tuple[int, ...]
    counts: Mapping[ConditionKind, int] = field(default_factory=dict)


def conditions(flat: FlatFaces, tolerance: float) -> Conditions:
    """All conditions on the layer order of a flat-lying pattern; tolerance in units of the sheet's longer side."""
    outlines = np.array([shapely.Polygon(outline) for outline in flat.outlines])
    pairs = frozenset((int(i), int(j)) for i, j in overlapping(outlines, tolerance).T)
    cover = cells(outlines, tolerance)
    builder = _Builder(flat, pairs, np.flatnonzero(shapely.is_empty(shrunk(outlines, tolerance / 2))))
    equal = frozenset(builder.equal(tolerance, outlines))
    return Conditions(
        len(outlines),
        pairs,
        tuple(builder.known()),
        equal,
        frozenset(builder.even),
        tuple(int.from_bytes(np.packbits(row).tobytes(), "big") for row in cover),
        tuple(int(k) for k in np.argsort(flat.walk)),
        {kind: len(about) for kind, about in builder.about.items()},
    )


def assigned_orders(flat: FlatFaces) -> Iterator[FacePair]:
    """The faces beside each mountain and valley, lower first.

    A valley has the front sides inside: the other face lies on the front of each. A mountain, on the back.
    """
    for crease in flat.creases:
        if crease.assignment in "MV":
            left_below = (crease.assignment == "V") != flat.mirrored[crease.left]
            yield (crease.left, crease.right) if left_below else (crease.right, crease.left)


class _Builder:
    """Collects equations whose statements are all about overlapping pairs; ``even`` and ``about``, which faces each kind of
    condition is about, fill while ``equal`` is read.

    ``thin`` faces are thinner than the tolerance: a flat pair with one does not reach across its crease.
    """

    def __init__(self, flat: FlatFaces, pairs: frozenset[FacePair], thin: Iterable[int]) -> None:
        self.flat, self.pairs, self.thin = flat, pairs, frozenset(thin)
        self.even: set[tuple[FacePair, FacePair, FacePair, FacePair]] = set()
        self.about: dict[ConditionKind, set[Hashable]] = {
            "taco-taco": set(),
            "taco-tortilla": set(),
            "tortilla-tortilla": set(),
        }

    def overlap(self, *pairs: FacePair) -> bool:
        """Whether all pairs are of faces that overlap."""
        return all((min(p), max(p)) in self.pairs for p in pairs)

    def known(self) -> Iterator[FacePair]:
        """What assignments say of faces that overlap."""
        return (pair for pair in assigned_orders(self.flat) if self.overlap(pair))

    def equal(self, tolerance: float, outlines: Geometries) -> Iterator[tuple[FacePair, FacePair]]:
        """Equations between two statements."""
        if not self.flat.creases:
            return
        segments = self.flat.segments
        for i, c in through(segments, outlines, tolerance).T:
            a, b = self._beside(int(i))
            kind: ConditionKind = "taco-tortilla" if self.flat.creases[i].folded else "tortilla-tortilla"
            yield from self._same(kind, (a, int(c)), (b, int(c)))
        pairs, ways = along(segments, tolerance)
        for (i, j), way in zip(pairs.T, ways, strict=True):
            yield from self._along(int(i), int(j), int(way))

    def _same(
        self, kind: ConditionKind, first: FacePair, second: FacePair
    ) -> Iterator[tuple[FacePair, FacePair]]:
        if len({*first}) == 2 == len({*second}) and self.overlap(first, second):
            self.about[kind].add(frozenset({frozenset(first), frozenset(second)}))
            yield first, second

    def _along(self, i: int, j: int, way: int) -> Iterator[tuple[FacePair, FacePair]]:
        """Two creases along one line, ``way`` 1 if they point the same way."""
        folded = (self.flat.creases[i].folded, self.flat.creases[j].folded)
        if folded == (True, True):
            self._two_folds(i, j, way)
        elif folded == (False, False):
            yield from self._two_flat_pairs(i, j, way)
        else:
            yield from self._fold_and_flat_pair(*((i, j) if folded[0] else (j, i)), way)

    def _two_folds(self, i: int, j: int, way: int) -> None:
        (a, b), (c, d) = self._beside(i), self._beside(j)
        four = ((a, c), (b, c), (a, d), (b, d))
        one_side = self.flat.sides[i, 0] == self.flat.sides[j, 0] * way
        if one_side and len({a, b, c, d}) == 4 and self.overlap(*four):
            self.even.add(four)
            self.about["taco-taco"].add(frozenset({frozenset((a, b)), frozenset((c, d))}))

    def _two_flat_pairs(self, i: int, j: int, way: int) -> Iterator[tuple[FacePair, FacePair]]:
        (a, b), (c, d) = self._beside(i), self._beside(j)
        if self.flat.sides[i, 0] != self.flat.sides[j, 0] * way:
            c, d = d, c
        yield from self._same("tortilla-tortilla", (a, c), (b, d))

    def _fold_and_flat_pair(self, fold: int, flat: int, way: int) -> Iterator[tuple[FacePair, FacePair]]:
        (a, b), (inside, outside) = self._beside(fold), self._beside(flat)
        if self.flat.sides[flat, 0] * way != self.flat.sides[fold, 0]:
            inside, outside = outside, inside
        if outside not in self.thin:
            yield from self._same("taco-tortilla", (a, inside), (b, inside))

    def _beside(self, crease: int) -> FacePair:
        return self.flat.creases[crease].left, self.flat.creases[crease].right
