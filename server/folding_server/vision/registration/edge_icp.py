"""The sheet's drift to a fraction of a pixel when much of its outline was folded: edges that stayed pull it into place.

Each point of a drawn border looks along its normal for the same border in the photo. Those that find it nearby say how
far off they are; the rest, whose paper was folded away, say nothing. What no border holds stays as it was.
"""

from collections.abc import Iterator
from math import degrees

import numpy as np

from folding_server.arrays import Floats, Image
from folding_server.geometry.line import Point
from folding_server.geometry.similarity import Similarity
from folding_server.vision.registration.alignment import nudged
from folding_server.vision.registration.edge_matching import border_of, class_maps, crossings
from folding_server.vision.registration.scene import FaceStack, Scene

SEARCH_LENGTHS = (0.05, 0.05, 0.035, 0.025, 0.015, 0.015)
"""How far (sheet units) points look along their normals in each round."""
FEWEST_BORDER_POINTS = 12
"""With fewer points that find their border nothing is moved."""
_REST = 1e-3
"""Weight of staying put, against the share of points that ask for a motion."""


def snapped_to_edges(stack: FaceStack, scene: Scene, motion: Similarity) -> Similarity:
    """``motion`` moved so that the borders of a stack which the photo still shows lie on it; scale unchanged."""
    seen = list(class_maps(scene.labels, scene.known))
    for reach in SEARCH_LENGTHS:
        rows = [
            row
            for drawn, photo in zip(class_maps(scene.draw(stack, motion), scene.known), seen, strict=True)
            for row in _pulls(drawn, photo, scene, reach, motion(stack.center))
        ]
        if len(rows) < FEWEST_BORDER_POINTS:
            break
        motion = nudged(motion, stack.center, _solved(np.array(rows), reach))
    return motion


def _pulls(
    drawn: Image, photo: Image, scene: Scene, reach: float, pivot: Point
) -> Iterator[tuple[float, ...]]:
    """For each point that finds its border: how a shift (dx, dy) and a clockwise turn move it along its normal, and
    how far it has to go, in sheet units.
    """
    border, size = border_of(drawn, scene.known), scene.grid.pixels_per_unit
    span = np.arange(-round(reach * size), round(reach * size) + 1, dtype=np.float64)
    ways = crossings(photo, border, span) - crossings(drawn, border, span)
    plane = scene.grid.to_plane(border.points)
    for (x, y), (nx, ny), way in zip(plane.tolist(), border.normals.tolist(), ways.tolist(), strict=True):
        if np.isfinite(way):
            yield nx, -ny, nx * (y - pivot[1]) + ny * (x - pivot[0]), way / size


def _solved(rows: Floats, reach: float) -> tuple[float, float, float, float]:
    """The nudge that suits most pulls: damped least squares, far ones counting less."""
    slopes, ways = rows[:, :3], rows[:, 3]
    weights = 1 / (1 + (3 * ways / reach) ** 2) / len(rows)
    normal = slopes.T @ (weights[:, None] * slopes) + _REST * np.eye(3)
    dx, dy, turn = np.linalg.solve(normal, slopes.T @ (weights * ways)).tolist()
    return dx, dy, degrees(turn), 0.0
