"""How the sheet drifted between two photos, judged by the outlines that both have in common.

Whatever was folded changes the picture; what was not keeps its edges. Matching edges with a cut-off lets the changed
ones simply not count, so that the drift is found before it is known what happened.
"""

from dataclasses import dataclass
from math import log

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Floats, Image, Mask
from folding_server.geometry.line import Point
from folding_server.geometry.similarity import Similarity
from folding_server.vision.labels import BACK, BACKGROUND, LabelImage
from folding_server.vision.registration.alignment import nudged
from folding_server.vision.registration.scene import FaceStack, Scene

BINS = 8
"""Edge directions are told apart in steps of 180 degrees / BINS."""
CUT_OFF = 2.5
"""Edges further apart than this many pixels do not count as the same."""
_POINTS = 220
"""Points of drawn edges that are matched."""


@dataclass(frozen=True)
class Edges:
    """Points (n, 2) in pixels (column, row) on the borders between classes, and the bin of each one's direction (n,)."""

    points: Floats
    bins: npt.NDArray[np.int64]


def edges_of(labels: LabelImage, known: Mask) -> Edges:
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


@dataclass(frozen=True)
class DriftRange:
    """Which drifts to try: turns and shifts up to a limit, in steps (degrees; pixels of the scene), and scales."""

    turn: int = 10
    turn_step: int = 1
    shift: float = 0.1
    stride: int = 1
    scales: tuple[float, ...] = (1.0,)


SLIGHT_DRIFT = DriftRange(shift=0.04)
"""What happens to paper that is folded from two sides at once: it stays where it is, though no side of it does."""
HANDHELD_DRIFT = DriftRange(turn=16, turn_step=2, shift=0.25, stride=2, scales=(0.88, 0.94, 1.0, 1.06, 1.12))
"""What a camera held in the hand may do between two photos."""


def drifts(
    stack: FaceStack, scene: Scene, last: Similarity, reach: DriftRange = DriftRange(), keep: int = 2
) -> list[Similarity]:
    """Motions near ``last`` under which a stack has the most edges in common with a photo, best first.

    Several that differ for each scale: edges that meet in one corner fit at any scale, and what was folded decides.
    """
    near = _nearness(edges_of(scene.labels, scene.known), scene, CUT_OFF * reach.stride)
    tried: list[tuple[float, ...]] = []
    for scale in reach.scales:
        start = nudged(last, stack.center, (0.0, 0.0, 0.0, log(scale)))
        drawn = edges_of(scene.draw(stack, start), scene.known)
        if len(drawn.points):
            tried += [(*row, scale) for row in _scores(drawn, near, scene, last(stack.center), reach)]
    tried.sort(key=lambda row: -row[0])
    kept: list[tuple[float, ...]] = []
    for row in tried:
        rivals = [k for k in kept if k[4] == row[4]]
        differs = all(
            abs(row[3] - k[3]) > 2.5 or np.hypot(row[1] - k[1], row[2] - k[2]) > 0.04 for k in rivals
        )
        if len(rivals) < keep and differs:
            kept.append(row)
    return [nudged(last, stack.center, (k[1], k[2], k[3], log(k[4]))) for k in kept]


def _nearness(edges: Edges, scene: Scene, cut_off: float) -> Image:
    """For each direction bin, 1 on an edge of that direction falling to 0 at the cut-off, (BINS, rows, cols)."""
    maps = []
    for b in range(BINS):
        empty = np.ones(scene.labels.shape, np.uint8)
        same = np.isin((edges.bins - b) % BINS, (0, 1, BINS - 1))
        cols, rows = edges.points[same].astype(int).T
        empty[rows, cols] = 0
        distance = (
            cv2.distanceTransform(empty, cv2.DIST_L2, 3)
            if same.any()
            else np.full(empty.shape, 99, np.float32)
        )
        maps.append(np.clip(1 - distance / cut_off, 0, 1))
    return np.stack(maps)


def _scores(
    drawn: Edges, near: Image, scene: Scene, center: Point, reach: DriftRange
) -> list[tuple[float, float, float, float]]:
    """(score, dx, dy, degrees clockwise) of the best shifts for each turn."""
    s = scene.grid.pixels_per_unit
    chosen = np.linspace(0, len(drawn.points) - 1, min(_POINTS, len(drawn.points))).astype(int)
    points, bins = drawn.points[chosen], drawn.bins[chosen]
    middle = scene.grid.to_pixel(center)
    steps = np.arange(-int(reach.shift * s), int(reach.shift * s) + 1, reach.stride)
    dx, dy = (a.ravel() for a in np.meshgrid(steps, steps))
    rows = []
    for degrees in range(-reach.turn, reach.turn + 1, reach.turn_step):
        angle = np.radians(degrees)
        spin = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        turned = (points - middle) @ spin + middle
        turned_bins = np.round(bins + angle / (np.pi / BINS)).astype(np.int64) % BINS
        cols = np.rint(turned[:, 0]).astype(int)[None] + dx[:, None]
        lines = np.rint(turned[:, 1]).astype(int)[None] + dy[:, None]
        inside = (cols >= 0) & (lines >= 0) & (cols < near.shape[2]) & (lines < near.shape[1])
        got = near[turned_bins[None], np.where(inside, lines, 0), np.where(inside, cols, 0)] * inside
        gain = got.mean(axis=1) - 0.002 * abs(degrees) - 0.2 * np.hypot(dx, dy) / s
        best = np.argsort(-gain, kind="stable")[:3]
        rows += [(float(gain[i]), float(dx[i] / s), float(-dy[i] / s), float(degrees)) for i in best]
    return rows
