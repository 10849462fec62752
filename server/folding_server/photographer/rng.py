"""Independent streams of chance: the same seed, purpose and frame always give the same numbers."""

from zlib import crc32

import numpy as np


def stream(seed: int, purpose: str, frame: int = 0) -> np.random.Generator:
    """The generator for one purpose at one frame (0 for the whole sequence)."""
    return np.random.default_rng([seed, crc32(purpose.encode()), frame])
