"""Straight outlines at sub-pixel accuracy: where along a side the picture changes from inside to outside."""

import cv2
import numpy as np

from folding_server.vision.colours import to_linear
from folding_server.vision.grid import Floats
from folding_server.vision.photos import Picture

_STEP = 0.25
_POSITIONS = 160


def refine_polygon(rgb: Picture, corners: Floats, reach: float, rounds: int = 3) -> Floats:
    """Corners (N, 2) in (column, row), moved so that every side lies on the edge that the picture shows near it.

    ``reach`` is how far from a side, in pixels, its edge is looked for; it narrows in each round.
    """
    refined = np.asarray(corners, np.float64)
    for round_ in range(rounds):
        width = max(3.0, reach / 2**round_)
        lines = [_side_line(rgb, refined, i, width) for i in range(len(refined))]
        moved = np.array([_meet(lines[i - 1], lines[i], refined[i]) for i in range(len(refined))])
        refined = np.where(np.linalg.norm(moved - refined, axis=1, keepdims=True) < 3 * reach, moved, refined)
    return refined


def _side_line(rgb: Picture, corners: Floats, index: int, width: float) -> Floats:
    """The line (nx, ny, offset) of one side; the side itself where the picture shows no edge."""
    start, end = corners[index], corners[(index + 1) % len(corners)]
    along = end - start
    length = float(np.hypot(*along)) + 1e-9
    normal = np.array([along[1], -along[0]]) / length
    if normal @ (corners.mean(axis=0) - start) > 0:
        normal = -normal
    offsets, weights = _crossings(rgb, start, along, normal, width)
    fractions = np.linspace(0.05, 0.95, len(offsets))
    tilt, shift = _fit_line(fractions, offsets, weights)
    a, b = start + normal * shift, end + normal * (tilt + shift)
    direction = (b - a) / (np.hypot(*(b - a)) + 1e-9)
    n = np.array([direction[1], -direction[0]])
    return np.array([n[0], n[1], n @ a])


def _crossings(
    rgb: Picture, start: Floats, along: Floats, normal: Floats, width: float
) -> tuple[Floats, Floats]:
    """For positions along a side, how far out the change lies, and how much it can be trusted."""
    depths = np.arange(-width, width + _STEP / 2, _STEP)
    count = int(np.clip(np.hypot(*along) / 1.5, 12, _POSITIONS))
    places = start + np.linspace(0.05, 0.95, count)[:, None] * along
    samples = places[:, None, :] + depths[None, :, None] * normal
    maps = samples.astype(np.float32)
    colours = to_linear(cv2.remap(rgb, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))
    third = len(depths) // 3
    inner = cv2.blur(colours[:, :third].mean(axis=1), (1, 9))
    outer = cv2.blur(colours[:, -third:].mean(axis=1), (1, 9))
    contrast = inner.reshape(count, 3) - outer.reshape(count, 3)
    power = np.einsum("ij,ij->i", contrast, contrast)
    share = np.einsum("ijk,ik->ij", colours - outer.reshape(count, 1, 3), contrast) / (power[:, None] + 1e-9)
    return _half_way(np.asarray(share, np.float64), depths, width), np.asarray(np.sqrt(power), np.float64)


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
