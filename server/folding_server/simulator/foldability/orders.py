"""Layer orders partly decided: decide one class of statements and everything that follows from it.

Orders known so far are kept as bit sets per face, so that transitivity through a decided pair is a few set operations.
"""

from collections.abc import Iterator

from folding_server.simulator.foldability.constraints import Conditions
from folding_server.simulator.foldability.equations import ContradictionError, FacePair, equations

Decision = tuple[int, bool]


class Orders:
    """The layer orders of a pattern; ``decide`` and ``undo`` move through them.

    ``value`` holds what each class of statements is, None while open; ``turn`` when it is best decided: a face is laid
    among all those reached before it, then the next. Raises ContradictionError when made from
    conditions that leave no order.
    """

    def __init__(self, conditions: Conditions) -> None:
        self.equations = equations(conditions.pairs, conditions.equal, conditions.even)
        self.cells = conditions.cells
        self.touching = [0] * conditions.faces
        for i, j in conditions.pairs:
            self.touching[i] |= 1 << j
            self.touching[j] |= 1 << i
        self.over, self.under = [0] * conditions.faces, [0] * conditions.faces
        self.turn = [
            min(sorted((conditions.reached[x], conditions.reached[y]), reverse=True) for x, y in members)
            for members in self.equations.members
        ]
        self.value: list[bool | None] = [None] * len(self.equations.members)
        self.trail: list[int] = []
        given = [self.equations.literal(x, y) for x, y in conditions.known]
        if not all(self.decide(*decision) for decision in (*self.equations.fixed, *given)):
            raise ContradictionError

    def decide(self, number: int, value: bool) -> bool:
        """Give a class a value with all that follows. False if that is impossible: ``undo`` to where it was then."""
        waiting = [(number, value)]
        while waiting:
            number, value = waiting.pop()
            held = self.value[number]
            if held is None:
                self.value[number] = value
                self.trail.append(number)
                waiting.extend(self._by_parity(number))
                for x, y in self._statements(number):
                    self.over[x] |= 1 << y
                    self.under[y] |= 1 << x
                for x, y in self._statements(number):
                    waiting.extend(self._by_transitivity(x, y))
            elif held != value:
                return False
        return True

    def undo(self, length: int) -> None:
        """Take back decisions until the trail has this length."""
        while len(self.trail) > length:
            number = self.trail.pop()
            for x, y in self._statements(number):
                self.over[x] &= ~(1 << y)
                self.under[y] &= ~(1 << x)
            self.value[number] = None

    def lying(self) -> list[FacePair]:
        """The decided pairs, (lower, upper), sorted."""
        return sorted((x, y) for x, above in enumerate(self.over) for y in bits(above))

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
            left = [other for other in row if self.value[other] is None]
            if len(left) <= 1:
                held = sum(bool(self.value[other]) for other in row) % 2 == 1
                if left:
                    yield left[0], held != odd
                elif held != odd:
                    yield number, not self.value[number]

    def _by_transitivity(self, x: int, y: int) -> Iterator[Decision]:
        """What follows from x below y for the faces that share a cell with both."""
        literal, cells = self.equations.literal, self.cells
        both = cells[x] & cells[y]
        for z in bits(self.over[y] & self.touching[x] & ~self.over[x]):
            if both & cells[z]:
                yield literal(x, z)
        for z in bits(self.under[x] & self.touching[y] & ~self.under[y]):
            if both & cells[z]:
                yield literal(z, y)

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
