"""The scene of a sequence: paper, table, lamp and lens, drawn once; and how each frame departs from it."""

from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np

from folding_server.photographer.color_spaces import (
    PALE_TABLES,
    PLAIN_TABLES,
    STOCKS,
    Stock,
    color_difference,
    near_color,
)
from folding_server.photographer.levels import Level
from folding_server.photographer.moments import Moment, frame_jitter
from folding_server.photographer.pinhole_camera import Camera, Matrix, looking_down
from folding_server.photographer.rng import stream

PATTERNS = ("dots", "stripes", "checks")
WOODS = ("#8a623d", "#6b4a2f", "#b58a5a", "#4d3524", "#c7a878")
MATS = ("#1f5a45", "#27476b", "#3a3d40", "#54697a")
CLOTHS = ("#6f757b", "#3f4a5c", "#7b6a5c", "#a3a8a0", "#5b6b58")
TEXTURED = {"wood": WOODS, "mat": MATS, "cloth": CLOTHS}


@dataclass(frozen=True)
class PhotoScene:
    """What stays the same in all frames of a sequence. Angles in degrees, lengths in sheet sides."""

    front: str
    back: str
    front_pattern: str | None
    back_pattern: str | None
    table: str
    table_color: str
    tilt: float
    azimuth: float
    roll: float
    lens: float
    lamp_azimuth: float
    lamp_fall: float
    shadow: float
    warmth: tuple[float, float, float]
    vignette: float
    blur: float
    noise: float


@dataclass(frozen=True)
class Drift:
    """Where the sheet lies at one frame: turned by ``rotation`` degrees (counter-clockwise), then moved."""

    rotation: float
    shift: tuple[float, float]

    def folded_to_table(self, center: tuple[float, float]) -> Matrix:
        """Affine map (2, 3) from folded coordinates to the table, ``center`` going to the shift."""
        c, s = cos(radians(self.rotation)), sin(radians(self.rotation))
        turn = np.array([[c, -s], [s, c]])
        return np.column_stack([turn, np.asarray(self.shift) - turn @ np.asarray(center)])


def compose(seed: int, level: Level, front: str | None, back: str | None) -> PhotoScene:
    """Draw a scene: colours given are kept, the rest is chosen so that paper and table differ enough."""
    rng = stream(seed, "scene")
    stock = _stock(rng, front, back)
    table = str(rng.choice(list(level.tables)))
    patterned = level.patterns and rng.random() < 0.5
    return PhotoScene(
        front=near_color(rng, stock.front, 1.5),
        back=near_color(rng, stock.back, 2.0),
        front_pattern=str(rng.choice(PATTERNS)) if patterned and rng.random() < 0.35 else None,
        back_pattern=str(rng.choice(PATTERNS)) if patterned else None,
        table=table,
        table_color=_table_color(rng, level, table, stock),
        tilt=rng.uniform(*level.tilt),
        azimuth=rng.uniform(-180, 180),
        roll=rng.normal(0, 1.5),
        lens=rng.uniform(1.25, 1.7),
        lamp_azimuth=rng.uniform(-180, 180),
        lamp_fall=rng.uniform(*level.lamp),
        shadow=rng.uniform(0.5, 0.7),
        warmth=_warmth(rng, level.warmth),
        vignette=rng.uniform(*level.vignette),
        blur=rng.uniform(*level.blur),
        noise=rng.uniform(*level.noise),
    )


def _stock(rng: np.random.Generator, front: str | None, back: str | None) -> Stock:
    """A paper from the shelf, or the one that is asked for; a missing side is one that differs from the
    other.
    """
    shelf = [STOCKS[i] for i in rng.permutation(len(STOCKS))]
    if front is None and back is not None:
        front = next(s.front for s in shelf if color_difference(s.front, back) > 30)
    if front is None:
        return shelf[0]
    return Stock(front, back or next(s.back for s in shelf if color_difference(front, s.back) > 30))


def _table_color(rng: np.random.Generator, level: Level, table: str, stock: Stock) -> str:
    """A table colour that differs from both sides of the paper, or else the one that differs most."""
    shelf = TEXTURED.get(table, (*PLAIN_TABLES, *PALE_TABLES) if level.pale_tables else PLAIN_TABLES)
    shuffled = [shelf[i] for i in rng.permutation(len(shelf))]
    contrast = [min(color_difference(c, stock.front), color_difference(c, stock.back)) for c in shuffled]
    enough = next((c for c, d in zip(shuffled, contrast, strict=True) if d >= level.contrast), None)
    return near_color(rng, enough or shuffled[int(np.argmax(contrast))], 2.0)


def _warmth(rng: np.random.Generator, spread: float) -> tuple[float, float, float]:
    """Gains of red, green and blue for a lamp that the white balance did not quite meet."""
    warm, tint = rng.normal(0, spread), rng.normal(0, spread / 3)
    return 1 + warm, 1 + tint, 1 - warm


def sheet_drifts(seed: int, level: Level, frames: int) -> list[Drift]:
    """How the sheet lies in each frame: a walk that tends back to the middle."""
    rng = stream(seed, "drift")
    walk, place = [], np.zeros(3)
    for _ in range(frames):
        place = 0.5 * place + rng.normal(0, 1, 3) * [level.turn, level.shift, level.shift]
        walk.append(Drift(float(place[0]), (float(place[1]), float(place[2]))))
    return walk


def between_drifts(first: Drift, second: Drift, share: float) -> Drift:
    """A part of the way from one place of the sheet to another."""
    (x0, y0), (x1, y1) = first.shift, second.shift
    rotation = first.rotation + share * (second.rotation - first.rotation)
    return Drift(rotation, (x0 + share * (x1 - x0), y0 + share * (y1 - y0)))


def frame_camera(
    scene: PhotoScene, level: Level, size: tuple[int, int], seed: int, moment: Moment, sheet_fraction: float
) -> Camera:
    """The camera at a moment; ``sheet_fraction`` is the sheet's side as a part of the picture's shorter
    side.
    """
    focal = scene.lens * min(size)
    distance = focal / (sheet_fraction * min(size))
    shake = frame_jitter(seed, "camera", moment) * level.unsteady
    return looking_down(
        size, focal, distance, scene.tilt + shake[0], scene.azimuth + shake[1], scene.roll + shake[2]
    )
