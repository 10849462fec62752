"""How the sheet drifted between two photos, judged by the outlines that both have in common.

Whatever was folded changes the picture; what was not keeps its edges. Matching edges with a cut-off lets the changed
ones simply not count, so that the drift is found before it is known what happened.
"""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.simulator.plane_geometry import Isometry
from folding_server.vision.labels import BACK, BACKGROUND, Labels
from folding_server.vision.solver.alignment import nudged
from folding_server.vision.solver.scene import Image, Scene, Stack

BINS = 8
"""Edge directions are told apart in steps of 180 degrees / BINS."""
CUT_OFF = 2.5
"""Edges further apart than this many pixels do not count as the same."""
_POINTS = 220


@dataclass(frozen=True)
class Edges:
    """Points (n, 2) in pixels (column, row) on the borders between classes, and the bin of each one's direction (n,)."""

    points: npt.NDArray[np.float64]
    bins: npt.NDArray[np.int64]


def edges_of(labels: Labels, known: npt.NDArray[np.bool_]) -> Edges:
    """The borders between background, front and back in a label image, away from what is unknown."""
    strength = np.zeros(labels.shape, np.float32)
    direction = np.zeros(labels.shape, np.float32)
    inside = cv2.erode(known.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    for mask in ((labels != BACKGROUND) & known, labels == BACK):
        smooth = cv2.GaussianBlur(mask.astype(np.float32), (5, 5), 1.0)
        gx, gy = cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1)
        size = np.hypot(gx, gy)
        direction = np.where(size > strength, np.arctan2(gy, gx), direction)
        strength = np.maximum(strength, size)
    thin = (strength > 0.9) & inside
    rows, cols = np.nonzero(thin)
    bins = np.round(direction[rows, cols] / (np.pi / BINS)).astype(np.int64) % BINS
    return Edges(np.stack([cols, rows], axis=1).astype(np.float64), bins)


def drifts(stack: Stack, scene: Scene, last: Isometry, keep: int = 2) -> list[Isometry]:
    """Motions near ``last`` under which a stack has the most edges in common with a photo, best first.

    Turns up to 10 degrees and shifts up to 0.1 of the sheet are tried.
    """
    drawn = edges_of(scene.draw(stack, last), scene.known)
    if not len(drawn.points):
        return []
    chosen = np.linspace(0, len(drawn.points) - 1, min(_POINTS, len(drawn.points))).astype(int)
    near = _nearness(edges_of(scene.labels, scene.known), scene)
    tried = _scores(drawn.points[chosen], drawn.bins[chosen], near, scene, stack, last)
    kept: list[tuple[float, ...]] = []
    for row in tried:
        if all(abs(row[3] - k[3]) > 2.5 or np.hypot(row[1] - k[1], row[2] - k[2]) > 0.04 for k in kept):
            kept.append(tuple(row))
        if len(kept) == keep:
            break
    return [nudged(last, stack.center, (k[1], k[2], k[3], 0.0)) for k in kept]


def _nearness(edges: Edges, scene: Scene) -> Image:
    """For each direction bin, 1 on an edge of that direction falling to 0 at the cut-off, (BINS, rows, cols)."""
    maps = []
    for b in range(BINS):
        empty = np.ones(scene.labels.shape, np.uint8)
        same = np.isin((edges.bins - b) % BINS, (0, 1, BINS - 1))
        cols, rows = edges.points[same].astype(int).T
        empty[rows, cols] = 0
        distance = cv2.distanceTransform(empty, cv2.DIST_L2, 3) if same.any() else np.full(empty.shape, 99, np.float32)
        maps.append(np.clip(1 - distance / CUT_OFF, 0, 1))
    return np.stack(maps)


def _scores(
    points: npt.NDArray[np.float64],
    bins: npt.NDArray[np.int64],
    near: Image,
    scene: Scene,
    stack: Stack,
    last: Isometry,
) -> npt.NDArray[np.float64]:
    """(score, dx, dy, degrees clockwise) of each drift tried, best first."""
    s = scene.grid.pixels_per_unit
    center = scene.grid.to_pixel(last(stack.center))
    reach = int(0.1 * s)
    steps = np.arange(-reach, reach + 1)
    dx, dy = (a.ravel() for a in np.meshgrid(steps, steps))
    rows = []
    for degrees in range(-10, 11):
        angle = np.radians(degrees)
        spin = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        turned = (points - center) @ spin + center
        turned_bins = np.round((bins * np.pi / BINS + angle) / (np.pi / BINS)).astype(np.int64) % BINS
        cols = np.rint(turned[:, 0]).astype(int)[None] + dx[:, None]
        lines = np.rint(turned[:, 1]).astype(int)[None] + dy[:, None]
        inside = (cols >= 0) & (lines >= 0) & (cols < near.shape[2]) & (lines < near.shape[1])
        got = near[turned_bins[None], np.where(inside, lines, 0), np.where(inside, cols, 0)] * inside
        gain = got.mean(axis=1) - 0.002 * abs(degrees) - 0.2 * np.hypot(dx, dy) / s
        best = np.argsort(-gain, kind="stable")[:3]
        rows += [(gain[i], dx[i] / s, -dy[i] / s, float(degrees)) for i in best]
    return np.array(sorted(rows, key=lambda r: -r[0]))


__all__ = ["Edges", "drifts", "edges_of"]
