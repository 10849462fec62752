"""How alike two counts are, and two histograms."""

from collections.abc import Hashable, Mapping
from math import exp


def count_similarity(a: float, b: float, decay: float) -> float:
    """exp(-decay |a - b| / max(1, min(a, b))): 1 if they are the same."""
    return exp(-decay * abs(a - b) / max(1.0, min(a, b)))


def histogram_similarity(first: Mapping[Hashable, float], second: Mapping[Hashable, float]) -> float:
    """1 less half the L1 distance of two histograms, each normalised. 1 if both are empty, 0 if one is."""
    one, two = sum(first.values()), sum(second.values())
    if one == 0 or two == 0:
        return float(one == two)
    bins = {*first, *second}
    return 1 - 0.5 * sum(abs(first.get(each, 0) / one - second.get(each, 0) / two) for each in bins)
