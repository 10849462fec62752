"""Whether two papers are in the same state, whatever the numbers of their vertices and wherever on the table they lie."""

from math import dist

import numpy as np

from folding_server.geometry.convex import area
from folding_server.geometry.line import Point
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator import Paper, overlapping_pairs

ALIKE = 10 * TOLERANCE
"""Points of two states in which nobody sees a difference: a sixth of a millimetre on a sheet of 15 cm."""


def shift_between(first: Paper, second: Paper, within: float = ALIKE) -> Point | None:
    """By how much the second paper lies elsewhere on the table, if it is otherwise in the same state; None if it is not.

    The same faces lie on the sheet, in the same places but for the shift, the same sides up, in the same order where they
    overlap. Vertices within an edge do not count. ``within`` is in sheet units.
    """
    twin = _twins(first, second)
    if twin is None:
        return None
    if any(first.back_up(face) != second.back_up(other) for face, other in twin.items()):
        return None
    face, other = next(iter(twin.items()))
    at = first.sheet_polygon(face)[0]
    (x, y), (u, v) = first.isometries[face](at), second.isometries[other](at)
    shift = u - x, v - y
    for face, other in twin.items():
        for at in first.sheet_polygon(face):
            (x, y), there = first.isometries[face](at), second.isometries[other](at)
            if dist((x + shift[0], y + shift[1]), there) > within:
                return None
    rank = second.rank
    if any(rank[twin[lower]] > rank[twin[upper]] for lower, upper in overlapping_pairs(first)):
        return None
    return shift


def _twins(first: Paper, second: Paper) -> dict[int, int] | None:
    """For each face of the first paper that of the second with the same outline on the sheet; None if any has none."""
    if len(first.faces) != len(second.faces):
        return None
    ids, others = list(first.faces), list(second.faces)
    here, there = _shapes(first), _shapes(second)
    apart = np.abs(here[:, None] - there[None]).max(axis=2)
    nearest = apart.argmin(axis=1)
    if len(set(nearest.tolist())) < len(ids) or apart.min(axis=1).max() > ALIKE:
        return None
    return {face: others[i] for face, i in zip(ids, nearest.tolist(), strict=True)}


def _shapes(paper: Paper) -> np.ndarray:
    """Middle (x, y), area and box of each face on the sheet: (faces, 7)."""
    rows = []
    for face in paper.faces:
        outline = paper.sheet_polygon(face)
        xs, ys = [x for x, _ in outline], [y for _, y in outline]
        rows.append((*_middle(outline), abs(area(outline)), min(xs), min(ys), max(xs), max(ys)))
    return np.array(rows)


def _middle(outline: list[Point]) -> Point:
    """The centroid of an outline, which corners within its sides do not move."""
    whole = x = y = 0.0
    x0, y0 = outline[0]
    for (x1, y1), (x2, y2) in zip(outline, [*outline[1:], outline[0]], strict=True):
        cross = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        whole, x, y = whole + cross, x + cross * (x0 + x1 + x2) / 3, y + cross * (y0 + y1 + y2) / 3
    return (x / whole, y / whole) if abs(whole) > 1e-12 else outline[0]
