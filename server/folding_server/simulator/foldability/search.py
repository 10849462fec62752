"""Finding one layer order, and counting them: independent parts are searched apart and their counts multiplied."""

from collections.abc import Iterable
from dataclasses import dataclass

from folding_server.simulator.foldability.orders import Orders

EFFORT = 20_000
"""Decisions tried by our own search before the general solver is asked for one order, or counting stops."""
DEEPEST = 200
"""Nested choices beyond which counting takes the first order found for the only one and says that there may be more."""


@dataclass
class Count:
    """A number of orders up to a cap; ``exact`` turns False where counting was cut short."""

    cap: int
    effort: int = EFFORT
    exact: bool = True


def first_order(orders: Orders) -> bool:
    """Decide every open class so that all conditions hold. False, with the orders as they were, if there is no way."""
    start = len(orders.trail)
    for part in parts(orders, orders.open_classes()):
        found = _search(orders, part)
        if found is None:
            from folding_server.simulator.foldability.general_solver import solve  # noqa: PLC0415 - ortools is slow to load

            found = solve(orders, part)
        if not found:
            orders.undo(start)
            return False
    return True


def count_orders(orders: Orders, cap: int) -> tuple[int, bool]:
    """How many ways there are to decide what is open, at most ``cap``, and whether there may be more."""
    count = Count(cap)
    found = _count(orders, orders.open_classes(), count, 0)
    return min(found, cap), not count.exact or found > cap


def parts(orders: Orders, classes: Iterable[int]) -> list[list[int]]:
    """Open classes in groups that share no condition, the most connected class of a group first."""
    left = {number for number in classes if orders.value[number] is None}
    found = []
    while left:
        waiting = [left.pop()]
        weight = {}
        while waiting:
            number = waiting.pop()
            related = orders.related(number)
            weight[number] = len(related)
            waiting.extend(related & left)
            left -= related
        found.append(sorted(weight, key=lambda number: (-weight[number], number)))
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
        choices.append((position, len(orders.trail)))
        if not orders.decide(part[position], True):
            position = _other_way(orders, part, choices)
            if position < 0:
                return False
        effort -= 1
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


def _count(orders: Orders, classes: Iterable[int], count: Count, depth: int) -> int:
    """The number of ways to decide some open classes: the product over independent parts.

    Once the cap is reached the other parts are only asked whether they have an order at all.
    """
    total = 1
    for part in parts(orders, classes):
        total *= _branch(orders, part, count, depth) if total <= count.cap else _any(orders, part)
        if not total:
            return 0
    return total


def _branch(orders: Orders, part: list[int], count: Count, depth: int) -> int:
    """The number of ways to decide one part, by both values of its first class."""
    if depth >= DEEPEST or count.effort < 0:
        count.exact = False
        return _any(orders, part)
    found = 0
    for value in (True, False):
        count.effort -= 1
        length = len(orders.trail)
        if found <= count.cap and orders.decide(part[0], value):
            found += _count(orders, part[1:], count, depth + 1)
        orders.undo(length)
    return found


def _any(orders: Orders, part: list[int]) -> int:
    """1 if a part has an order, else 0; leaves the orders as they were."""
    length = len(orders.trail)
    found = _search(orders, part)
    if found is None:
        from folding_server.simulator.foldability.general_solver import solve  # noqa: PLC0415 - ortools is slow to load

        found = solve(orders, part)
    orders.undo(length)
    return int(found)
