"""Layer orders partly decided: decide one class of statements and everything that follows from it.

Orders known so far are kept as bit sets per face, so that transitivity through a decided pair is a few set operations.
"""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from folding_server.simulator.foldability.classes import ContradictionError
from folding_server.simulator.foldability.constraints import Conditions
from folding_server.simulator.foldability.equations import CERTAIN, Equations, FacePair, equations

Decision = tuple[int, bool]


class Orders:
    """The layer orders of a pattern; ``decide`` and ``undo`` move through them.

    ``value`` holds what each class of statements is, None while open; ``turn`` when it is best decided: a face is laid
    beside the one that it is joined to, then among all others reached before it, then the next. ``beside`` holds the pair of
    each class that says so, (face that is laid, other face), and ``joined`` what each face is joined to. Raises ContradictionError when made from
    conditions that leave no order.
    """

    def __init__(self, conditions: Conditions) -> None:
        self.equations = equations(conditions.pairs, conditions.equal, conditions.even, conditions.known)
        self.cells = conditions.cells
        self.bit = [1 << face for face in range(conditions.faces)]
        self.touching = [0] * conditions.faces
        for x, codes in enumerate(self.equations.codes):
            self.touching[x] = _bit_set(codes, conditions.faces)
        self.over, self.under = [0] * conditions.faces, [0] * conditions.faces
        self.turn, self.beside = _turns(self.equations, conditions)
        self.joined = conditions.beside or (-1,) * conditions.faces
        self.value: list[bool | None] = [None] * len(self.equations.members)
        self.trail: list[int] = []
        self._undone = 0
        if not self.decide(CERTAIN, value=True):
            raise ContradictionError

    def decide(self, number: int, value: bool) -> bool:
        """Give a class a value with all that follows. False if that is impossible: ``undo`` to where it was then."""
        waiting: list[int] = []
        if not self._note(number, value, waiting):
            return False
        while waiting:
            number = waiting.pop()
            for other, held in self._by_parity(number):
                if not self._note(other, held, waiting):
                    return False
            if not self._close(number, waiting):
                return False
        return True

    def _note(self, number: int, value: bool, waiting: list[int]) -> bool:
        """Give a class a value and note what it says; what follows from that waits. False if it has the other value."""
        held = self.value[number]
        if held is not None:
            return held == value
        self.value[number] = value
        self.trail.append(number)
        waiting.append(number)
        for x, y in self._statements(number):
            self.over[x] |= self.bit[y]
            self.under[y] |= self.bit[x]
        return True

    def _close(self, number: int, waiting: list[int]) -> bool:
        """Note what follows by transitivity from what a class says. False if that contradicts what is known."""
        over, under, touching = self.over, self.under, self.touching
        for x, y in self._statements(number):
            above, below = over[y] & (touching[x] ^ over[x]), under[x] & (touching[y] ^ under[y])
            if (above or below) and not self._close_pair(x, y, above, below, waiting):
                return False
        return True

    def _close_pair(self, x: int, y: int, above: int, below: int, waiting: list[int]) -> bool:
        """Note what follows from x below y for the faces above y and below x that share a cell with both."""
        cells, codes = self.cells, self.equations.codes
        both = cells[x] & cells[y]
        followed = [codes[x][z] for z in bits(above) if both & cells[z]]
        followed += [codes[z][y] for z in bits(below) if both & cells[z]]
        return all(self._note(code >> 1, bool(code & 1), waiting) for code in followed)

    @property
    def work(self) -> int:
        """How many classes were given a value so far, those of which it was taken back included."""
        return len(self.trail) + self._undone

    def likely(self, number: int) -> bool:
        """The value to try first of an open class: the face that is laid goes next to the one it is joined to.

        Above it, if the two are what the class is about; else it lies to any face as that one does. A strip folds into an
        accordion that way, a map row by row.
        """
        laid, other = self.beside[number]
        joined = self.joined[laid]
        code = self.equations.codes[other][laid]
        if joined >= 0 and joined != other:
            same = self.equations.codes[other].get(joined)
            held = None if same is None else self.value[same >> 1]
            if same is not None and held is not None:
                below = held == bool(same & 1)
                return below == bool(code & 1)
        return bool(code & 1)

    def undo(self, length: int) -> None:
        """Take back decisions until the trail has this length."""
        self._undone += max(0, len(self.trail) - length)
        while len(self.trail) > length:
            number = self.trail.pop()
            for x, y in self._statements(number):
                self.over[x] ^= self.bit[y]
                self.under[y] ^= self.bit[x]
            self.value[number] = None

    def lying(self) -> list[FacePair]:
        """The decided pairs, (lower, upper), sorted."""
        return [(x, y) for x, above in enumerate(self.over) for y in _numbers(above, len(self.over))]

    def open_classes(self) -> list[int]:
        """The classes that are not decided."""
        return [number for number, value in enumerate(self.value) if value is None]

    def related(self, number: int) -> set[int]:
        """The open classes that share a condition with an open class: a parity, or a triple of faces in one cell."""
        rows = (self.equations.parities[k][0] for k in self.equations.watching[number])
        found = {other for row in rows for other in row}
        for x, y in self.equations.members[number]:
            found.update(self._in_triples(x, y))
        found.discard(number)
        return {other for other in found if self.value[other] is None}

    def _statements(self, number: int) -> list[FacePair]:
        """The statements that a decided class makes, lower face first."""
        members = self.equations.members[number]
        return members if self.value[number] else [(y, x) for x, y in members]

    def _by_parity(self, number: int) -> Iterator[Decision]:
        """What the parities of a decided class imply: the last open class of one; a contradiction if none is open."""
        for k in self.equations.watching[number]:
            row, odd = self.equations.parities[k]
            left = _open_one(row, self.value)
            if left is not None:
                held = sum(bool(self.value[other]) for other in row) % 2 == 1
                if left >= 0:
                    yield left, held != odd
                elif held != odd:
                    yield number, not self.value[number]

    def _in_triples(self, x: int, y: int) -> Iterator[int]:
        """The classes of the two other pairs of each triple with x and y that transitivity still says something about."""
        known_x, known_y = self.over[x] | self.under[x], self.over[y] | self.under[y]
        both = self.cells[x] & self.cells[y]
        for z in bits(self.touching[x] & self.touching[y] & ~(known_x & known_y)):
            if both & self.cells[z]:
                yield self.equations.literal(x, z)[0]
                yield self.equations.literal(y, z)[0]


def bits(mask: int) -> Iterator[int]:
    """The numbers in a bit set, ascending."""
    while mask:
        lowest = mask & -mask
        yield lowest.bit_length() - 1
        mask ^= lowest


def _bit_set(numbers: Iterable[int], size: int) -> int:
    """A bit set of numbers below a size."""
    held = np.zeros(size, bool)
    held[list(numbers)] = True
    return int.from_bytes(np.packbits(held, bitorder="little").tobytes(), "little")


def _numbers(mask: int, size: int) -> list[int]:
    """The numbers in a bit set of numbers below a size, ascending; quicker than ``bits`` where there are many."""
    held = np.frombuffer(mask.to_bytes(size // 8 + 1, "little"), np.uint8)
    numbers: list[int] = np.flatnonzero(np.unpackbits(held, bitorder="little")).tolist()
    return numbers


def _open_one(row: Sequence[int], value: Sequence[bool | None]) -> int | None:
    """The only open class of a row, -1 if none is open, None if several are."""
    left = -1
    for number in row:
        if value[number] is None:
            if left >= 0:
                return None
            left = number
    return left


def _turns(equations: Equations, conditions: Conditions) -> tuple[list[tuple[int, int]], list[FacePair]]:
    """For each class when it is best decided, and of its pairs the one that says so: (face that is laid, other face)."""
    if not len(equations.pairs):
        return [(conditions.faces, 0)], [(0, 0)]
    reached = np.array(conditions.reached, int)
    joined = np.array(conditions.beside or (-1,) * conditions.faces, int)
    x, y = equations.pairs.T
    first = reached[x] > reached[y]
    laid, other = np.where(first, x, y), np.where(first, y, x)
    after = np.where(joined[laid] == other, -1, reached[other])
    sizes = np.array([len(members) for members in equations.members])
    order = np.lexsort((after, reached[laid], np.repeat(np.arange(len(sizes)), sizes)))
    best = order[np.minimum(np.cumsum(sizes) - sizes, len(order) - 1)]
    turns = list(zip(reached[laid[best]].tolist(), after[best].tolist(), strict=True))
    pairs = list(zip(laid[best].tolist(), other[best].tolist(), strict=True))
    if not sizes[CERTAIN]:
        turns[CERTAIN], pairs[CERTAIN] = (conditions.faces, 0), (0, 0)
    return turns, pairs
