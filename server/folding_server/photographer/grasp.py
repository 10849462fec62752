"""The hand that moves the paper: thumb and first finger at the edge that moves, the arm clear of the paper."""

from collections.abc import Sequence
from dataclasses import replace
from math import cos, radians, sin

import numpy as np

from folding_server.arrays import ByteMask
from folding_server.geometry.line import Point
from folding_server.photographer.hand_model import (
    HAND_LENGTH,
    HOLD,
    SIDES,
    Hand,
    PlacedHand,
    built_hand,
    covered_share,
)
from folding_server.photographer.movements import Movement, Slide, Swing
from folding_server.photographer.pinhole_camera import Camera, Matrix
from folding_server.photographer.rng import stream

EDGE = 0.03
"""How far from the outermost paper its edge may be held, and how far in, in sheet sides."""
UNDECIDED = 0.15
"""Deviation, in sheet sides, of the choice between arms that are about as clear of the paper."""


def grasp_point(movement: Movement, rng: np.random.Generator) -> Point:
    """A spot of the moving paper at the edge, where it lay before the movement: far from the line it turns about."""
    if isinstance(movement, Slide):
        return _corner(list(movement.before.folded_vertices_coords.values()), rng)
    points = [
        m(movement.paper.vertices_coords[v])
        for f, m in movement.starts.items()
        for v in movement.paper.faces[f]
    ]
    return _far_edge(movement, points, rng)


def _corner(points: Sequence[Point], rng: np.random.Generator) -> Point:
    """A spot near one of the vertices furthest from the middle."""
    spots = np.array(points)
    middle = spots.mean(0)
    away = np.linalg.norm(spots - middle, axis=1)
    corner = spots[rng.choice(np.nonzero(away > away.max() - EDGE)[0])]
    x, y = corner + (middle - corner) * EDGE / max(float(away.max()), EDGE)
    return float(x), float(y)


def _far_edge(swing: Swing, points: Sequence[Point], rng: np.random.Generator) -> Point:
    """A spot between the points furthest from the line, a little nearer to it."""
    line = swing.line
    reach = max(line.distance(p) for p in points)
    edge = np.array([p for p in points if line.distance(p) > reach - EDGE])
    x, y = rng.dirichlet(np.full(len(edge), 4.0)) @ edge
    inwards = min(EDGE, reach / 2)
    return float(x) - inwards * line.nx, float(y) - inwards * line.ny


def arm_side(rng: np.random.Generator, way: Matrix, middle: Matrix, unit: float) -> str:
    """The side of the picture whose arm is clear of the paper along the hand's way (n, 2) past its middle (pixels)."""
    out = (way.mean(0) - middle) / unit
    clear = {
        side: -(out[0] * cos(radians(angle)) - out[1] * sin(radians(angle))) + rng.normal(0, UNDECIDED)
        for side, angle in SIDES.items()
    }
    return max(clear, key=lambda side: clear[side])


def grasping_hand(
    seed: int,
    keyframe: int,
    side: str,
    spot: Matrix,
    camera: Camera,
    coverage: ByteMask,
    unit: float,
) -> PlacedHand:
    """The hand that holds a ``spot`` (3,) over the table, the same during all of the way from a keyframe.

    ``coverage`` is the paper in the picture (0 to 255), ``unit`` pixels to a sheet side on the table.
    """
    rng = stream(seed, "folding hand", keyframe)
    hand = built_hand(seed, rng, HOLD)
    hand = replace(hand, left=side == "left" or (side == "near" and hand.left))
    angle = SIDES[side] + float(rng.normal(0, 12))
    nearer = camera.t[2] / (camera.R @ spot + camera.t)[2]
    scale = unit * stream(seed, "person").uniform(*HAND_LENGTH) * nearer
    x, y = camera.project(spot)[0]
    dx, dy = _fingertips(hand, angle)
    wrist = (float(x - scale * dx), float(y + scale * dy))
    placed = PlacedHand(hand, side, wrist, scale, angle, 0.0)
    return PlacedHand(hand, side, wrist, scale, angle, covered_share(placed, coverage))


def _fingertips(hand: Hand, angle: float) -> Point:
    """The way from the wrist to between the tips of first finger and thumb, in hands, x right and y up."""
    (x0, y0, *_), (x1, y1, *_) = hand.nails[0], hand.nails[-1]
    across, along = (x0 + x1) / 2, (y0 + y1) / 2
    across = -across if hand.left else across
    c, s = cos(radians(angle)), sin(radians(angle))
    return c * along + s * across, s * along - c * across
