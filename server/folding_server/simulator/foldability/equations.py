"""Statements about pairs of faces that are equal or opposite, gathered into classes; what is left relates classes."""

from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass

FacePair = tuple[int, int]
"""(x, y), read as the statement that face x lies below face y."""


class ContradictionError(Exception):
    """Conditions that cannot hold together, whatever is chosen."""


@dataclass(frozen=True)
class Equations:
    """Classes of statements, by number.

    ``class_of``  pair i < j -> (class, whether [i, j] is the opposite of the class)
    ``members``   class -> the statements that hold if the class is true
    ``parities``  (classes, odd): an odd or an even number of these classes is true
    ``watching``  class -> indices of the parities it is in
    ``fixed``     (class, value) for classes that the equations alone decide
    """

    class_of: dict[FacePair, tuple[int, bool]]
    members: list[list[FacePair]]
    parities: list[tuple[tuple[int, ...], bool]]
    watching: list[list[int]]
    fixed: list[tuple[int, bool]]

    def literal(self, x: int, y: int) -> tuple[int, bool]:
        """The class of the statement [x, y] and its value if the statement holds."""
        number, opposite = self.class_of[(x, y) if x < y else (y, x)]
        return number, opposite == (x > y)


class _Classes:
    """Union-find with signs over the pairs."""

    def __init__(self, pairs: Iterable[FacePair]) -> None:
        self.above: dict[FacePair, tuple[FacePair, bool]] = {pair: (pair, False) for pair in pairs}

    def find(self, x: int, y: int) -> tuple[FacePair, bool]:
        """The root of [x, y] and whether the statement is its opposite."""
        pair, opposite = ((x, y), False) if x < y else ((y, x), True)
        path = []
        while self.above[pair][0] != pair:
            path.append((pair, opposite))
            opposite ^= self.above[pair][1]
            pair = self.above[pair][0]
        for passed, before in path:
            self.above[passed] = (pair, opposite != before)
        return pair, opposite

    def join(self, first: tuple[FacePair, bool], second: tuple[FacePair, bool], *, opposite: bool) -> None:
        """Make two signed roots equal or opposite; ContradictionError if they are the other already."""
        (p, negated_p), (q, negated_q) = first, second
        sign = negated_p ^ negated_q ^ opposite
        if p != q:
            self.above[p] = (q, sign)
        elif sign:
            raise ContradictionError


def equations(
    pairs: Iterable[FacePair],
    equal: Iterable[tuple[FacePair, FacePair]],
    even: Collection[tuple[FacePair, ...]],
) -> Equations:
    """Gather statements into classes; ContradictionError if the equations alone have no solution."""
    pairs = sorted(pairs)
    classes = _Classes(pairs)
    for first, second in equal:
        classes.join(classes.find(*first), classes.find(*second), opposite=False)
    reduced = {_reduced(classes, statements) for statements in even}
    while joins := [(roots, odd) for roots, odd in reduced if len(roots) == 2]:
        for (p, q), odd in joins:
            classes.join(classes.find(*p), classes.find(*q), opposite=odd)
        reduced = {_reduced(classes, statements) for statements in even}
    if ((), True) in reduced:
        raise ContradictionError
    return _numbered(classes, pairs, sorted(reduced))


def _reduced(classes: _Classes, statements: Iterable[FacePair]) -> tuple[tuple[FacePair, ...], bool]:
    """An even number of statements as roots, those that occur twice cancelled, and whether an odd number must hold."""
    odd, count = False, Counter[FacePair]()
    for x, y in statements:
        root, opposite = classes.find(x, y)
        odd ^= opposite
        count[root] += 1
    return tuple(sorted(root for root, times in count.items() if times % 2)), odd


def _numbered(
    classes: _Classes, pairs: list[FacePair], rows: list[tuple[tuple[FacePair, ...], bool]]
) -> Equations:
    """The classes by number, in the order of their first pair."""
    numbers: dict[FacePair, int] = {}
    class_of: dict[FacePair, tuple[int, bool]] = {}
    members: list[list[FacePair]] = []
    for x, y in pairs:
        root, opposite = classes.find(x, y)
        number = numbers.setdefault(root, len(numbers))
        if number == len(members):
            members.append([])
        members[number].append((y, x) if opposite else (x, y))
        class_of[x, y] = (number, opposite)
    parities = [(tuple(numbers[root] for root in roots), odd) for roots, odd in rows if len(roots) > 1]
    watching: list[list[int]] = [[] for _ in members]
    for index, (row, _) in enumerate(parities):
        for number in row:
            watching[number].append(index)
    fixed = [(numbers[roots[0]], odd) for roots, odd in rows if len(roots) == 1]
    return Equations(class_of, members, parities, watching, fixed)
