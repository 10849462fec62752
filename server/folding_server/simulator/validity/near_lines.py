"""Pairs of segments that may lie along one line, found by their directions and distances from the origin."""

from collections.abc import Iterator

import numpy as np

from folding_server.arrays import Floats, Indices

BIN = 0.05
"""Radians: segments of which the directions are in one bin are compared; those near its border are in two."""


def nearly_collinear(segments: Floats, distance: float, angle: float, shortest: float) -> Indices:
    """(2, k): pairs i < j of segments (n, 2, 2) longer than the shortest that may run along each other.

    All pairs whose directions differ by at most the angle (at most half a bin) and of which one has an end within the
    distance of the other's line are among them, and some more.
    """
    run = segments[:, 1] - segments[:, 0]
    number = np.flatnonzero(np.hypot(*run.T) > shortest)
    direction = np.arctan2(run[number, 1], run[number, 0]) % np.pi
    bins = int(np.ceil(np.pi / BIN))
    found = [np.zeros((0, 2), np.intp)]
    for k in range(bins):
        away = np.abs((direction - (k + 0.5) * np.pi / bins + np.pi / 2) % np.pi - np.pi / 2)
        members = number[away <= np.pi / bins / 2 + angle]
        if len(members) > 1:
            found.extend(_within(segments, members, (k + 0.5) * np.pi / bins, distance))
    one, other = np.concatenate(found).T
    keys = np.sort(np.minimum(one, other) * len(segments) + np.maximum(one, other))
    keys = keys[np.diff(keys, prepend=-1) > 0]
    return np.stack(np.divmod(keys, len(segments)))


def _within(segments: Floats, members: Indices, direction: float, distance: float) -> Iterator[Indices]:
    """(k, 2): the pairs of members whose ranges of distances from a line in that direction meet."""
    reach = segments[members] @ np.array([-np.sin(direction), np.cos(direction)])
    low, high = reach.min(axis=1) - distance, reach.max(axis=1) + distance
    order = np.argsort(low)
    low, high, members = low[order], high[order], members[order]
    ends = np.searchsorted(low, high, side="right")
    counts = ends - np.arange(len(members)) - 1
    first = np.repeat(np.arange(len(members)), counts)
    second = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts) + first + 1
    yield np.column_stack([members[first], members[second]])
