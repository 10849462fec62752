"""Maekawa and Kawasaki at the vertices inside a crease pattern."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan2, hypot, pi, tau
from typing import Literal

from folding_server.simulator.foldability.pattern import CreasePattern, PatternCrease

ANGLE = 1e-2
"""Radians that alternate angles may be off half a turn."""
OFF = 2e-4
"""How far the coordinates of a vertex may be off, in units of the sheet's longer side: short creases turn by more."""


@dataclass(frozen=True)
class VertexViolation:
    """A vertex (as the pattern calls it) at which a condition fails, and how."""

    vertex: int
    condition: Literal["Maekawa", "Kawasaki"]
    detail: str


def local_violations(pattern: CreasePattern) -> list[VertexViolation]:
    """Every vertex inside the sheet that breaks Maekawa's or Kawasaki's theorem, by ascending index.

    Maekawa: mountains and valleys differ by two; a crease without direction counts as either. Kawasaki: alternate
    angles add up to half a turn. Marks are not folded and do not count.
    """
    found: list[VertexViolation] = []
    off = OFF * longer_side(pattern)
    for v, folded in inner_vertices(pattern):
        found.extend(_maekawa(pattern, v, folded))
        found.extend(_kawasaki(pattern, v, folded, off))
    return found


def longer_side(pattern: CreasePattern) -> float:
    """The longer side of the box around a pattern."""
    xs, ys = zip(*pattern.vertices_coords, strict=True)
    return float(max(max(xs) - min(xs), max(ys) - min(ys)))


def inner_vertices(pattern: CreasePattern) -> Iterator[tuple[int, list[PatternCrease]]]:
    """The vertices inside the sheet, ascending, with the folded creases that meet there."""
    around: dict[int, list[PatternCrease]] = {}
    for crease in pattern.creases:
        for v in crease.edge:
            around.setdefault(v, []).append(crease)
    for v in sorted(set(around) - _outline(pattern)):
        yield v, [crease for crease in around[v] if crease.folded]


def _outline(pattern: CreasePattern) -> set[int]:
    """The vertices of edges that do not lie between two faces."""
    inner = {crease.edge for crease in pattern.creases}
    return {v for edge in pattern.edges_vertices if edge not in inner for v in edge}


def _maekawa(
    pattern: CreasePattern, vertex: int, folded: Sequence[PatternCrease]
) -> Iterator[VertexViolation]:
    mountains, valleys, free = (sum(c.assignment == assignment for c in folded) for assignment in "MVU")
    if not folded:
        return
    if len(folded) % 2:
        yield VertexViolation(
            pattern.name(vertex), "Maekawa", f"An odd number of creases, {len(folded)}, meet here."
        )
    elif not any(abs(mountains + k - valleys - (free - k)) == 2 for k in range(free + 1)):
        yield VertexViolation(
            pattern.name(vertex),
            "Maekawa",
            f"{mountains} mountains and {valleys} valleys meet here; they must differ by two.",
        )


def _kawasaki(
    pattern: CreasePattern, vertex: int, folded: Sequence[PatternCrease], off: float
) -> Iterator[VertexViolation]:
    if not folded or len(folded) % 2:
        return
    gaps, shortest = angles_around(pattern, vertex, folded)[1:]
    error = abs(sum(gaps[::2]) - pi)
    if error > ANGLE + off / shortest:
        yield VertexViolation(
            pattern.name(vertex),
            "Kawasaki",
            f"Alternate angles add up to {sum(gaps[::2]) * 180 / pi:.4g} and {sum(gaps[1::2]) * 180 / pi:.4g} degrees; "
            "both must be 180.",
        )


def angles_around(
    pattern: CreasePattern, vertex: int, folded: Sequence[PatternCrease]
) -> tuple[list[PatternCrease], list[float], float]:
    """The creases around a vertex by their angle, the angles from each to the next, and the length of the shortest."""
    x, y = pattern.vertices_coords[vertex]
    ends = [pattern.vertices_coords[c.edge[0] if c.edge[1] == vertex else c.edge[1]] for c in folded]
    turns = [atan2(v - y, u - x) for u, v in ends]
    order = sorted(range(len(turns)), key=turns.__getitem__)
    angles = [turns[k] for k in order]
    gaps = [b - a for a, b in zip(angles, [*angles[1:], angles[0] + tau], strict=True)]
    return [folded[k] for k in order], gaps, min(hypot(u - x, v - y) for u, v in ends)
