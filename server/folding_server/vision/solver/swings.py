"""What a plan moves against what the images between two photos show moving: a lifted flap tells the side and the layers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from folding_server.simulator.paper import Paper
from folding_server.simulator.plane_geometry import Isometry, Point
from folding_server.vision.grid import Floats
from folding_server.vision.motion import Movement
from folding_server.vision.solver.alignment import carried, inverse_of
from folding_server.vision.solver.scene import Mask, spread_over

MOVED = 0.03
"""Paper that a plan puts less far away (sheet units) has not moved."""
STILL_SHARE = 0.5
"""Paper without a pattern may be lifted and look the same: that it does speaks only so much against its moving."""
NOWHERE = 1e3
"""The coordinates of what is not on the paper."""
_POINTS = 300
_FEWEST = 20


@dataclass(frozen=True)
class Watched:
    """Places on the folded paper (n, 2) that were watched between two photos, and whether each was seen to change."""

    places: Floats
    changed: Mask


def watched(movement: Movement, last: Isometry) -> Watched:
    """The visible paper of the photo before, in the plane of its state, which lay there under the motion ``last``."""
    rows, cols = spread_over(movement.watched > 0, _POINTS)
    plane = movement.before.grid.to_plane(np.stack([cols, rows], axis=1))
    return Watched(carried(plane, inverse_of(last)), np.asarray(movement.moved[rows, cols] > 0))


def contradiction(before: Paper, after: Paper, seen: Watched) -> float:
    """The share of the watched paper that moved although the plan leaves it, or did not although it should, 0 to 1.

    Paper that stays but is covered afterwards may have changed or not. Too few places say nothing.
    """
    if len(seen.places) < _FEWEST:
        return 0.0
    faces, sheet = _looked_up(before, seen.places)
    found = faces >= 0
    there = _now_at(after, sheet)
    moves = np.linalg.norm(there - seen.places, axis=1) > MOVED
    _, covers = _looked_up(after, seen.places)
    stays_seen = ~moves & (np.linalg.norm(covers - sheet, axis=1) < MOVED)
    wrong = (stays_seen & seen.changed) + STILL_SHARE * (moves & ~seen.changed)
    return float(wrong[found].mean()) if found.any() else 0.0


def _looked_up(paper: Paper, places: Floats) -> tuple[Floats, Floats]:
    """The rank of the top face at each place, -1 off the paper, and the point of the sheet that shows there."""
    ranks = np.full(len(places), -1.0)
    sheet = np.full_like(places, NOWHERE)
    for rank, face in enumerate(paper.order):
        inside = _inside(paper.polygon(face), places)
        ranks[inside] = rank
        sheet[inside] = carried(places[inside], paper.isometries[face].inverse())
    return ranks, sheet


def _now_at(paper: Paper, sheet: Floats) -> Floats:
    """Where points of the sheet lie now."""
    now = np.full_like(sheet, NOWHERE)
    for face in paper.faces:
        inside = _inside(paper.sheet_polygon(face), sheet)
        now[inside] = carried(sheet[inside], paper.isometries[face])
    return now


def _inside(outline: Sequence[Point], places: Floats) -> Mask:
    """Which places a convex outline contains."""
    corners = np.array(outline)
    sides = np.roll(corners, -1, axis=0) - corners
    offsets = places[:, None] - corners[None]
    turns = sides[:, 0] * offsets[..., 1] - sides[:, 1] * offsets[..., 0]
    return np.asarray((turns >= -1e-9).all(axis=1) | (turns <= 1e-9).all(axis=1))
