"""Many points at once: where a similarity takes them."""

import numpy as np

from folding_server.arrays import Floats
from folding_server.geometry.similarity import Similarity


def transformed(points: Floats, motion: Similarity) -> Floats:
    """Where points (..., 2) go."""
    a, b, c, d, e, f = motion
    return np.asarray(points @ np.array([[a, c], [b, d]]) + (e, f))
