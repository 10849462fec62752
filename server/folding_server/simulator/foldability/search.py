"""Finding one layer order, and counting them: independent parts are searched apart and their counts multiplied."""

from collections.abc import Iterable
from dataclasses import dataclass

from folding_server.simulator.foldability.orders import Orders

EFFORT = 200_000
"""Classes decided by trial before the general solver is asked for one order; counting may take twice as many."""
DEEPEST = 300
"""Nested choices beyond which counting takes the first order found for the only one and says that there may be more."""


@dataclass
class CountBudget:
    """What counting may still cost; ``exact`` turns False where it was cut short."""

    cap: int
    effort: int = 2 * EFFORT
    exact: bool = True


def first_order(orders: Orders) -> bool:
    """Decide every open class so that all conditions hold. False, with the orders as they were, if there is no way."""
    start = len(orders.trail)
    for part in parts(orders, orders.open_classes()):
        found = _search(orders, part)
        if found is None:
            from folding_server.simulator.foldability.general_solver import solve

            found = solve(orders, part)
        if not found:
            orders.undo(start)
            return False
    return True


def count_orders(orders: Orders, cap: int) -> tuple[int, bool]:
    """How many ways there are to decide what is open, at most ``cap``, and whether there may be more.

    One is taken for granted: ask ``first_order`` before. A cap of 1 costs nothing.
    """
    if cap <= 1:
        return 1, bool(orders.open_classes())
    count = CountBudget(cap)
    found = _count(orders, orders.open_classes(), count, 0)
    return min(found, cap), not count.exact or found > cap


def parts(orders: Orders, classes: Iterable[int]) -> list[list[int]]:
    """Open classes in groups that share no condition, each group in the order in which it is best decided."""
    left = {number for number in classes if orders.value[number] is None}
    found = []
    while left:
        waiting = [left.pop()]
        part = []
        while waiting:
            number = waiting.pop()
            part.append(number)
            related = orders.related(number)
            waiting.extend(related & left)
            left -= related
        found.append(sorted(part, key=orders.turn.__getitem__))
    return found


def _search(orders: Orders, part: list[int]) -> bool | None:
    """Decide the classes of a part by trial, depth first. False if impossible, None if it takes too much effort."""
    choices: list[tuple[int, int]] = []
    start, effort, position = len(orders.trail), EFFORT, 0
    while True:
        while position < len(part) and orders.value[part[position]] is not None:
            position += 1
        if position == len(part):
            return True
        before = len(orders.trail)
        choices.append((position, before))
        if not orders.decide(part[position], True):
            position = _other_way(orders, part, choices)
            if position < 0:
                return False
        effort -= 1 + max(0, len(orders.trail) - before)
        if effort < 0:
            orders.undo(start)
            return None


def _other_way(orders: Orders, part: list[int], choices: list[tuple[int, int]]) -> int:
    """Go back to the last choice whose other value is possible and take it; -1 if there is none."""
    while choices:
        position, length = choices.pop()
        orders.undo(length)
        if orders.decide(part[position], False):
            return position
        orders.undo(length)
    return -1


def _count(orders: Orders, classes: Iterable[int], count: CountBudget, depth: int) -> int:
    """The number of ways to decide some open classes: the product over independent parts.

    Once the cap is reached the other parts are only asked whether they have an order at all.
    """
    total = 1
    for part in parts(orders, classes):
        total *= _branch(orders, part, len(part), count, depth) if total <= count.cap else _any(orders, part)
        if not total:
            return 0
    return total


def _branch(orders: Orders, part: list[int], whole: int, count: CountBudget, depth: int) -> int:
    """The number of ways to decide the open classes of a part, by both values of the first.

    ``whole`` is how many there were when it was last split: it is split again when half of them are decided.
    """
    if depth >= DEEPEST or count.effort < 0:
        count.exact = False
        return _any(orders, part)
    found, length = 0, len(orders.trail)
    for value in (True, False):
        possible = found <= count.cap and orders.decide(part[0], value)
        count.effort -= 1 + len(orders.trail) - length
        if possible:
            left = [number for number in part if orders.value[number] is None]
            if 2 * len(left) > whole:
                found += _branch(orders, left, whole, count, depth + 1)
            else:
                found += _count(orders, left, count, depth + 1)
        orders.undo(length)
    return found


def _any(orders: Orders, part: list[int]) -> int:
    """1 if a part has an order, else 0; leaves the orders as they were."""
    length = len(orders.trail)
    found = _search(orders, part)
    if found is None:
        from folding_server.simulator.foldability.general_solver import solve

        found = solve(orders, part)
    orders.undo(length)
    return int(found)
