"""Finding one layer order, and counting them: independent parts are searched apart and their counts multiplied."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from math import inf
from time import perf_counter

from folding_server.simulator.foldability.orders import Orders

EFFORT = 200_000
"""Classes given a value by trial before the general solver is asked for one order; counting may take twice as many."""
FIRST_EFFORT = 20_000
"""Classes given a value by trial before what is open is taken apart into parts that do not depend on each other, and before the
classes of a part are tried in another order.
"""
DEEPEST = 300
"""Nested choices beyond which counting takes the first order found for the only one and says that there may be more."""


class OutOfTimeError(Exception):
    """The time for counting is over."""


@dataclass
class CountBudget:
    """What counting one part may still cost; ``exact`` turns False where it was cut short.

    ``cap`` orders of a part are counted at most, None for all; counting ends at ``end`` on the clock of ``perf_counter``.
    """

    cap: int | None = None
    end: float = inf
    effort: float = inf
    exact: bool = True

    def full(self, found: int) -> bool:
        """Whether more orders were found than are counted."""
        return self.cap is not None and found > self.cap

    def check(self) -> None:
        """Raise OutOfTimeError if the time is over."""
        if perf_counter() > self.end:
            raise OutOfTimeError


def first_order(orders: Orders) -> bool:
    """Decide every open class so that all conditions hold. False, with the orders as they were, if there is no way."""
    start = len(orders.trail)
    everything = sorted(orders.open_classes(), key=orders.turn.__getitem__)
    found = search_part(orders, everything, FIRST_EFFORT + 2 * len(everything))
    if found is not None:
        return found
    for part in parts(orders, everything):
        if not _decided(orders, part):
            orders.undo(start)
            return False
    return True


def _decided(orders: Orders, part: list[int]) -> bool:
    """Decide the classes of a part: by trial, first those that share conditions one after the other, then as they are best
    decided, then by the general solver. False if there is no way.
    """
    found = search_part(orders, outwards(orders, part), FIRST_EFFORT + 2 * len(part))
    return _decided_in_order(orders, part) if found is None else found


def _decided_in_order(orders: Orders, part: list[int]) -> bool:
    found = search_part(orders, part)
    if found is None:
        from folding_server.simulator.foldability.general_solver import solve

        found = solve(orders, part)
    return found


def outwards(orders: Orders, part: list[int]) -> list[int]:
    """The classes of a part from its first on, each after one that it shares a condition with: a contradiction then lies near
    the choice that it comes from.
    """
    left, found = set(part[1:]), [part[0]]
    for number in found:
        near = orders.related(number) & left
        left -= near
        found.extend(sorted(near, key=orders.turn.__getitem__))
    return [*found, *sorted(left)]


def count_orders(
    orders: Orders,
    cap: int | None,
    seconds: float | None = None,
    announce: Callable[[int, int, int], None] | None = None,
) -> tuple[int, bool]:
    """How many ways there are to decide what is open, and whether there may be more: the product over parts that do not
    depend on each other, each counted up to ``cap`` (None for no limit) within ``seconds`` in all.

    One is taken for granted: ask ``first_order`` before. A cap of 1 costs nothing. ``announce`` is told after each part how
    many classes are done, of how many, and the product so far.
    """
    left = orders.open_classes()
    if cap is not None and cap <= 1:
        return 1, bool(left)
    whole, done, total, exact, length = len(left), 0, 1, True, len(orders.trail)
    budget = CountBudget(cap, perf_counter() + seconds if seconds is not None else inf)
    if seconds is None and cap is not None:
        budget.effort = 2 * EFFORT
    try:
        for part in parts(orders, left, budget.check):
            budget = replace(budget, exact=True)
            found = _branch(orders, part, len(part), budget, 0)
            exact &= budget.exact and not budget.full(found)
            total *= max(1, found if cap is None else min(found, cap))
            done += len(part)
            if announce:
                announce(done, whole, total)
    except OutOfTimeError:
        orders.undo(length)
        exact = False
    return total, not exact


def parts(
    orders: Orders, classes: Iterable[int], check: Callable[[], None] = lambda: None
) -> Iterator[list[int]]:
    """Open classes in groups that share no condition, each group in the order in which it is best decided.

    ``check`` is called now and then, and may raise.
    """
    left = {number for number in classes if orders.value[number] is None}
    while left:
        waiting = [left.pop()]
        part = []
        while waiting:
            check()
            number = waiting.pop()
            part.append(number)
            related = orders.related(number)
            waiting.extend(related & left)
            left -= related
        yield sorted(part, key=orders.turn.__getitem__)


def search_part(orders: Orders, part: list[int], effort: int | None = None) -> bool | None:
    """Decide the classes of a part by trial, depth first; False if impossible, None if it takes too much effort, with the
    orders as they were.
    """
    choices: list[tuple[int, int, bool]] = []
    start, position = len(orders.trail), 0
    most = orders.work + (EFFORT if effort is None else effort)
    while True:
        while position < len(part) and orders.value[part[position]] is not None:
            position += 1
        if position == len(part):
            return True
        before = len(orders.trail)
        value = orders.likely(part[position])
        choices.append((position, before, value))
        if not orders.decide(part[position], value):
            position = _other_way(orders, part, choices)
            if position < 0:
                return False
        if orders.work > most:
            orders.undo(start)
            return None


def _other_way(orders: Orders, part: list[int], choices: list[tuple[int, int, bool]]) -> int:
    """Go back to the last choice whose other value is possible and take it; -1 if there is none."""
    while choices:
        position, length, value = choices.pop()
        orders.undo(length)
        if orders.decide(part[position], not value):
            return position
        orders.undo(length)
    return -1


def _count(orders: Orders, classes: Iterable[int], count: CountBudget, depth: int) -> int:
    """The number of ways to decide some open classes: the product over independent parts.

    Once more were found than are counted the other parts are only asked whether they have an order at all.
    """
    total = 1
    for part in list(parts(orders, classes, count.check)):
        full = count.full(total)
        total *= _any(orders, part) if full else _branch(orders, part, len(part), count, depth)
        if not total:
            return 0
    return total


def _branch(orders: Orders, part: list[int], whole: int, count: CountBudget, depth: int) -> int:
    """The number of ways to decide the open classes of a part, by both values of the first.

    ``whole`` is how many there were when it was last split: it is split again when half of them are decided. When the time
    is over, what was found so far is the number, and not exact.
    """
    if depth >= DEEPEST or count.effort < 0:
        count.exact = False
        return _any(orders, part)
    found, length = 0, len(orders.trail)
    try:
        for value in (True, False):
            count.check()
            possible = not count.full(found) and orders.decide(part[0], value)
            count.effort -= 1 + len(orders.trail) - length
            if possible:
                left = [number for number in part if orders.value[number] is None]
                if 2 * len(left) > whole:
                    found += _branch(orders, left, whole, count, depth + 1)
                else:
                    found += _count(orders, left, count, depth + 1)
            orders.undo(length)
    except OutOfTimeError:
        orders.undo(length)
        count.exact = False
    return found


def _any(orders: Orders, part: list[int]) -> int:
    """1 if a part has an order, else 0; leaves the orders as they were."""
    length = len(orders.trail)
    found = _decided_in_order(orders, part)
    orders.undo(length)
    return int(found)
