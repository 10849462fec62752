"""What a plan moves against what the images between two photos show moving: a lifted flap tells the side and the layers."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from folding_server.arrays import Bools, Floats
from folding_server.geometry.isometry import turn
from folding_server.geometry.line import Point
from folding_server.geometry.point_batch import transformed
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.motion import ObservedMovement
from folding_server.vision.registration.scene import spread_over

MOVED = 0.03
"""Paper that a plan puts less far away (sheet units) has not moved."""
STILL_SHARE = 0.4
"""Paper that turns over may look the same in the images there are: that it does speaks only so much against it."""
FEWEST_LOOKS = 2
"""Images that have to show a place for its lying still to mean anything, and all of them but one."""
DIMMED_SHARE = 0.15
"""Paper that looks different but shows the same side may lie in a shadow: so much that speaks against its lying still."""
REFUTED_SHARE = 0.2
"""The share of the paper that has to contradict a plan for it to be as good as refuted."""
LITTLE = 20.0
"""A turn by fewer degrees bares too little of the table to tell."""
NOWHERE = 1e3
"""The coordinates of what is not on the paper."""
_POINTS = 300
"""Places that are watched, spread over what was seen."""
_FEWEST = 20
"""With fewer places on the paper nothing is said."""


@dataclass(frozen=True)
class WatchedPlaces:
    """Places on the folded paper (n, 2) that were watched between two photos, and what was seen there.

    Whether each ``changed`` its look in some image, or was ``still`` in most of them; whether the other side was
    seen, ``turned``, or the table, ``bare``.
    """

    places: Floats
    changed: Bools
    still: Bools
    turned: Bools
    bare: Bools


def watched_places(movement: ObservedMovement, last: Similarity) -> WatchedPlaces:
    """The visible paper of the photo before, in the plane of its state, which lay there under the motion ``last``."""
    spots = spread_over(movement.watched > 0, _POINTS)
    plane = movement.before.grid.to_plane(np.stack([spots[1], spots[0]], axis=1))
    changed, turned, bare = (
        np.asarray(share[spots] > 0) for share in (movement.moved, movement.turned, movement.bared)
    )
    often = movement.watched[spots] >= max(FEWEST_LOOKS, movement.images - 1)
    return WatchedPlaces(transformed(plane, last.inverse()), changed, ~changed & often, turned, bare)


def contradiction(before: Paper, after: Paper, seen: WatchedPlaces) -> float:
    """How much the images in between speak against a plan, from 0 to 1.

    Where the plan leaves any paper, or turns the whole so that some is always there, the table cannot show; where
    it leaves the paper on top in sight, its other side cannot. Paper that turns over is seen to change, and so is
    what a turn of the whole bares on its way. The share of the watched places where this is not so counts, 1 from
    REFUTED_SHARE on. Paper that stays but is covered afterwards may look like anything. Too few places say nothing.
    """
    if len(seen.places) < _FEWEST:
        return 0.0
    layers = [_layer(before, after, face, seen.places) for face in reversed(before.order)]
    found = np.any([layer.here for layer in layers], axis=0)
    stays = np.any([layer.here & ~layer.moves for layer in layers], axis=0)
    top = _topmost(layers)
    shown = ~top.moves & (np.linalg.norm(_on_top(after, seen.places) - top.sheet, axis=1) < MOVED)
    slides = before.faces == after.faces and not any(layer.turns.any() for layer in layers)
    covered = _turning(before, after, seen.places) if slides else [stays]
    swept, kept = ~covered[len(covered) // 2] & slides, np.all(covered, axis=0)
    impossible = ((stays | kept) & seen.bare) | ((shown | slides) & seen.turned)
    unlikely = DIMMED_SHARE * (shown & seen.changed) + STILL_SHARE * ((top.turns | swept) & seen.still)
    wrong = np.where(impossible, 1.0, unlikely)[found]
    return min(1.0, float(wrong.mean()) / REFUTED_SHARE) if len(wrong) else 0.0


@dataclass(frozen=True)
class _Layer:
    """One face at each place: whether it is ``here``, the point of the ``sheet`` there, and what becomes of that."""

    here: Bools
    sheet: Floats
    moves: Bools
    turns: Bools


def _layer(before: Paper, after: Paper, face: int, places: Floats) -> _Layer:
    here = _inside(before.polygon(face), places)
    sheet = np.where(here[:, None], transformed(places, before.isometries[face].inverse()), NOWHERE)
    there, back = _now_at(after, sheet)
    turns = here & (back != before.back_up(face))
    return _Layer(here, sheet, turns | (here & (np.linalg.norm(there - places, axis=1) > MOVED)), turns)


def _topmost(layers: Sequence[_Layer]) -> _Layer:
    """What lies on top at each place, of layers from top to bottom."""
    places = np.argmax([layer.here for layer in layers], axis=0), np.arange(len(layers[0].here))
    return _Layer(
        np.stack([layer.here for layer in layers])[places],
        np.stack([layer.sheet for layer in layers])[places],
        np.stack([layer.moves for layer in layers])[places],
        np.stack([layer.turns for layer in layers])[places],
    )


def _turning(before: Paper, after: Paper, places: Floats) -> list[Bools]:
    """Which places the paper covers at each eighth of the way of a turn of the whole of it in its plane."""
    face = next(iter(before.faces))
    whole = after.isometries[face].after(before.isometries[face].inverse())
    degrees = -math.degrees(math.atan2(whole.c, whole.a))
    if abs(degrees) < LITTLE:
        return [_covered(before, places)]
    (x, y) = np.linalg.solve([[1 - whole.a, -whole.b], [-whole.c, 1 - whole.d]], [whole.e, whole.f])
    return [
        _covered(before, transformed(places, turn(-degrees * eighth / 8, (float(x), float(y)))))
        for eighth in range(9)
    ]


def _covered(paper: Paper, places: Floats) -> Bools:
    return np.asarray(np.any([_inside(paper.polygon(face), places) for face in paper.faces], axis=0))


def _on_top(paper: Paper, places: Floats) -> Floats:
    """The point of the sheet that shows at each place."""
    sheet = np.full_like(places, NOWHERE)
    for face in paper.order:
        inside = _inside(paper.polygon(face), places)
        sheet[inside] = transformed(places[inside], paper.isometries[face].inverse())
    return sheet


def _now_at(paper: Paper, sheet: Floats) -> tuple[Floats, Bools]:
    """Where points of the sheet lie now, and whether back up."""
    now, back = np.full_like(sheet, NOWHERE), np.zeros(len(sheet), bool)
    for face in paper.faces:
        inside = _inside(paper.sheet_polygon(face), sheet)
        now[inside] = transformed(sheet[inside], paper.isometries[face])
        back[inside] = paper.back_up(face)
    return now, back


def _inside(outline: Sequence[Point], places: Floats) -> Bools:
    """Which places a convex outline contains."""
    corners = np.array(outline)
    sides = np.roll(corners, -1, axis=0) - corners
    offsets = places[:, None] - corners[None]
    turns = sides[:, 0] * offsets[..., 1] - sides[:, 1] * offsets[..., 0]
    return np.asarray((turns >= -1e-9).all(axis=1) | (turns <= 1e-9).all(axis=1))
