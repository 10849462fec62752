"""Statements about pairs of faces that are equal or opposite, gathered into classes; what is left relates classes."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeVar

import numpy as np

from folding_server.arrays import Bools, Ints
from folding_server.simulator.foldability.classes import ContradictionError, SignedClasses

__all__ = ["CERTAIN", "ContradictionError", "Equations", "FacePair", "equations", "rows_of"]

T = TypeVar("T")

FacePair = tuple[int, int]
"""(x, y), read as the statement that face x lies below face y."""

Rows = Ints | Collection[object]
"""Rows of face numbers: an array, or tuples that hold as many."""

CERTAIN = 0
"""The class of what the conditions alone say, which is true."""


@dataclass(frozen=True)
class Equations:
    """Classes of statements, by number; class 0 is what is certain.

    ``codes``     face x -> face y -> twice the class of the statement [x, y], plus 1 if it holds where the class is true
    ``members``   class -> the statements that hold if the class is true
    ``parities``  (classes, odd): an odd or an even number of these classes is true
    ``watching``  class -> indices of the parities it is in
    ``pairs``     (n, 2): ``members`` of all classes, one after the other
    """

    codes: list[dict[int, int]]
    members: list[list[FacePair]]
    parities: list[tuple[tuple[int, ...], bool]]
    watching: list[list[int]]
    pairs: Ints

    def literal(self, x: int, y: int) -> tuple[int, bool]:
        """The class of the statement [x, y] and its value if the statement holds."""
        code = self.codes[x][y]
        return code >> 1, bool(code & 1)


def rows_of(rows: Rows, width: int) -> Ints:
    """Rows as an array (n, width)."""
    given = rows if isinstance(rows, np.ndarray) else np.array(sorted(rows), int)  # type: ignore[type-var]
    return np.asarray(given, int).reshape(-1, width)


class _Statements:
    """The statements about pairs of overlapping faces: number 0 is what is certain, then each pair x < y, sorted."""

    def __init__(self, pairs: Ints) -> None:
        self.pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
        self.width = int(pairs.max(initial=0)) + 1
        self.keys = self.pairs[:, 0] * self.width + self.pairs[:, 1]

    def number(self, x: Ints, y: Ints) -> tuple[Ints, Bools]:
        """The statements [x, y], all of them of overlapping faces, and whether each is the opposite of its number."""
        keys = np.minimum(x, y) * self.width + np.maximum(x, y)
        return np.searchsorted(self.keys, keys) + 1, x > y


def equations(pairs: Rows, equal: Rows, even: Rows, known: Rows = ()) -> Equations:
    """Gather statements into classes; ContradictionError if the equations alone have no solution.

    ``pairs`` (n, 2) overlapping faces, ``equal`` (n, 4) two statements each, ``even`` (n, 8) four statements of which an
    even number holds, ``known`` (n, 2) statements that hold.
    """
    statements = _Statements(rows_of(pairs, 2))
    classes = SignedClasses(len(statements.pairs) + 1)
    (a, b, c, d), (x, y) = rows_of(equal, 4).T, rows_of(known, 2).T
    (p, not_p), (q, not_q), (r, not_r) = (statements.number(*s) for s in ((a, b), (c, d), (x, y)))
    certain = np.zeros(len(r), int)
    classes.join((np.append(p, certain), np.append(q, r), np.append(not_p ^ not_q, not_r)))
    four = rows_of(even, 8)
    numbers, opposite = statements.number(four[:, ::2], four[:, 1::2])
    roots, odd = _reduced(classes, numbers, opposite.sum(axis=1) % 2 == 1)
    while len(links := np.flatnonzero((roots[:, 2] < 0) & (roots[:, 0] >= 0))):
        first, second = roots[links, 0], np.maximum(roots[links, 1], 0)
        alone = roots[links, 1] < 0
        classes.join((first, second, odd[links] ^ alone))
        roots, odd = _reduced(classes, roots, odd)
    if bool(odd[roots[:, 0] < 0].any()):
        raise ContradictionError
    kept = roots[:, 0] >= 0
    return _numbered(classes, statements, roots[kept], odd[kept])


def _reduced(classes: SignedClasses, numbers: Ints, odd: Bools) -> tuple[Ints, Bools]:
    """Rows (n, 4) of statements of which an even or odd number holds, as roots: without those that occur twice and
    without what is certain, -1 in their place, the rest first; and whether an odd number of the rest must hold.
    """
    there = numbers >= 0
    roots, opposite = classes.roots(np.where(there, numbers, 0))
    certain = there & (roots == CERTAIN)
    odd = odd ^ ((opposite & there).sum(axis=1) % 2 == 1) ^ (certain.sum(axis=1) % 2 == 1)
    roots = np.where(there & ~certain, roots, -1)
    for _ in range(2):
        roots = -np.sort(-roots, axis=1)
        for k in range(3):
            twice = roots[:, k] == roots[:, k + 1]
            roots[twice, k : k + 2] = -1
    roots = -np.sort(-roots, axis=1)
    if not len(roots):
        return roots, odd
    rows = np.unique(np.column_stack([roots, odd]), axis=0)
    return rows[:, :4], rows[:, 4] == 1


def _numbered(classes: SignedClasses, statements: _Statements, rows: Ints, odd: Bools) -> Equations:
    """The classes by number, in the order of their first pair."""
    roots, opposite = classes.roots(np.arange(len(statements.pairs) + 1))
    firsts, numbers = np.unique(roots, return_inverse=True)
    x, y = statements.pairs.T
    below = np.where(opposite[1:, None], statements.pairs[:, ::-1], statements.pairs)
    order = np.argsort(numbers[1:], kind="stable")
    by_class = below[order]
    lower, upper = (_shared(row, statements.width) for row in by_class.T)
    held = 2 * numbers[1:] + ~opposite[1:]
    parities, watching = _parities(np.where(rows >= 0, numbers[np.maximum(rows, 0)], -1), odd, len(firsts))
    return Equations(
        _codes(np.append(x, y), np.append(y, x), np.append(held, held ^ 1), statements.width),
        list(_slices(list(zip(lower, upper, strict=True)), numbers[1:], len(firsts))),
        parities,
        watching,
        by_class,
    )


def _codes(x: Ints, y: Ints, codes: Ints, faces: int) -> list[dict[int, int]]:
    """Face x -> face y -> code, of codes in any order."""
    order = np.argsort(x, kind="stable")
    there = _slices(_shared(y[order], faces), x, faces)
    code = _slices(_shared(codes[order], int(codes.max(initial=0)) + 1), x, faces)
    return [dict(zip(others, theirs, strict=True)) for others, theirs in zip(there, code, strict=True)]


def _shared(numbers: Ints, count: int) -> list[int]:
    """Numbers below a count as a list of which equal ones are one object: of millions, a fifth of the memory."""
    shared: list[int] = np.arange(count).astype(object)[numbers].tolist()
    return shared


def _slices(rows: list[T], owners: Ints, count: int) -> Iterator[list[T]]:
    """Rows that are sorted by owner, those of each of the owners 0 to ``count`` - 1."""
    ends = np.cumsum(np.bincount(owners, minlength=count)).tolist()
    return (rows[start:end] for start, end in pairwise([0, *ends]))


def _parities(
    rows: Ints, odd: Bools, count: int
) -> tuple[list[tuple[tuple[int, ...], bool]], list[list[int]]]:
    """The rows as tuples without -1, and for each class the rows that it is in."""
    parities = [
        (tuple(n for n in row if n >= 0), o) for row, o in zip(rows.tolist(), odd.tolist(), strict=True)
    ]
    watching: list[list[int]] = [[] for _ in range(count)]
    for index, (row, _) in enumerate(parities):
        for number in row:
            watching[number].append(index)
    return parities, watching
