"""Which faces have no layer order: a small set of them, found by leaving out the others."""

from dataclasses import replace
from time import perf_counter

import numpy as np

from folding_server.arrays import Bools
from folding_server.simulator.foldability.classes import ContradictionError
from folding_server.simulator.foldability.constraints import Conditions
from folding_server.simulator.foldability.equations import Rows, rows_of
from folding_server.simulator.foldability.orders import Orders
from folding_server.simulator.foldability.search import parts, search_part

SECONDS = 2.0
"""How long faces are left out at most; what is left then is named."""
SHORT = 0.5
"""How long they are left out at least, if it takes so long, however quickly it was found that there is no order."""


def conflicting_faces(conditions: Conditions, seconds: float = SECONDS) -> list[int]:
    """Faces that have no order among themselves, ascending: half of them are left out, then quarters, down to one by one.

    They are left out in the order in which they are laid, so that what is left out lies together. Zeller and Hildebrandt,
    "Simplifying and isolating failure-inducing input" (2002).
    """
    end = perf_counter() + seconds
    has_none = _contradicts if _contradicts(conditions) else _has_none
    kept = np.argsort(conditions.reached)
    size = (len(kept) + 1) // 2
    while size and perf_counter() < end:
        smaller = False
        for start in range(0, len(kept), size):
            rest = np.delete(kept, slice(start, start + size))
            if perf_counter() < end and len(rest) > 1 and has_none(_among(conditions, rest)):
                kept, smaller = rest, True
                break
        if not smaller:
            size = size // 2
        size = min(size, (len(kept) + 1) // 2)
    return sorted(kept.tolist())


def _contradicts(conditions: Conditions) -> bool:
    """Whether there is no order as far as that follows without trying."""
    try:
        Orders(conditions)
    except ContradictionError:
        return True
    return False


def _has_none(conditions: Conditions) -> bool:
    """Whether there is surely no order; False where that takes long to find out."""
    try:
        orders = Orders(conditions)
    except ContradictionError:
        return True
    return any(
        search_part(orders, part, effort=2000) is False for part in parts(orders, orders.open_classes())
    )


def _among(conditions: Conditions, faces: np.ndarray) -> Conditions:
    """The conditions that are about some faces only."""
    kept = np.zeros(conditions.faces, bool)
    kept[faces] = True
    return replace(
        conditions,
        pairs=_about(conditions.pairs, 2, kept),
        known=_about(conditions.known, 2, kept),
        equal=_about(conditions.equal, 4, kept),
        even=_about(conditions.even, 8, kept),
    )


def _about(rows: Rows, width: int, kept: Bools) -> Rows:
    given = rows_of(rows, width)
    return given[kept[given].all(axis=1)]
