"""Statements that are equal or opposite, as classes: connected components of the statements and their opposites."""

import numpy as np

from folding_server.arrays import Bools, Ints

Links = tuple[Ints, Ints, Bools]
"""Statements (k,), statements (k,), and whether each two are opposite."""


class ContradictionError(Exception):
    """Conditions that cannot hold together, whatever is chosen."""


class SignedClasses:
    """Statements 0 to n - 1, of which some are known to be equal or opposite.

    Node 2 i stands for statement i, node 2 i + 1 for its opposite; ``label`` is the least node that each hangs together with.
    """

    def __init__(self, count: int) -> None:
        self.label = np.arange(2 * count)

    def join(self, links: Links) -> None:
        """Make statements equal or opposite; ContradictionError if some are the other already."""
        first, second, opposite = links
        p, q = 2 * first, 2 * second + opposite
        self.label = _joined(self.label, np.concatenate([p, p + 1]), np.concatenate([q, q ^ 1]))
        if bool((self.label[::2] == self.label[1::2]).any()):
            raise ContradictionError

    def roots(self, statements: Ints) -> tuple[Ints, Bools]:
        """The least statement of the class of each, and whether each is its opposite."""
        label = self.label[2 * statements]
        return label >> 1, (label & 1).astype(bool)


def _joined(label: Ints, u: Ints, v: Ints) -> Ints:
    """Labels after nodes were joined: labels are hooked onto lesser ones and shortened until nothing changes.

    Shiloach and Vishkin, "An O(log n) parallel connectivity algorithm" (1982), with the minimum as the hook.
    """
    while True:
        p, q = label[u], label[v]
        apart = p != q
        if not bool(apart.any()):
            return label
        u, v, p, q = u[apart], v[apart], p[apart], q[apart]
        label = label.copy()
        np.minimum.at(label, np.maximum(p, q), np.minimum(p, q))
        while not np.array_equal(shorter := label[label], label):
            label = shorter
