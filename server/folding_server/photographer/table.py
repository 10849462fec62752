"""The bare table as the camera sees it: linear colour of a plain board, wood, a cutting mat or cloth."""

from typing import cast

import cv2
import numpy as np

from folding_server.arrays import Float32s
from folding_server.photographer.color_spaces import floats, linear_color
from folding_server.photographer.photo_scene import PhotoScene
from folding_server.photographer.pinhole_camera import Camera, Matrix
from folding_server.photographer.rng import stream

TABLE_TEXTURE_SIDE = 1200
TABLE_TEXTURE_REACH = 2.4
"""The texture covers this many sheet sides either way from the centre; beyond it repeats mirrored."""


def table_texture(scene: PhotoScene, seed: int) -> Float32s:
    """Linear colour (TABLE_TEXTURE_SIDE, TABLE_TEXTURE_SIDE, 3) of the table in table coordinates, row 0 at the far side."""
    rng = stream(seed, "table")
    tone = {"plain": _plain, "wood": _wood, "mat": _mat, "cloth": _cloth}[scene.table](rng)
    return np.clip(linear_color(scene.table_color) * tone, 0, 1).astype(np.float32)


def table_to_texture() -> Matrix:
    """Affine map (3, 3) from the table to texture pixels whose centres are whole numbers."""
    scale = TABLE_TEXTURE_SIDE / (2 * TABLE_TEXTURE_REACH)
    middle = TABLE_TEXTURE_SIDE / 2 - 0.5
    return np.array([[scale, 0, middle], [0, -scale, middle], [0, 0, 1.0]])


def seen_table(texture: Float32s, camera: Camera, size: tuple[int, int]) -> Float32s:
    """The table's linear colour in the picture (height, width, 3); ``size`` is (width, height)."""
    to_texture = table_to_texture()
    centers = np.array([[1, 0, -0.5], [0, 1, -0.5], [0, 0, 1.0]])
    motion: Matrix = centers @ camera.table_to_pixel @ np.linalg.inv(to_texture)
    seen = cv2.warpPerspective(
        texture, motion, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101
    )
    return cast("Float32s", seen)


def _noise(rng: np.random.Generator, cells: tuple[int, int]) -> Float32s:
    """Smooth noise of about unit deviation over the table, from a coarse grid of (rows, columns)."""
    coarse = rng.standard_normal(cells, np.float32)
    return cast(
        "Float32s",
        cv2.resize(coarse, (TABLE_TEXTURE_SIDE, TABLE_TEXTURE_SIDE), interpolation=cv2.INTER_CUBIC),
    )


def _plain(rng: np.random.Generator) -> Float32s:
    """A matt board: faint clouds and fine speckle."""
    return floats(1 + 0.015 * _noise(rng, (6, 6)) + 0.02 * _noise(rng, (400, 400)))[..., None]


def _wood(rng: np.random.Generator) -> Float32s:
    """Planks with grain along them, wavy rings and dark seams."""
    x = np.arange(TABLE_TEXTURE_SIDE, dtype=np.float32)[None, :] / np.float32(TABLE_TEXTURE_SIDE)
    warp = 0.02 * _noise(rng, (3, 8)) + 0.006 * _noise(rng, (10, 30))
    planks = rng.integers(4, 7)
    plank = np.clip((x * planks).astype(int), 0, planks - 1)
    tones = rng.normal(1, 0.08, planks)[plank]
    rings = np.sin((x + warp) * rng.uniform(120, 200) + plank * 7.0 + 5 * _noise(rng, (2, 12)))
    fibre = cv2.GaussianBlur(
        rng.standard_normal((TABLE_TEXTURE_SIDE, TABLE_TEXTURE_SIDE), np.float32),
        (0, 0),
        sigmaX=0.8,
        sigmaY=14,
    )
    seam = np.exp(-(((np.mod(x * planks + 0.5, 1) - 0.5) / 0.012) ** 2)) * (x > 0.5 / planks)
    tone = tones * (1 + 0.09 * rings + 0.5 * fibre + 0.05 * _noise(rng, (5, 9))) * (1 - 0.55 * seam)
    return floats(np.clip(tone, 0.15, 2))[..., None] ** np.array([0.92, 1.0, 1.1], np.float32)


def _mat(rng: np.random.Generator) -> Float32s:
    """A cutting mat: pale grid lines, each fifth one stronger, and scratches."""
    tone = (1 + 0.02 * _noise(rng, (5, 5)) + 0.03 * _noise(rng, (500, 500)))[..., None]
    ink = np.zeros((TABLE_TEXTURE_SIDE, TABLE_TEXTURE_SIDE), np.uint8)
    step = rng.uniform(0.065, 0.11) * TABLE_TEXTURE_SIDE / (2 * TABLE_TEXTURE_REACH) * 1.6
    for i in range(int(TABLE_TEXTURE_SIDE / step) + 1):
        at, strength = round(i * step * 16), 190 if i % 5 == 0 else 90
        cv2.line(ink, (at, 0), (at, TABLE_TEXTURE_SIDE * 16), strength, 1 + (i % 5 == 0), cv2.LINE_AA, 4)
        cv2.line(ink, (0, at), (TABLE_TEXTURE_SIDE * 16, at), strength, 1 + (i % 5 == 0), cv2.LINE_AA, 4)
    for _ in range(25):
        p, q = (rng.uniform(0, TABLE_TEXTURE_SIDE, 2).astype(int).tolist() for _ in range(2))
        cv2.line(ink, p, q, 25, 1, cv2.LINE_AA)
    lines = (ink.astype(np.float32) / 255)[..., None]
    return floats(tone * (1 - lines) + np.float32(4.5) * lines * np.array([1, 1, 0.8], np.float32))


def _cloth(rng: np.random.Generator) -> Float32s:
    """A woven cloth: two crossing sets of threads and soft folds."""
    y, x = np.mgrid[:TABLE_TEXTURE_SIDE, :TABLE_TEXTURE_SIDE].astype(np.float32)
    period = rng.uniform(3.2, 5.0)
    warp, weft = np.sin(2 * np.pi * (x + y * 0.02) / period), np.sin(2 * np.pi * (y - x * 0.02) / period)
    weave = warp * weft + 0.6 * rng.standard_normal((TABLE_TEXTURE_SIDE, TABLE_TEXTURE_SIDE), np.float32)
    soft = 0.05 * _noise(rng, (4, 3)) + 0.03 * _noise(rng, (9, 7))
    return floats(1 + 0.16 * cv2.GaussianBlur(weave, (0, 0), 0.8) + soft)[..., None]
