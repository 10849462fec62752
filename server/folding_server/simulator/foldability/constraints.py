"""The conditions on layer orders, as equations between the orders of pairs of overlapping faces.

Write [x, y] for "x lies below y". A fold (a, b) and a face c that spans it: c is not between them, [a, c] = [b, c].
Two flat pairs, or a flat pair and a face that spans it, along one line: [a, c] = [b, d]. Two folds (a, b), (c, d) on one
side of a line do not interleave: an even number of [a, c], [b, c], [a, d], [b, d] holds. What remains is transitivity
among faces that share a cell; the search sees to that. (Taco-taco, taco-tortilla, tortilla-tortilla and transitivity of
Akitaya et al., "Simple folding is really hard", and of Flat-Folder.)
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
import shapely

from folding_server.arrays import Bools, Ints
from folding_server.simulator.foldability.equations import FacePair, Rows
from folding_server.simulator.foldability.flat_faces import FlatFaces
from folding_server.simulator.foldability.near_contacts import NearContacts
from folding_server.simulator.foldability.pair_table import PairTable
from folding_server.simulator.foldability.sweep import sweep
from folding_server.simulator.validity.contacts import (
    along,
    cell_sets,
    shrunk,
)

ConditionKind = Literal["taco-taco", "taco-tortilla", "tortilla-tortilla"]


@dataclass(frozen=True)
class Conditions:
    """``pairs`` (n, 2) i < j of overlapping faces; ``known`` (n, 2) pairs that assignments fix, lower face first; ``equal``
    (n, 4) pairs of statements that are both true or both false; ``even`` (n, 8) quadruples of which an even number is
    true; ``cells``, for each face, a bit set of the cells it covers; ``reached``, for each face, when it is laid;
    ``beside``, for each face, one that it is joined to and that is laid before, -1 if there is none; ``counts``, how many
    conditions of each kind there are, each counted once for the faces that it is about, where that was asked for.
    """

    faces: int
    pairs: Rows
    known: Rows
    equal: Rows
    even: Rows
    cells: Sequence[int]
    reached: Sequence[int]
    beside: Sequence[int] = field(default=())
    counts: Mapping["ConditionKind", int] = field(default_factory=dict)


def conditions(flat: FlatFaces, tolerance: float) -> Conditions:
    """All conditions on the layer order of a flat-lying pattern; tolerance in units of the sheet's longer side."""
    contacts = Contacts(flat, tolerance)
    return replace(constraint_conditions(contacts), counts=contacts.counts)


def constraint_conditions(contacts: "Contacts") -> Conditions:
    """All conditions that follow from contacts."""
    reached = np.argsort(sweep(contacts.flat))
    return Conditions(
        len(contacts.outlines),
        contacts.pairs,
        contacts.known,
        contacts.equal,
        contacts.even,
        cell_sets(contacts.outlines, contacts.tolerance),
        reached.tolist(),
        _beside(contacts.flat, reached),
    )


def _beside(flat: FlatFaces, reached: Ints) -> list[int]:
    """For each face the first laid of those that it is joined to, -1 if none of them is laid before."""
    beside = [-1] * len(reached)
    when = reached.tolist()
    for crease in flat.creases:
        early, late = sorted((crease.left, crease.right), key=when.__getitem__)
        if beside[late] < 0 or when[early] < when[beside[late]]:
            beside[late] = early
    return beside


def assigned_orders(flat: FlatFaces) -> Iterator[FacePair]:
    """The faces beside each mountain and valley, lower first.

    A valley has the front sides inside: the other face lies on the front of each. A mountain, on the back.
    """
    for crease in flat.creases:
        if crease.assignment in "MV":
            left_below = (crease.assignment == "V") != flat.mirrored[crease.left]
            yield (crease.left, crease.right) if left_below else (crease.right, crease.left)


class Contacts:
    """Where faces and creases of a flat-lying pattern touch, and the equations that follow, all of overlapping faces.

    ``thin`` faces are thinner than the tolerance: a flat pair with one does not reach across its crease.
    """

    def __init__(self, flat: FlatFaces, tolerance: float, coarser: "Contacts | None" = None) -> None:
        """``coarser`` are the contacts of the same faces at a larger tolerance: what overlaps there does so here, and what was too
        far apart there for any of the ``HALVINGS`` of a tolerance is so here.
        """
        self.flat, self.tolerance = flat, tolerance
        self.near: NearContacts = coarser.near if coarser else NearContacts(flat, tolerance)
        self.outlines = self.near.outlines
        self.pairs = self.near.overlapping(tolerance)
        self.left = np.array([crease.left for crease in flat.creases], int)
        self.right = np.array([crease.right for crease in flat.creases], int)
        self.folded = np.array([crease.folded for crease in flat.creases], bool)

    @property
    def size(self) -> tuple[int, int, int]:
        """How many pairs of faces overlap, and how many equations of each kind there are."""
        return len(self.pairs), len(self.equal), len(self.even)

    @property
    def counts(self) -> dict[ConditionKind, int]:
        """How many conditions of each kind there are, each counted once for the faces that it is about."""
        spans_fold = self.folded[self._spans[0]] if len(self._spans[0]) else np.zeros(0, bool)
        kept = self._spans_rows
        return {
            "taco-taco": len(_about(self.even[:, [0, 2, 1, 5]])),
            "taco-tortilla": len(_about(np.concatenate([kept[spans_fold], self._folds_and_flat_pairs]))),
            "tortilla-tortilla": len(_about(np.concatenate([kept[~spans_fold], self._flat_pairs]))),
        }

    def as_many(self, other: "Contacts") -> bool:
        """Whether as many pairs of faces overlap as in others, with as many equations, which are found only if they do."""
        return (
            len(other.pairs) == len(self.pairs)
            and len(other.equal) == len(self.equal)
            and len(other.even) == len(self.even)
        )

    @cached_property
    def _table(self) -> PairTable:
        return PairTable(self.pairs, len(self.outlines))

    def overlap(self, x: Ints, y: Ints) -> Bools:
        """Whether faces overlap, pair by pair."""
        return self._table.has(x, y)

    @cached_property
    def known(self) -> Ints:
        """(n, 2): what assignments say of faces that overlap, lower face first."""
        given = np.array(list(assigned_orders(self.flat)), int).reshape(-1, 2)
        return np.asarray(given[self.overlap(*given.T)])

    @cached_property
    def equal(self) -> Ints:
        """(n, 4): equations between two statements."""
        return np.concatenate([self._spans_rows, self._flat_pairs, self._folds_and_flat_pairs])

    @cached_property
    def even(self) -> Ints:
        """(n, 8): two folds on one side of a line do not interleave."""
        i, j, way = self._along
        both = self.folded[i] & self.folded[j]
        i, j, way = i[both], j[both], way[both]
        a, b, c, d = self.left[i], self.right[i], self.left[j], self.right[j]
        kept = self.flat.sides[i, 0] == self.flat.sides[j, 0] * way
        kept &= (a != c) & (a != d) & (b != c) & (b != d)
        rows = np.stack([a, c, b, c, a, d, b, d], axis=1)[kept]
        return np.asarray(rows[self._all_overlap(rows)])

    @cached_property
    def _spans(self) -> tuple[Ints, Ints]:
        """The creases that faces span, with the faces, of those that overlap both faces beside the crease."""
        if not self.flat.creases:
            return np.zeros(0, int), np.zeros(0, int)
        chosen = np.arange(self.near.creases.shape[1])
        for beside in (self.left, self.right):
            crease, face = self.near.creases[:, chosen]
            chosen = chosen[self.overlap(beside[crease], face)]
        crease, face = self.near.creases[:, chosen[self.near.run_through(chosen, self.tolerance)]]
        return crease, face

    @cached_property
    def _spans_rows(self) -> Ints:
        """A face that spans a crease is not between the two faces beside it."""
        crease, face = self._spans
        return np.stack([self.left[crease], face, self.right[crease], face], axis=1)

    @cached_property
    def _along(self) -> tuple[Ints, Ints, Ints]:
        """Pairs of creases that run along each other, and 1 where they point the same way, else -1."""
        if not self.flat.creases:
            return (np.zeros(0, int),) * 3
        (i, j), way = along(self.flat.segments, self.tolerance)
        return i, j, way

    @cached_property
    def _flat_pairs(self) -> Ints:
        i, j, way = self._along
        both = ~self.folded[i] & ~self.folded[j]
        i, j, way = i[both], j[both], way[both]
        turned = self.flat.sides[i, 0] != self.flat.sides[j, 0] * way
        c, d = self._turned(j, turned)
        return self._same(self.left[i], c, self.right[i], d)

    @cached_property
    def _folds_and_flat_pairs(self) -> Ints:
        i, j, way = self._along
        one = self.folded[i] ^ self.folded[j]
        i, j, way = i[one], j[one], way[one]
        fold, flat = np.where(self.folded[i], i, j), np.where(self.folded[i], j, i)
        turned = self.flat.sides[flat, 0] * way != self.flat.sides[fold, 0]
        inside, outside = self._turned(flat, turned)
        wide = ~self._thin[outside]
        return self._same(self.left[fold][wide], inside[wide], self.right[fold][wide], inside[wide])

    @cached_property
    def _thin(self) -> Bools:
        empty: Bools = np.asarray(shapely.is_empty(shrunk(self.outlines, self.tolerance / 2)))
        return empty

    def _turned(self, crease: Ints, turned: Bools) -> tuple[Ints, Ints]:
        """The faces beside creases, the right one first where turned."""
        left, right = self.left[crease], self.right[crease]
        return np.where(turned, right, left), np.where(turned, left, right)

    def _same(self, a: Ints, b: Ints, c: Ints, d: Ints) -> Ints:
        """[a, b] = [c, d], for those that are about overlapping faces."""
        rows = np.stack([a, b, c, d], axis=1)[(a != b) & (c != d)]
        return np.asarray(rows[self._all_overlap(rows)])

    def _all_overlap(self, rows: Ints) -> Bools:
        """Whether the faces of every statement of a row overlap."""
        return np.asarray(self.overlap(rows[:, ::2], rows[:, 1::2]).all(axis=1))


def _about(rows: Ints) -> Ints:
    """Rows (n, 4) of two pairs of faces, each once whichever way round pairs and faces stand."""
    pairs = np.sort(rows.reshape(-1, 2, 2), axis=2)
    turned = (pairs[:, 0, 0] > pairs[:, 1, 0]) | (
        (pairs[:, 0, 0] == pairs[:, 1, 0]) & (pairs[:, 0, 1] > pairs[:, 1, 1])
    )
    pairs[turned] = pairs[turned][:, ::-1]
    return np.unique(pairs.reshape(-1, 4), axis=0)
