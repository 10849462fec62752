"""Straight outlines at sub-pixel accuracy: where along a side the picture changes from inside to outside."""

import cv2
import numpy as np

from folding_server.arrays import Bools, Floats, Image, RgbImage
from folding_server.vision.colours import linear_from_table

_STEP = 0.25
"""Pixels between the depths at which a side is looked for."""
_POSITIONS = 160
"""Places along a side at which it is looked for, at most."""
LINE_FACTOR = 2.0
"""How many times more than the table a shadow line must differ from the paper to be what its side is told by."""
FAINTEST_STEP = 0.012
"""Difference in linear light below which a side shows no step."""


def refine_polygon(
    rgb: RgbImage, corners: Floats, reach: float, rounds: int = 3, fixed: Bools | None = None
) -> Floats:
    """Corners (N, 2) in (column, row), moved so that every side lies on an edge of the picture.

    ``reach`` is how far from a side, in pixels, its edge is looked for; it narrows in each round. Sides that are
    ``fixed`` (N,) stay on their lines.
    """
    still = np.zeros(len(corners), bool) if fixed is None else fixed
    refined = np.asarray(corners, np.float64)
    for round_ in range(rounds):
        width = max(3.0, reach / 2**round_)
        lines = [_side_line(rgb, refined, i, 0.0 if still[i] else width) for i in range(len(refined))]
        moved = np.array([_meet(lines[i - 1], lines[i], refined[i]) for i in range(len(refined))])
        refined = np.where(np.linalg.norm(moved - refined, axis=1, keepdims=True) < 3 * reach, moved, refined)
    return refined


def edge_support(rgb: RgbImage, corners: Floats) -> float:
    """Share of the positions along the weakest side at which the picture has a sharp step there, 0 to 1."""
    return min(_step_share(rgb, corners, i) for i in range(len(corners)))


def line_support(rgb: RgbImage, corners: Floats) -> float:
    """Share of the positions along the weakest side at which the picture changes there more than beside it, 0 to 1.

    A shadow line is enough, whatever lies inside and outside.
    """
    return min(_line_share(rgb, corners, i) for i in range(len(corners)))


def _line_share(rgb: RgbImage, corners: Floats, index: int) -> float:
    """The share of one side along which the light varies most across the side itself."""
    start, along, normal = _side(corners, index)
    near = max(3.0, 0.01 * float(np.hypot(*along)))
    ranges = []
    for centre in (-2.5 * near, 0.0, 2.5 * near):
        depths = centre + np.linspace(-near, near, 9)
        light = cv2.blur(_profiles(rgb, start, along, normal, depths).mean(axis=-1), (1, 7))
        ranges.append(light.max(axis=1) - light.min(axis=1))
    beside = np.maximum(ranges[0], ranges[2])
    return float(((ranges[1] > 1.3 * beside) & (ranges[1] > FAINTEST_STEP)).mean())


def _step_share(rgb: RgbImage, corners: Floats, index: int) -> float:
    """The share of one side where most of the change from inside to outside happens close to it."""
    start, along, normal = _side(corners, index)
    length = float(np.hypot(*along))
    near, far = max(2.5, 0.008 * length), max(8.0, 0.03 * length)
    colours = cv2.blur(_profiles(rgb, start, along, normal, np.array([-far, -near, near, far])), (1, 7))
    whole = np.linalg.norm(colours[:, 0] - colours[:, 3], axis=-1)
    close = np.linalg.norm(colours[:, 1] - colours[:, 2], axis=-1)
    return float(((close > 0.5 * whole) & (close > FAINTEST_STEP)).mean())


def _side(corners: Floats, index: int) -> tuple[Floats, Floats, Floats]:
    """Start, vector and outward unit normal of a side."""
    start, end = corners[index], corners[(index + 1) % len(corners)]
    along = end - start
    normal = np.array([along[1], -along[0]]) / (float(np.hypot(*along)) + 1e-9)
    x, y = corners[:, 0], corners[:, 1]
    clockwise = float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) > 0
    return start, along, normal if clockwise else -normal


def _profiles(rgb: RgbImage, start: Floats, along: Floats, normal: Floats, depths: Floats) -> Image:
    """Linear light (positions, depths, 3) at depths, positive outside, for positions along a side."""
    count = int(np.clip(np.hypot(*along) / 1.5, 12, _POSITIONS))
    places = start + np.linspace(0.05, 0.95, count)[:, None] * along
    maps = (places[:, None, :] + depths[None, :, None] * normal).astype(np.float32)
    return linear_from_table(
        cv2.remap(rgb, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    )


def _side_line(rgb: RgbImage, corners: Floats, index: int, width: float) -> Floats:
    """The line (nx, ny, offset) of one side; the side itself where the picture shows no edge."""
    start, along, normal = _side(corners, index)
    tilt, shift = (0.0, 0.0) if width == 0 else _fitted_offset(rgb, start, along, normal, width)
    a, b = start + normal * shift, start + along + normal * (tilt + shift)
    direction = (b - a) / (np.hypot(*(b - a)) + 1e-9)
    n = np.array([direction[1], -direction[0]])
    return np.array([n[0], n[1], n @ a])


def _fitted_offset(
    rgb: RgbImage, start: Floats, along: Floats, normal: Floats, width: float
) -> tuple[float, float]:
    """How far out the edge lies at the end of a side, less than at its start, and at its start."""
    offsets, weights = _crossings(rgb, start, along, normal, width)
    return _fit_line(np.linspace(0.05, 0.95, len(offsets)), offsets, weights)


def _crossings(
    rgb: RgbImage, start: Floats, along: Floats, normal: Floats, width: float
) -> tuple[Floats, Floats]:
    """For positions along a side, how far out the change lies, and how much it can be trusted."""
    depths = np.arange(-width, width + _STEP / 2, _STEP)
    colours = _profiles(rgb, start, along, normal, depths)
    count = len(colours)
    third = len(depths) // 3
    inner = cv2.blur(colours[:, :third].mean(axis=1), (1, 9))
    outer = cv2.blur(colours[:, -third:].mean(axis=1), (1, 9))
    outer = _darkest_between(colours, inner.reshape(count, 3), outer.reshape(count, 3))
    contrast = inner.reshape(count, 3) - outer.reshape(count, 3)
    power = np.einsum("ij,ij->i", contrast, contrast)
    share = np.einsum("ijk,ik->ij", colours - outer.reshape(count, 1, 3), contrast) / (power[:, None] + 1e-9)
    return _half_way(np.asarray(share, np.float64), depths, width), np.asarray(np.sqrt(power), np.float64)


def _darkest_between(colours: Image, inner: Image, outer: Image) -> Image:
    """The outer light (positions, 3), or that of a shadow line before it where this differs far more from the inner."""
    away = np.linalg.norm(cv2.blur(colours, (3, 1)) - inner[:, None, :], axis=-1)
    at = away.argmax(axis=1)
    rows = np.arange(len(colours))
    hidden = away[rows, at] > LINE_FACTOR * np.linalg.norm(outer - inner, axis=-1)
    return np.where(hidden[:, None], colours[rows, at], outer).astype(np.float32)


def _half_way(share: Floats, depths: Floats, width: float) -> Floats:
    """Where each profile (positions, depths), 1 inside and 0 outside, passes one half most steeply."""
    smooth = cv2.blur(share, (5, 1))
    falls = (smooth[:, :-1] >= 0.5) & (smooth[:, 1:] < 0.5)
    steep = np.zeros_like(smooth)
    steep[:, 4:-4] = smooth[:, :-8] - smooth[:, 8:]
    score = np.where(falls, steep[:, :-1] + 1e-3, 0.0)
    at = score.argmax(axis=1)
    rows = np.arange(len(share))
    high, low = smooth[rows, at], smooth[rows, at + 1]
    offset = depths[at] + _STEP * (high - 0.5) / np.maximum(high - low, 1e-6)
    return np.where(score.max(axis=1) > 0, offset, 2 * width)


def _fit_line(t: Floats, offsets: Floats, weights: Floats) -> tuple[float, float]:
    """Robust offset = tilt * t + shift; positions without an edge lie far off and drop out."""
    tilt, shift = 0.0, float(np.median(offsets))
    for _ in range(8):
        residual = np.abs(offsets - tilt * t - shift)
        scale = max(1.4826 * float(np.median(residual)), 0.08)
        w = weights * np.clip(1 - (residual / (3 * scale)) ** 2, 0, None) ** 2
        if w.sum() <= 1e-9:
            return 0.0, 0.0
        design = np.column_stack([t, np.ones_like(t)])
        normal = design.T @ (design * w[:, None]) + 1e-9 * w.sum() * np.eye(2)
        tilt, shift = np.linalg.solve(normal, design.T @ (w * offsets)).tolist()
    return tilt, shift


def _meet(first: Floats, second: Floats, fallback: Floats) -> Floats:
    """Where two lines meet; ``fallback`` if they are nearly parallel."""
    matrix = np.array([first[:2], second[:2]])
    if abs(np.linalg.det(matrix)) < 0.05:
        return fallback
    return np.asarray(np.linalg.solve(matrix, [first[2], second[2]]), np.float64)
