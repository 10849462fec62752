"""Many points at once: where a similarity takes them, and how far two sets of them are apart."""

import numpy as np

from folding_server.arrays import Floats
from folding_server.geometry.similarity import Similarity


def transformed(points: Floats, motion: Similarity) -> Floats:
    """Where points (..., 2) go."""
    a, b, c, d, e, f = motion
    return np.asarray(points @ np.array([[a, c], [b, d]]) + (e, f))


def hausdorff_distance(first: Floats, second: Floats) -> float:
    """The largest distance from a point of either set, (n, 2) and (m, 2), to the nearest of the other."""
    distances = np.linalg.norm(first[:, None] - second[None], axis=2)
    return float(max(distances.min(axis=0).max(), distances.min(axis=1).max()))
