"""Things on the table beside the paper: pens, cards, rulers and coins, which stay where they are or are moved between photos."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, radians, sin

import cv2
import numpy as np

from folding_server.arrays import Float32s
from folding_server.geometry.line import Point
from folding_server.photographer.color_spaces import linear_color
from folding_server.photographer.levels import Level
from folding_server.photographer.pinhole_camera import Matrix
from folding_server.photographer.rng import stream
from folding_server.photographer.table import TABLE_TEXTURE_SIDE, table_to_texture

THING_SIZES = {
    "pen": (0.75, 0.045),
    "card": (0.57, 0.36),
    "ruler": (1.0, 0.16),
    "coin": (0.14, 0.14),
    "cup": (0.5, 0.5),
}
"""Length and width in sides of a sheet of 15 cm."""
ROUND_KINDS = frozenset({"coin", "cup"})
THING_COLORS = ("#20242a", "#b3272d", "#2d5fa8", "#d8b13a", "#e6e2d8", "#4f7f4a", "#9a9ca0")
FREE_MARGIN = (0.1, 0.5)
"""Sheet sides between the paper's furthest reach and a thing."""
CHANCE_MOVED = 0.3
"""How likely a thing lies elsewhere in the next photo."""
PLACES_TRIED = 40
"""Places that are tried for a thing until one is free; else it is left away."""
_SHADOW, _SHADOW_DEPTH = 0.012, 0.45
_SHIFT = 4


@dataclass(frozen=True)
class TableObject:
    """A thing: what it is, its colour, the middle on the table (sheet sides), and how it is turned (degrees)."""

    kind: str
    color: str
    middle: Point
    angle: float

    @property
    def reach(self) -> float:
        """Half of its length."""
        return THING_SIZES[self.kind][0] / 2

    @property
    def outline(self) -> Matrix:
        """Its outline (n, 2) on the table."""
        length, width = THING_SIZES[self.kind]
        if self.kind in ROUND_KINDS:
            around = np.linspace(0, 2 * np.pi, 48, endpoint=False)
            plain = np.column_stack([np.cos(around), np.sin(around)]) * length / 2
        else:
            plain = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * [length / 2, width / 2]
        c, s = cos(radians(self.angle)), sin(radians(self.angle))
        return np.asarray(plain @ np.array([[c, s], [-s, c]]) + self.middle)


def table_objects(
    seed: int, level: Level, keyframes: int, paper_reach: float
) -> list[tuple[TableObject, ...]]:
    """What lies on the table at each keyframe, further from its middle than the paper ever reaches."""
    rng = stream(seed, "objects")
    lying: list[TableObject] = []
    for _ in range(int(rng.integers(1, level.objects + 1)) if level.objects else 0):
        kind, color = str(rng.choice(list(THING_SIZES))), str(rng.choice(THING_COLORS))
        placed = _placed(rng, TableObject(kind, color, (0.0, 0.0), 0.0), lying, paper_reach)
        lying += [placed] if placed else []
    shown = [tuple(lying)]
    for _ in range(1, keyframes):
        for number, each in enumerate(lying):
            if rng.random() < CHANCE_MOVED:
                others = [*lying[:number], *lying[number + 1 :]]
                lying[number] = _placed(rng, each, others, paper_reach) or each
        shown.append(tuple(lying))
    return shown


def _placed(
    rng: np.random.Generator, thing: TableObject, others: Sequence[TableObject], paper_reach: float
) -> TableObject | None:
    """The thing at a place that is free, or None."""
    for _ in range(PLACES_TRIED):
        away = paper_reach + thing.reach + rng.uniform(*FREE_MARGIN)
        towards, angle = radians(rng.uniform(-180, 180)), float(rng.uniform(-180, 180))
        middle = (float(away * cos(towards)), float(away * sin(towards)))
        if all(np.hypot(*np.subtract(middle, o.middle)) > thing.reach + o.reach for o in others):
            return replace(thing, middle=middle, angle=angle)
    return None


def under_way(
    first: Sequence[TableObject], second: Sequence[TableObject], share: float
) -> tuple[TableObject, ...]:
    """The things a part of the way from where they lie at one keyframe to where they lie at the next."""
    return tuple(
        replace(
            a,
            middle=(
                a.middle[0] + share * (b.middle[0] - a.middle[0]),
                a.middle[1] + share * (b.middle[1] - a.middle[1]),
            ),
            angle=a.angle + share * (b.angle - a.angle),
        )
        for a, b in zip(first, second, strict=True)
    )


def laid_on(texture: Float32s, things: Sequence[TableObject]) -> Float32s:
    """The table's texture with things on it, each with a soft shadow around."""
    if not things:
        return texture
    laid = texture.copy()
    scale = table_to_texture()
    for thing in things:
        points = thing.outline @ scale[:2, :2].T + scale[:2, 2]
        mask = np.zeros((TABLE_TEXTURE_SIDE, TABLE_TEXTURE_SIDE), np.uint8)
        cv2.fillPoly(mask, [np.rint(points * 2**_SHIFT).astype(np.int32)], 255, cv2.LINE_AA, _SHIFT)
        shade = cv2.GaussianBlur(mask, (0, 0), _SHADOW * float(scale[0, 0])).astype(np.float32) / 255
        solid = (mask.astype(np.float32) / 255)[..., None]
        laid *= (1 - np.float32(_SHADOW_DEPTH) * shade)[..., None]
        laid[:] = (1 - solid) * laid + solid * linear_color(thing.color)
    return np.asarray(laid, np.float32)
