"""Hands over the paper: a shape of rounded limbs with skin, nails and a sleeve, reaching in from a side of
the picture.

A hand is built upright, the wrist at the origin and the middle finger along +y, with its length as the unit.
"""

from dataclasses import dataclass
from math import cos, radians, sin
from typing import TYPE_CHECKING

import cv2
import numpy as np

from folding_server.arrays import ByteMask, Float32s
from folding_server.photographer.color_spaces import floats, linear_color
from folding_server.photographer.levels import Level
from folding_server.photographer.rng import stream

if TYPE_CHECKING:
    from folding_server.photographer.pinhole_camera import Matrix

SKINS = ("#f0c8ac", "#e3b08d", "#c98f68", "#9a6543", "#6d442c", "#f3d2bd")
SLEEVES = ("#2f4a78", "#7a2f35", "#3c3f42", "#56705a", "#c9c4b8", "#8a7fa0", "#d8d4cc")
POSES = {"press": 1.0, "point": 0.5, "pinch": 0.68}
"""Pose -> how far the three outer fingers are stretched."""
HOLD, HOLDING = "hold", (0.4, 0.8, -8.0)
"""The pose that holds an edge: how far the outer fingers and the first are stretched, and the thumb's tilt."""
SIDES = {"right": 180.0, "left": 0.0, "near": 90.0}
"""Side of the picture -> direction in which the hand reaches, in degrees counter-clockwise from the right."""
MOST_COVER = 0.2
HAND_LENGTH = (0.95, 1.15)
"""Length of a hand in sheet sides."""


CUFF = -0.02
"""Where the sleeve ends along the hand."""


@dataclass(frozen=True)
class Limb:
    """A straight piece with round ends: from ``start`` with radius ``r0`` to ``end`` with radius ``r1``."""

    start: tuple[float, float]
    end: tuple[float, float]
    r0: float
    r1: float


@dataclass(frozen=True)
class Hand:
    """A hand before it is placed: skin ``limbs``, ``nails`` (centre x, y, direction in degrees, radius), the
    sleeve.
    """

    pose: str
    left: bool
    limbs: tuple[Limb, ...]
    nails: tuple[tuple[float, float, float, float], ...]
    sleeve: Limb
    skin: str
    cloth: str


@dataclass(frozen=True)
class PlacedHand:
    """Where a hand is: its wrist in pixels, ``scale`` pixels to its length, ``angle`` of the fingers in
    degrees.
    """

    hand: Hand
    side: str
    wrist: tuple[float, float]
    scale: float
    angle: float
    covered: float


@dataclass(frozen=True)
class RenderedHand:
    """What a hand does to a picture: linear colour (h, w, 3), its opacity (h, w) and the light it leaves (h,
    w).
    """

    color: Float32s
    opacity: Float32s
    light: Float32s


def reaching_hand(seed: int, level: Level, frame: int, coverage: ByteMask, unit: float) -> PlacedHand | None:
    """The hand in a frame, if there is one: over the edge of the paper, covering at most a fifth of it.

    ``coverage`` is the paper in the picture (0 to 255), ``unit`` pixels to a sheet side. The first frame has
    none.
    """
    rng = stream(seed, "hands", frame)
    if frame == 0 or rng.random() >= level.hands:
        return None
    hand = built_hand(seed, rng)
    side = str(rng.choice(list(SIDES)))
    angle = SIDES[side] + rng.normal(0, 14)
    scale = unit * stream(seed, "person").uniform(*HAND_LENGTH)
    most = rng.uniform(0.05, MOST_COVER)
    aim = _aim(rng, coverage)
    for back in np.arange(-0.1, 2.0, 0.04):
        distance = scale * (0.8 + back)
        wrist = (aim[0] - distance * cos(radians(angle)), aim[1] + distance * sin(radians(angle)))
        placed = PlacedHand(hand, side, wrist, scale, angle, 0.0)
        covered = covered_share(placed, coverage)
        if covered <= most:
            return PlacedHand(hand, side, wrist, scale, angle, covered) if covered > 0.01 else None
    return None


def _aim(rng: np.random.Generator, coverage: ByteMask) -> tuple[float, float]:
    """A spot on the paper that the fingers go for."""
    ys, xs = np.nonzero(coverage > 127)
    i = int(rng.integers(len(xs)))
    return 0.5 * (float(xs[i]) + float(xs.mean())), 0.5 * (float(ys[i]) + float(ys.mean()))


def covered_share(placed: PlacedHand, coverage: ByteMask) -> float:
    """Part of the paper that a hand hides, measured on every fourth pixel."""
    coarse = coverage[::4, ::4] > 127
    points = _local(placed, coverage.shape, 4)
    reachable = np.maximum(_height(placed.hand.limbs, points), _sleeve(placed.hand, points)) > 0
    return float((reachable & coarse).sum() / max(coarse.sum(), 1))


def built_hand(seed: int, rng: np.random.Generator, pose: str | None = None) -> Hand:
    """One hand of the person who folds, in a pose of this moment; drawn from POSES if it is not given."""
    person = stream(seed, "person")
    skin, cloth = str(person.choice(SKINS)), str(person.choice(SLEEVES))
    pose = pose or str(rng.choice(list(POSES)))
    left = bool(rng.random() < 0.5)
    limbs: list[Limb] = []
    nails: list[tuple[float, float, float, float]] = []
    spread = rng.uniform(0.5, 1.3)
    fingers = (
        (-0.155, 0.5, -9, 0.37),
        (-0.05, 0.53, -2, 0.43),
        (0.055, 0.51, 5, 0.39),
        (0.145, 0.455, 13, 0.3),
    )
    for i, (x, y, tilt, length) in enumerate(fingers):
        limbs.append(Limb((0.42 * x, 0.02), (x, y - 0.02), 0.105, 0.066))
        stretch = (HOLDING[1] if pose == HOLD else 1.0) if i == 0 else POSES.get(pose, HOLDING[0])
        limbs += _finger((x, y), spread * tilt + rng.normal(0, 2), length * stretch, 0.055, nails, rng)
    limbs.append(Limb((-0.08, 0.12), (-0.2, 0.3), 0.09, 0.068))
    limbs.append(Limb((0, -0.2), (0, 0.1), 0.115, 0.12))
    thumb = HOLDING[2] if pose == HOLD else -24.0
    limbs += _finger((-0.2, 0.3), thumb + rng.normal(0, 8), 0.24, 0.06, nails, rng)
    return Hand(pose, left, tuple(limbs), tuple(nails), Limb((0, 0.05), (0, -3), 0.17, 0.32), skin, cloth)


def _finger(
    root: tuple[float, float],
    tilt: float,
    length: float,
    radius: float,
    nails: list[tuple[float, float, float, float]],
    rng: np.random.Generator,
) -> list[Limb]:
    """Two straight pieces, the second bent inwards, and a nail; ``tilt`` degrees clockwise from +y."""
    parts, at, bend = [], root, tilt
    for share, r0, r1 in ((0.55, 1.0, 0.88), (0.45, 0.9, 0.7)):
        end = (at[0] + share * length * sin(radians(bend)), at[1] + share * length * cos(radians(bend)))
        parts.append(Limb(at, end, radius * r0, radius * r1))
        at, bend = end, bend * 0.4 + rng.normal(0, 2)
    nails.append((at[0], at[1], bend, radius * 0.52))
    return parts


def _local(placed: PlacedHand, shape: tuple[int, ...], step: int = 1) -> tuple[Float32s, Float32s]:
    """Coordinates in the hand's own frame of every ``step``-th pixel of a picture of a shape."""
    y, x = np.mgrid[0 : shape[0] : step, 0 : shape[1] : step].astype(np.float32)
    dx, dy = (x + 0.5 - placed.wrist[0]) / placed.scale, -(y + 0.5 - placed.wrist[1]) / placed.scale
    c, s = cos(radians(placed.angle)), sin(radians(placed.angle))
    along, across = c * dx + s * dy, s * dx - c * dy
    return ((-across if placed.hand.left else across).astype(np.float32), along.astype(np.float32))


def _height(limbs: tuple[Limb, ...], points: tuple[Float32s, Float32s]) -> Float32s:
    """Height of the limbs' round backs over the table, 0 beside them."""
    total = np.zeros(points[0].shape, np.float32)
    for limb in limbs:
        (x0, y0), (x1, y1) = limb.start, limb.end
        dx, dy = x1 - x0, y1 - y0
        t = np.clip(((points[0] - x0) * dx + (points[1] - y0) * dy) / (dx * dx + dy * dy), 0, 1)
        gap = (points[0] - x0 - t * dx) ** 2 + (points[1] - y0 - t * dy) ** 2
        radius = limb.r0 + t * (limb.r1 - limb.r0)
        np.maximum(total, np.sqrt(np.maximum(radius * radius - gap, 0)), out=total)
    return total


def _sleeve(hand: Hand, points: tuple[Float32s, Float32s]) -> Float32s:
    """Height of the sleeve over the table: round across, cut off at the cuff."""
    x, y = points
    return floats(_height((hand.sleeve,), points) * (y < CUFF - 0.8 * x * x))


def render_hand(
    placed: PlacedHand, shape: tuple[int, int], towards: tuple[float, float], seed: int, frame: int
) -> RenderedHand:
    """Skin, nails and sleeve of a hand in a picture of (height, width), and its soft shadow thrown
    ``towards``.
    """
    points = _local(placed, shape)
    rng = stream(seed, "skin", frame)
    flesh, cloth = _height(placed.hand.limbs, points), _sleeve(placed.hand, points)
    skin_light = _lit(flesh, placed, towards, 0.014)
    color = linear_color(placed.hand.skin) * (skin_light * _mottled(rng, shape))[..., None]
    thin = np.exp(-flesh / 0.025)[..., None] * np.array([0.04, -0.05, -0.06], np.float32)
    color = _with_nails(color * (1 + thin), placed.hand, points, skin_light)
    sleeve = (
        linear_color(placed.hand.cloth)
        * (_lit(cloth, placed, towards, 0.02) * _woven(rng, points))[..., None]
    )
    over, bare = _edge(cloth, placed.scale), _edge(flesh, placed.scale)
    opacity = np.maximum(bare, over)
    share = (over / np.maximum(over + bare * (1 - over), 1e-3))[..., None]
    mixed = (color * (1 - share) + sleeve * share).astype(np.float32)
    return RenderedHand(mixed, opacity, _shadow(opacity, placed.scale, towards))


def _edge(height: Float32s, scale: float) -> Float32s:
    """Opacity 0 to 1 with an edge about one pixel wide."""
    solid = (height > 0).astype(np.float32)
    return floats(cv2.GaussianBlur(solid, (0, 0), max(0.6, scale / 700)))


def _lit(height: Float32s, placed: PlacedHand, towards: tuple[float, float], soften: float) -> Float32s:
    """Brightness of a rounded surface under the lamp, darker where limbs meet."""
    smooth = cv2.GaussianBlur(height, (0, 0), max(soften * placed.scale, 0.5)) * np.float32(placed.scale)
    slope_y, slope_x = np.gradient(smooth)
    facing = (slope_x * towards[0] + slope_y * towards[1] + 1.1) / np.sqrt(slope_x**2 + slope_y**2 + 1)
    wide = cv2.GaussianBlur(height, (0, 0), 0.05 * placed.scale) * np.float32(placed.scale)
    crevice = np.clip((smooth - wide) / (0.05 * placed.scale), -1, 0.3)
    return floats(np.clip(0.42 + 0.42 * facing + 0.18 * crevice, 0.12, 1.15))


def _mottled(rng: np.random.Generator, shape: tuple[int, int]) -> Float32s:
    """Uneven skin: brightness about 1."""
    coarse = rng.standard_normal((shape[0] // 24 + 2, shape[1] // 24 + 2), np.float32)
    fine = rng.standard_normal((shape[0] // 4 + 2, shape[1] // 4 + 2), np.float32)
    size = (shape[1], shape[0])
    clouds = cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC)
    pores = cv2.resize(fine, size, interpolation=cv2.INTER_LINEAR)
    return floats(1 + 0.035 * clouds + 0.025 * pores)


def _woven(rng: np.random.Generator, points: tuple[Float32s, Float32s]) -> Float32s:
    """Cloth of a sleeve: folds across it, a darker hem, threads."""
    x, y = points
    wobble = np.sin(9 * x + rng.uniform(0, 6)) * 0.05
    folds = np.sin((y + wobble) * 21 + rng.uniform(0, 6)) * np.sin((y - 0.6 * x) * 8.3 + rng.uniform(0, 6))
    hem = 1 - 0.3 * np.exp(-(((y - CUFF + 0.045 + 0.8 * x * x) / 0.007) ** 2))
    thread = rng.standard_normal(x.shape, np.float32)
    return floats((1 + 0.13 * folds + 0.05 * thread) * hem)


def _with_nails(color: Float32s, hand: Hand, points: tuple[Float32s, Float32s], light: Float32s) -> Float32s:
    """Nails: paler, a little shiny, rounded at the finger's end."""
    tone = np.clip(linear_color(hand.skin) * np.array([1.12, 1.08, 1.1], np.float32) + 0.05, 0, 1)
    for x, y, tilt, radius in hand.nails:
        c, s = cos(radians(tilt)), sin(radians(tilt))
        spot = np.nonzero((np.abs(points[0] - x) < 2 * radius) & (np.abs(points[1] - y) < 2 * radius))
        dx, dy = points[0][spot] - x, points[1][spot] - y
        across, along = (c * dx - s * dy) / radius, (s * dx + c * dy - 0.3 * radius) / (1.35 * radius)
        inside = 0.75 * np.clip((1 - across**2 - along**2) * 3, 0, 1)[:, None]
        color[spot] = color[spot] * (1 - inside) + tone * inside * (light[spot] * 0.9 + 0.12)[:, None]
    return floats(color)


def _shadow(opacity: Float32s, scale: float, towards: tuple[float, float]) -> Float32s:
    """Light that is left round a hand: a dark line of contact and a wide soft shadow."""
    light = np.ones_like(opacity)
    for offset, blur, depth in ((0.02, 0.02, 0.3), (0.1, 0.06, 0.42)):
        motion: Matrix = np.array([[1, 0, towards[0] * offset * scale], [0, 1, towards[1] * offset * scale]])
        moved = cv2.warpAffine(opacity, motion, opacity.shape[::-1], borderMode=cv2.BORDER_REPLICATE)
        light = light * (1 - np.float32(depth) * cv2.GaussianBlur(moved, (0, 0), blur * scale))
    return light.astype(np.float32)
