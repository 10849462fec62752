"""Where to point the camera and how near, so that every keyframe fits the picture."""

from collections.abc import Callable, Sequence
from functools import reduce

import numpy as np
from folding_schemas.actions import Action, Program

from folding_server.geometry.line import Point
from folding_server.photographer.photo_scene import Drift
from folding_server.photographer.pinhole_camera import Camera, Matrix
from folding_server.simulator import Paper

BORDER = 0.05
"""Part of the picture's shorter side that stays free all round."""


def pivots(program: Program) -> list[Point]:
    """The folded place of the sheet's middle spot on the table at each keyframe.

    People turn a model over where it lies, so the spot follows the flips; only "y=-x" moves it, by a sheet's
    side.
    """
    spots = [(0.5, 0.5)]
    for step in program.steps:
        spots.append(reduce(pivot_after, step, spots[-1]))
    return spots


def pivot_after(spot: Point, action: Action) -> Point:
    """Where an action takes the folded place of the sheet's middle spot."""
    if action.action == "flip" and action.axis == "y=-x":
        return -spot[1], -spot[0]
    return spot


def bounding_centre(papers: Sequence[Paper], spots: Sequence[Point]) -> Point:
    """Centre of the box around the paper in all keyframes, relative to their pivots."""
    points = np.vstack(
        [
            np.array(list(paper.folded_vertices_coords.values())) - spot
            for paper, spot in zip(papers, spots, strict=True)
        ]
    )
    x, y = (points.min(0) + points.max(0)) / 2
    return float(x), float(y)


def fitting_fraction(
    camera_at: Callable[[float], Camera],
    papers: Sequence[Paper],
    drifts: Sequence[Drift],
    centers: Sequence[Point],
    size: tuple[int, int],
    wanted: float,
) -> float:
    """The sheet's side as a part of the picture's shorter side: as wanted, or smaller until every keyframe
    fits.
    """
    fraction = wanted
    while not _fits(camera_at(fraction), papers, drifts, centers, size):
        fraction *= 0.97
    return fraction


def _fits(
    camera: Camera,
    papers: Sequence[Paper],
    drifts: Sequence[Drift],
    centers: Sequence[Point],
    size: tuple[int, int],
) -> bool:
    return all(
        fits(camera, paper, drift, center, size)
        for paper, drift, center in zip(papers, drifts, centers, strict=True)
    )


def fits(camera: Camera, paper: Paper, drift: Drift, center: Point, size: tuple[int, int]) -> bool:
    """Whether a camera whose pictures have a ``size`` (width, height) sees all of a paper, with room around."""
    free = BORDER * min(size)
    flat = on_table(paper, drift, center)
    pixels = camera.project(np.column_stack([flat, np.zeros(len(flat))]))
    return bool((pixels >= free).all() and (pixels <= np.array(size) - free).all())


def on_table(paper: Paper, drift: Drift, center: Point) -> Matrix:
    """Where the vertices (n, 2) of a paper lie on the table."""
    motion = drift.folded_to_table(center)
    return np.asarray(np.array(list(paper.folded_vertices_coords.values())) @ motion[:, :2].T + motion[:, 2])
