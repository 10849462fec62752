"""Folding the sectors around one vertex flat by crimps and end folds: whether that is possible, and a layer order.

A crimp folds a sector between two creases, one up and one down, that is no larger than its neighbours; an end fold lays the last
sector of an open stretch on one that is no smaller. Either leaves three or two sectors lying as one, without losing a way to
fold the rest, and what cannot be made smaller so does not fold. (Arkin et al., "When can you fold a map?", 2004; Demaine
and O'Rourke, "Geometric Folding Algorithms", 2007, sections 12.1 and 12.2.)
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

NestedSectors = int | tuple["NestedSectors", ...]
"""A sector, or what lies as one, bottom to top."""


def crimped_stack(
    angles: Sequence[float], above: Sequence[bool], equal: float, *, closed: bool
) -> list[int] | None:
    """The sectors bottom to top, or None if they cannot be folded flat.

    ``above`` says for each crease whether the sector after it lies above the one before; ``equal`` is by how much angles, in radians,
    that are meant to be equal may differ.
    """
    if closed and len(angles) % 2:
        return None
    left = _Left(list(angles), [*above] if closed else [*above, False], equal, closed)
    waiting = list(range(len(angles)))
    while waiting:
        sector = waiting.pop()
        if left.there[sector] and (changed := left.folded(sector)) is not None:
            waiting += left.around(changed)
    return left.stack()


@dataclass
class _Left:
    """The sectors that are left, as a doubly linked list: ``above`` is about the crease after each, ``before`` and ``after``
    are its neighbours, -1 at the ends of an open stretch.
    """

    width: list[float]
    above: list[bool]
    equal: float
    closed: bool
    layers: list[NestedSectors] = field(init=False)
    there: list[bool] = field(init=False)
    before: list[int] = field(init=False)
    after: list[int] = field(init=False)
    count: int = field(init=False)

    def __post_init__(self) -> None:
        self.count = count = len(self.width)
        self.layers = list(range(count))
        self.there = [True] * count
        self.before = [count - 1 if self.closed else -1, *range(count - 1)]
        self.after = [*range(1, count), 0 if self.closed else -1]

    def folded(self, sector: int) -> int | None:
        """Fold a sector away if that may be done; what it lies in now, else None."""
        left, right = self.before[sector], self.after[sector]
        if left >= 0 and right >= 0:
            return self._crimped(left, sector, right)
        if left < 0 and right >= 0 and self._fits(sector, right):
            return self._end_folded(right, sector, self.above[sector])
        if right < 0 and left >= 0 and self._fits(sector, left):
            return self._end_folded(left, sector, not self.above[left])
        return None

    def around(self, sector: int) -> list[int]:
        """A sector and its neighbours."""
        return [k for k in (self.before[sector], self.after[sector], sector) if k >= 0]

    def stack(self) -> list[int] | None:
        """All sectors bottom to top, if what is left lies flat: one sector, or two that go around."""
        last = next(k for k, there in enumerate(self.there) if there)
        other = self.after[last]
        if not self.closed:
            return _flattened(self.layers[last]) if self.count == 1 else None
        if self.count != 2 or self.above[last] == self.above[other] or not self._alike(last, other):
            return None
        low, high = (last, other) if self.above[last] else (other, last)
        return _flattened((self.layers[low], self.layers[high]))

    def _fits(self, sector: int, onto: int) -> bool:
        return self.width[sector] <= self.width[onto] + self.equal

    def _alike(self, one: int, other: int) -> bool:
        return self._fits(one, other) and self._fits(other, one)

    def _crimped(self, left: int, sector: int, right: int) -> int | None:
        """Make three sectors one, in the place of the left one."""
        up = self.above[left]
        if (
            left == right
            or up != self.above[sector]
            or not (self._fits(sector, left) and self._fits(sector, right))
        ):
            return None
        three = self.layers[left], self.layers[sector], self.layers[right]
        self.layers[left] = three if up else three[::-1]
        self.width[left] += self.width[right] - self.width[sector]
        self.above[left] = self.above[right]
        self._leave_out(sector)
        self._leave_out(right)
        return left

    def _end_folded(self, onto: int, sector: int, onto_above: bool) -> int:
        two = self.layers[sector], self.layers[onto]
        self.layers[onto] = two if onto_above else two[::-1]
        self._leave_out(sector)
        return onto

    def _leave_out(self, sector: int) -> None:
        before, after = self.before[sector], self.after[sector]
        if before >= 0:
            self.after[before] = after
        if after >= 0:
            self.before[after] = before
        self.there[sector] = False
        self.count -= 1


def _flattened(layers: NestedSectors) -> list[int]:
    """The sectors in nested layers, in order; they may be nested as deep as there are sectors."""
    found: list[int] = []
    waiting = [layers]
    while waiting:
        each = waiting.pop()
        if isinstance(each, int):
            found.append(each)
        else:
            waiting.extend(each[::-1])
    return found
