"""What is printed and worn on the sheet: colour, pattern, grain and crease marks of both sides, in sheet
coordinates.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from folding_server.arrays import ByteMask, Float32s
from folding_server.geometry.line import Point
from folding_server.photographer.color_spaces import floats, linear_color
from folding_server.photographer.photo_scene import PhotoScene
from folding_server.photographer.pinhole_camera import Matrix
from folding_server.photographer.rng import stream
from folding_server.simulator import Paper

SHEET_TEXTURE_SIDE = 1024
"""Texture pixels along one sheet side."""
CREASE_WIDTH = 0.0022
"""Width of the worn line of a crease, in sheet sides."""
_SHIFT = 4


@dataclass(frozen=True)
class SheetTexture:
    """Linear colour of the two sides, float32 (rows, columns, 3), both as seen from the front; row 0 is the
    sheet's top.
    """

    front: Float32s
    back: Float32s
    height: float

    @property
    def sheet_to_texture(self) -> Matrix:
        """Affine map (3, 3) from the sheet to texture pixels whose centres are whole numbers."""
        return np.array(
            [
                [SHEET_TEXTURE_SIDE, 0, -0.5],
                [0, -SHEET_TEXTURE_SIDE, self.height * SHEET_TEXTURE_SIDE - 0.5],
                [0, 0, 1.0],
            ]
        )


def blank_sheet(scene: PhotoScene, seed: int, sheet: tuple[float, float]) -> SheetTexture:
    """The sheet before any fold: dyed, printed and grained."""
    shape = (round(sheet[1] * SHEET_TEXTURE_SIDE), round(sheet[0] * SHEET_TEXTURE_SIDE))
    rng = stream(seed, "paper")
    front = _side(rng, shape, scene.front, scene.front_pattern)
    back = _side(rng, shape, scene.back, scene.back_pattern)
    return SheetTexture(front, back, sheet[1])


def _side(rng: np.random.Generator, shape: tuple[int, int], color: str, pattern: str | None) -> Float32s:
    """One side: linear colour times grain, with a subtle print in another shade of the same dye."""
    albedo = np.empty((*shape, 3), np.float32)
    albedo[:] = linear_color(color)
    if pattern is not None:
        strength = rng.uniform(0.15, 0.3) * rng.choice([-1, 1])
        albedo *= 1 + np.float32(strength) * _print(pattern, shape, rng.uniform(0.03, 0.06))[..., None]
    return floats(np.clip(albedo * _grain(rng, shape)[..., None], 0, 1))


def _grain(rng: np.random.Generator, shape: tuple[int, int]) -> Float32s:
    """Brightness of the fibres about 1: fine grain and faint clouds."""
    fine = cv2.GaussianBlur(rng.standard_normal(shape, np.float32), (0, 0), 1.2)
    clouds = cv2.resize(rng.standard_normal((9, 9), np.float32), shape[::-1], interpolation=cv2.INTER_CUBIC)
    return floats(1 + 0.045 * fine + 0.008 * clouds)


def _print(pattern: str, shape: tuple[int, int], period: float) -> Float32s:
    """Ink 0 to 1 of a printed pattern with the given period in sheet sides."""
    y, x = np.mgrid[: shape[0], : shape[1]].astype(np.float32) / np.float32(period * SHEET_TEXTURE_SIDE)
    if pattern == "dots":
        row = np.floor(y)
        distance = np.hypot(np.mod(x + 0.5 * np.mod(row, 2), 1) - 0.5, np.mod(y, 1) - 0.5)
        return floats(np.clip((0.27 - distance) * 12 + 0.5, 0, 1))
    stripes = np.clip((0.25 - np.abs(np.mod(x, 1) - 0.5)) * 12 + 0.5, 0, 1)
    if pattern == "stripes":
        return floats(stripes)
    across = np.clip((0.25 - np.abs(np.mod(y, 1) - 0.5)) * 12 + 0.5, 0, 1)
    return floats((stripes + across) / 2)


def creased(sheet: SheetTexture, paper: Paper, strength: float = 1.0) -> SheetTexture:
    """The sheet with every crease that was ever folded worn into it: a dark and a light line side by side."""
    return worn(sheet, [line for line, letter in _creases(paper) if letter != "B"], strength)


def _creases(paper: Paper) -> list[tuple[tuple[Point, Point], str]]:
    """All edges of a paper by their ends on the sheet, with their letters."""
    places = paper.vertices_coords
    return [((places[u], places[v]), letter) for (u, v), letter in paper.edges()]


def worn(sheet: SheetTexture, lines: Sequence[tuple[Point, Point]], strength: float = 1.0) -> SheetTexture:
    """The sheet with lines, given by their ends on it, worn into it."""
    dark, light = _crease_masks(sheet, lines)
    if not dark.any():
        return sheet
    valley = (1 - 0.2 * strength * dark + 0.12 * strength * light)[..., None].astype(np.float32)
    ridge = (1 + 0.12 * strength * dark - 0.2 * strength * light)[..., None].astype(np.float32)
    return SheetTexture(np.clip(sheet.front * valley, 0, 1), np.clip(sheet.back * ridge, 0, 1), sheet.height)


def _crease_masks(sheet: SheetTexture, lines: Sequence[tuple[Point, Point]]) -> tuple[Float32s, Float32s]:
    """Coverage 0 to 1 of the two flanks of all creases."""
    flanks = []
    for side in (-1, 1):
        mask: ByteMask = np.zeros(sheet.front.shape[:2], np.uint8)
        for line in lines:
            ends = _texture_points(sheet, list(line))
            along = ends[1] - ends[0]
            normal = np.array([-along[1], along[0]]) / max(float(np.hypot(*along)), 1e-9)
            flank = ends + side * normal * CREASE_WIDTH * SHEET_TEXTURE_SIDE / 2
            p, q = np.rint(flank * 2**_SHIFT).astype(int).tolist()
            cv2.line(mask, p, q, 255, max(round(CREASE_WIDTH * SHEET_TEXTURE_SIDE), 1), cv2.LINE_AA, _SHIFT)
        flanks.append(mask.astype(np.float32) / np.float32(255))
    return flanks[0], flanks[1]


def _texture_points(sheet: SheetTexture, points: list[tuple[float, float]]) -> Matrix:
    """Texture pixels (n, 2) of points on the sheet."""
    m = sheet.sheet_to_texture
    return np.asarray(points, float) @ m[:2, :2].T + m[:2, 2]
