"""The sheet's drift to a fraction of a pixel when much of its outline was folded: edges that stayed pull it into place.

Each point of a drawn border looks along its normal for the same border in the photo. Those that find it nearby say how
far off they are; the rest, whose paper was folded away, say nothing. What no border holds stays as it was.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees

import cv2
import numpy as np

from folding_server.arrays import Floats, Image, Mask
from folding_server.geometry.line import Point
from folding_server.geometry.similarity import Similarity
from folding_server.vision.fitting.alignment import nudged
from folding_server.vision.fitting.scene import FaceStack, Scene, spread_over
from folding_server.vision.labels import BACK, BACKGROUND, LabelImage

SEARCH_LENGTHS = (0.05, 0.05, 0.035, 0.025, 0.015, 0.015)
"""How far (sheet units) points look along their normals in each round."""
FEWEST_BORDER_POINTS = 12
"""With fewer points that find their border nothing is moved."""
_POINTS = 200
_BLUR = 1.2
_REST = 1e-3
"""Weight of staying put, against the share of points that ask for a motion."""


@dataclass(frozen=True)
class Border:
    """Points (n, 2) on a border in pixels (column, row), and the unit normals (n, 2) into what it bounds."""

    points: Floats
    normals: Floats


def held(stack: FaceStack, scene: Scene, motion: Similarity) -> Similarity:
    """``motion`` moved so that the borders of a stack which the photo still shows lie on it; scale unchanged."""
    seen = list(_maps(scene.labels, scene.known))
    for reach in SEARCH_LENGTHS:
        rows = [
            row
            for drawn, photo in zip(_maps(scene.draw(stack, motion), scene.known), seen, strict=True)
            for row in _pulls(drawn, photo, scene, reach, motion(stack.center))
        ]
        if len(rows) < FEWEST_BORDER_POINTS:
            break
        motion = nudged(motion, stack.center, _solved(np.array(rows), reach))
    return motion


def _maps(labels: LabelImage, known: Mask) -> Iterator[Image]:
    """Blurred maps of the paper and of its back; 0.5 is the border."""
    for mask in (labels != BACKGROUND, labels == BACK):
        yield cv2.GaussianBlur((mask & known).astype(np.float32), (0, 0), _BLUR)


def _pulls(
    drawn: Image, photo: Image, scene: Scene, reach: float, pivot: Point
) -> Iterator[tuple[float, ...]]:
    """For each point that finds its border: how a shift (dx, dy) and a clockwise turn move it along its normal, and
    how far it has to go, in sheet units.
    """
    border, size = _border(drawn, scene.known), scene.grid.pixels_per_unit
    span = np.arange(-round(reach * size), round(reach * size) + 1, dtype=np.float64)
    ways = _crossings(photo, border, span) - _crossings(drawn, border, span)
    plane = scene.grid.to_plane(border.points)
    for (x, y), (nx, ny), way in zip(plane.tolist(), border.normals.tolist(), ways.tolist(), strict=True):
        if np.isfinite(way):
            yield nx, -ny, nx * (y - pivot[1]) + ny * (x - pivot[0]), way / size


def _border(image: Image, known: Mask) -> Border:
    """Points spread over the border in a map, away from what is unknown."""
    inside = image >= 0.5
    rim = inside & (cv2.erode(inside.astype(np.uint8), np.ones((3, 3), np.uint8)) == 0)
    rows, cols = spread_over(
        rim & (cv2.erode(known.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0), _POINTS
    )
    gx, gy = cv2.Sobel(image, cv2.CV_32F, 1, 0), cv2.Sobel(image, cv2.CV_32F, 0, 1)
    normals = np.stack([gx, gy], axis=-1)[rows, cols].astype(np.float64)
    lengths = np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-6)
    return Border(np.stack([cols, rows], axis=1).astype(np.float64), normals / lengths)


def _crossings(image: Image, border: Border, span: Floats) -> Floats:
    """Where along each normal a map rises through 0.5 nearest to the point, (n,) in pixels; nan if nowhere."""
    places = (border.points[:, None] + span[None, :, None] * border.normals[:, None]).astype(np.float32)
    if not len(places):
        return np.empty(0)
    values = cv2.remap(image, places[..., 0], places[..., 1], cv2.INTER_LINEAR).astype(np.float64)
    low, high = values[:, :-1], values[:, 1:]
    rises = (low < 0.5) & (high >= 0.5)
    exact = span[:-1] + (0.5 - low) / np.where(rises, high - low, 1.0)
    nearest = np.argmin(np.where(rises, np.abs(exact), np.inf), axis=1)
    found = np.take_along_axis(exact, nearest[:, None], axis=1)[:, 0]
    return np.where(rises.any(axis=1), found, np.nan)


def _solved(rows: Floats, reach: float) -> tuple[float, float, float, float]:
    """The nudge that suits most pulls: damped least squares, far ones counting less."""
    slopes, ways = rows[:, :3], rows[:, 3]
    weights = 1 / (1 + (3 * ways / reach) ** 2) / len(rows)
    normal = slopes.T @ (weights[:, None] * slopes) + _REST * np.eye(3)
    dx, dy, turn = np.linalg.solve(normal, slopes.T @ (weights * ways)).tolist()
    return dx, dy, degrees(turn), 0.0
