"""Big-little-big at the vertices inside a crease pattern: what the smallest angles ask of the creases beside them."""

from collections.abc import Iterator, Sequence
from math import pi

from folding_server.simulator.foldability.fault import Fault
from folding_server.simulator.foldability.local import OFF, angles_around, inner_vertices, longer_side
from folding_server.simulator.foldability.pattern import CreasePattern, PatternCrease

EQUAL = 2e-3
"""Radians by which angles that are meant to be equal may differ."""


def big_little_big(pattern: CreasePattern) -> list[Fault]:
    """The places at which big-little-big fails, by vertex, of a pattern of which every vertex obeys Maekawa and Kawasaki."""
    off = OFF * longer_side(pattern)
    return [fault for v, folded in inner_vertices(pattern) for fault in _at_vertex(pattern, v, folded, off)]


def _at_vertex(
    pattern: CreasePattern, vertex: int, folded: Sequence[PatternCrease], off: float
) -> Iterator[Fault]:
    """Between two larger angles, k equal smaller ones: mountains and valleys of their k + 1 creases are as many, or differ
    by one where their number is odd (Hull, "Counting mountain-valley assignments for flat folds", 2003).
    """
    if len(folded) < 4:
        return
    creases, gaps, shortest = angles_around(pattern, vertex, folded)
    alike, count = EQUAL + off / shortest, len(gaps)
    starts = [k for k in range(count) if gaps[k - 1] > gaps[k] + alike]
    for start in starts:
        run = [k % count for k in range(start, start + count)]
        length = next((i for i, k in enumerate(run) if abs(gaps[k] - gaps[start]) > alike), count)
        if length < count and gaps[run[length]] > gaps[start] + alike:
            letters = [creases[(start + i) % count].assignment for i in range(length + 1)]
            mountains, valleys = letters.count("M"), letters.count("V")
            if "U" not in letters and abs(mountains - valleys) != (length + 1) % 2:
                yield _fault(pattern, vertex, _unlike(gaps[start], length, mountains, valleys))


def _unlike(gap: float, length: int, mountains: int, valleys: int) -> str:
    """What is wrong with the creases of ``length`` equal angles."""
    degrees = f"{gap * 180 / pi:.4g} degrees"
    if length == 1:
        kind = "mountains" if mountains else "valleys"
        return (
            f"The angle of {degrees} between two {kind} is smaller than both angles beside it; one of the two must be a "
            "mountain and the other a valley."
        )
    return (
        f"{length} equal angles of {degrees} lie between larger ones, with {mountains} mountains and {valleys} valleys; "
        f"these must {'be as many' if length % 2 else 'differ by one'}."
    )


def _fault(pattern: CreasePattern, vertex: int, detail: str) -> Fault:
    return Fault("Big-little-big", detail, (pattern.name(vertex),), (pattern.place(vertex),))
