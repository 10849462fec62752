"""The eye of a film: from straight above or a little from the front, far enough that all of every state is seen."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np

from folding_server.animation.scenes import FaceInSpace
from folding_server.arrays import Floats

EYE_TILT = {"straight": 0.0, "tilted": 32.0}
"""Degrees by which the eye is lowered towards the front, by the name of the view."""
DISTANCE = 5.0
"""Sheet units from the eye to the middle of the paper: near enough for depth, far enough for little distortion."""
LIGHT = np.array([-0.35, 0.45, 0.82])
"""Direction towards the lamp: from the upper left, as usual in drawings."""
AMBIENT_PART = 0.62
"""The part of the light that comes from all sides."""
LAYER_SHADE = 0.025
"""By how much darker each layer further down is."""


@dataclass(frozen=True)
class FilmCamera:
    """Projects sheet units about the middle of the paper to pixels: ``scale`` at that middle, which is at ``center``."""

    scale: float
    center: tuple[float, float]
    tilt: float

    def pixels(self, corners: Floats) -> Floats:
        """Where corners (n, 3) are seen: (n, 2), y down."""
        angle = radians(self.tilt)
        up = corners[:, 1] * cos(angle) + corners[:, 2] * sin(angle)
        toward = -corners[:, 1] * sin(angle) + corners[:, 2] * cos(angle)
        grown = self.scale * DISTANCE / (DISTANCE - toward)
        return np.column_stack([self.center[0] + corners[:, 0] * grown, self.center[1] - up * grown])


@dataclass(frozen=True)
class PaintedFace:
    """A face as it is seen: its outline (n, 2) in pixels, whether its back is seen, how much light it gets."""

    face: int
    outline: Floats
    back_seen: bool
    light: float


def painted(faces: Iterable[FaceInSpace], camera: FilmCamera, over: bool) -> list[PaintedFace]:
    """The faces, from bottom to top as they lie after, in the order in which they are painted: each over what it hides.

    What moves ``over`` the rest is painted after it, what moves under it before; in reverse, while the side of it is seen that
    is down afterwards. Seen from above nothing in the plane of the table hides what is over it, nor is hidden by what is under it.
    """
    seen = [(each, camera.pixels(each.corners)) for each in faces]
    moving, resting = ([pair for pair in seen if pair[0].moves is moves] for moves in (True, False))
    away = _turned_away(moving)
    moving = moving[::-1] if away else moving
    top = max(each.level for each, _ in seen)
    ordered = [*resting, *moving] if over else [*moving, *resting]
    return [
        PaintedFace(each.face, outline, each.back_up != (away and each.moves), _light(each, top))
        for each, outline in ordered
    ]


def _light(each: FaceInSpace, top: float) -> float:
    """How bright a face is: 1 for the topmost that lies flat."""
    normal = _normal(each.corners)
    facing = abs(float(normal @ LIGHT)) / float(LIGHT[2])
    return min(1.06, AMBIENT_PART + (1 - AMBIENT_PART) * facing) * (1 - LAYER_SHADE * (top - each.level))


def _normal(corners: Floats) -> Floats:
    """The unit normal of a flat polygon, from the sum of the products of its corners; straight up where it has no area."""
    x, y, z = corners.T
    x2, y2, z2 = np.concatenate([corners[1:], corners[:1]]).T
    total = np.array([y @ z2 - z @ y2, z @ x2 - x @ z2, x @ y2 - y @ x2])
    length = float(np.linalg.norm(total))
    return np.asarray(total / length) if length > 1e-12 else np.array([0.0, 0.0, 1.0])


def _turned_away(moving: Sequence[tuple[FaceInSpace, Floats]]) -> bool:
    """Whether of what moves the side is seen that is down after the movement: the face that is seen largest tells."""
    if not moving:
        return False
    signed, each = max(
        ((_signed_area(outline), each) for each, outline in moving), key=lambda pair: abs(pair[0])
    )
    return (signed > 0) != (each.area > 0)


def _signed_area(outline: Floats) -> float:
    """The signed area of an outline in pixels, positive if it runs counter-clockwise as seen."""
    x, y = outline.T
    return -float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
