"""Which pairs of faces overlap, looked up for many pairs at once."""

import numpy as np

from folding_server.arrays import Bools, Ints

MOST_BITS = 1 << 30
"""Bits of a table of all pairs at most, 134 MB: beyond, which is 32,768 faces, pairs are searched in the sorted list."""


class PairTable:
    """The overlapping pairs (n, 2) of some faces, i < j, ascending."""

    def __init__(self, pairs: Ints, faces: int) -> None:
        self._faces = faces
        self._keys = np.append(pairs[:, 0] * faces + pairs[:, 1], -1)
        self._bits = _bit_table(pairs, faces) if faces * faces <= MOST_BITS else None

    def has(self, x: Ints, y: Ints) -> Bools:
        """Whether faces overlap, pair by pair."""
        if self._bits is not None:
            return np.asarray((self._bits[x, y >> 3] >> (y & 7)) & 1 == 1)
        keys = np.minimum(x, y) * self._faces + np.maximum(x, y)
        return np.asarray(self._keys[np.searchsorted(self._keys[:-1], keys)] == keys)


def _bit_table(pairs: Ints, faces: int) -> np.ndarray:
    """(faces, faces / 8): a bit for each pair, either way round."""
    bits = np.zeros((faces, faces // 8 + 1), np.uint8)
    for x, y in (pairs.T, pairs.T[::-1]):
        np.bitwise_or.at(bits, (x, y >> 3), (1 << (y & 7)).astype(np.uint8))
    return bits
