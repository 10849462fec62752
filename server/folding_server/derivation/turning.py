"""The rotations and flips that carry a whole model to where a state has it."""

from collections.abc import Iterator
from math import atan2, degrees
from typing import cast

from folding_schemas.actions import Actions, Flip, FlipAxis, Rotate

from folding_server.derivation.given_states import GivenState
from folding_server.derivation.pose_matching import is_still, pose_between
from folding_server.geometry.isometry import Isometry
from folding_server.simulator import Paper, apply
from folding_server.simulator.motions import FLIP_AXES

SNAPPED_ANGLES = (22.5, 15.0, 1.0, 0.1)
"""Degrees: an angle is taken for the nearest multiple of the first of these that is near enough."""
ANGLE_ROUNDING = 0.25
"""Degrees that an angle may be off: what rounding to 5e-4 does to the direction of a face that is a quarter of the sheet wide,
from both ends.
"""


def turnings(paper: Paper, given: GivenState) -> Iterator[Actions]:
    """The fewest rotations and flips after which a paper is the given state, as candidates that have been tried."""
    pose = pose_between(paper, given)
    if pose is None:
        return
    if is_still(pose, paper):
        yield ()
        return
    for actions in _candidates(paper, given, pose):
        if leads_to(paper, actions, given):
            yield actions


def _candidates(paper: Paper, given: GivenState, pose: Isometry) -> Iterator[Actions]:
    if not pose.mirrors:
        yield (rotation(pose),)
        return
    flips = [Flip(axis=cast("FlipAxis", axis)) for axis in FLIP_AXES]
    yield from ((flip,) for flip in flips)
    for flip in flips:
        left = pose_between(apply(paper, flip), given)
        if left is not None:
            yield flip, rotation(left)


def leads_to(paper: Paper, actions: Actions, given: GivenState) -> bool:
    """Whether actions make a paper the given state. ActionRefused if one is refused."""
    for action in actions:
        paper = apply(paper, action)
    pose = pose_between(paper, given)
    return pose is not None and is_still(pose, paper)


def rotation(pose: Isometry) -> Rotate:
    """The rotation by the angle of a motion that does not turn the model over; clockwise is positive."""
    return Rotate(angle=snapped_angle(-degrees(atan2(pose.c, pose.a))))


def snapped_angle(angle: float) -> float:
    """The angle that was meant, in degrees."""
    for unit in SNAPPED_ANGLES:
        near = round(angle / unit) * unit
        if abs(near - angle) <= ANGLE_ROUNDING:
            return round(near, 6) + 0.0
    return round(angle, 3)
