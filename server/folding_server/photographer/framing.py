"""Where to point the camera and how near, so that every keyframe fits the picture."""

from collections.abc import Callable, Sequence

import numpy as np

from folding_server.photographer.camera import Camera
from folding_server.photographer.scene import Drift
from folding_server.simulator import Paper

BORDER = 0.05
"""Part of the picture's shorter side that stays free all round."""


def middle(papers: Sequence[Paper]) -> tuple[float, float]:
    """Centre of the box around the paper in all keyframes, in folded coordinates."""
    points = np.array([p for paper in papers for p in paper.positions.values()])
    x, y = (points.min(0) + points.max(0)) / 2
    return float(x), float(y)


def fitting_fraction(
    camera_at: Callable[[float], Camera], papers: Sequence[Paper], drifts: Sequence[Drift],
    center: tuple[float, float], size: tuple[int, int], wanted: float,
) -> float:
    """The sheet's side as a part of the picture's shorter side: as wanted, or smaller until every keyframe fits."""
    fraction = wanted
    while not _fits(camera_at(fraction), papers, drifts, center, size):
        fraction *= 0.97
    return fraction


def _fits(
    camera: Camera, papers: Sequence[Paper], drifts: Sequence[Drift], center: tuple[float, float], size: tuple[int, int]
) -> bool:
    free = BORDER * min(size)
    for paper, drift in zip(papers, drifts, strict=True):
        motion = drift.folded_to_table(center)
        flat = np.array(list(paper.positions.values())) @ motion[:, :2].T + motion[:, 2]
        pixels = camera.project(np.column_stack([flat, np.zeros(len(flat))]))
        if (pixels < free).any() or (pixels > np.array(size) - free).any():
            return False
    return True
