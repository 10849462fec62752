"""Folded paper to label images, by painting the faces bottom to top; fast enough for every search."""

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.simulator.paper import Paper
from folding_server.simulator.plane_geometry import IDENTITY, Isometry, Polygon
from folding_server.vision.grid import Floats, Grid
from folding_server.vision.labels import BACK, BACKGROUND, FRONT, Labels

_SHIFT = 6
_FINE = 4
"""Fine pixels a side of each pixel kept: OpenCV fills every pixel that an outline passes through."""
_INSET = 0.2
"""Fine pixels that every side moves inwards to make up for that; half a pixel would open cracks."""
_SLIVER = 0.6
"""Fine pixels of mean width below which a face is not drawn."""


def draw_labels(
    polygons: Sequence[Polygon], backs: Sequence[bool], grid: Grid, motion: Isometry = IDENTITY
) -> Labels:
    """The label image of convex folded faces.

    ``polygons`` run bottom to top in sheet units, ``backs`` says which lie back up, ``motion`` (an isometry
    or a similarity, as the same six numbers) is applied first. A pixel belongs to a face if its centre does.
    """
    return draw_values(polygons, [BACK if back else FRONT for back in backs], grid, motion)


def draw_paper(paper: Paper, grid: Grid, motion: Isometry = IDENTITY) -> Labels:
    """The label image of a folded sheet."""
    order = paper.order
    return draw_labels([paper.polygon(f) for f in order], [paper.back_up(f) for f in order], grid, motion)


def draw_values(
    polygons: Sequence[Polygon], values: Sequence[int], grid: Grid, motion: Isometry = IDENTITY
) -> npt.NDArray[np.uint8]:
    """Like :func:`draw_labels` with any values 1 to 255, such as a face's place in the stack plus one."""
    image = np.full((grid.rows, grid.cols), BACKGROUND, np.uint8)
    ends = np.cumsum([len(p) for p in polygons]).tolist()
    if not ends:
        return image
    points = _to_pixels(np.array([point for polygon in polygons for point in polygon]), grid, motion)
    box = _box(points, grid)
    if box is None:
        return image
    left, upper, right, lower = box
    fine = np.full(((lower - upper) * _FINE, (right - left) * _FINE), BACKGROUND, np.uint8)
    inner, wide = _shrink((points - (left, upper)) * _FINE, ends)
    fixed = np.rint(inner * (1 << _SHIFT)).astype(np.int32)
    start = 0
    for end, value, shows in zip(ends, values, wide, strict=True):
        if shows:
            cv2.fillConvexPoly(fine, fixed[start:end], value, cv2.LINE_8, _SHIFT)
        start = end
    image[upper:lower, left:right] = fine[::_FINE, ::_FINE]
    return image


def _to_pixels(points: Floats, grid: Grid, motion: Isometry) -> Floats:
    """Motion and grid in one affine map, (N, 2) to (N, 2)."""
    a, b, c, d, e, f = motion
    s = grid.pixels_per_unit
    moved: Floats = points @ np.array([[a * s, -c * s], [b * s, -d * s]])
    moved += ((e - grid.left) * s - 0.5, (grid.top - f) * s - 0.5)
    return moved


def _box(points: Floats, grid: Grid) -> tuple[int, int, int, int] | None:
    """The pixels to draw: left, upper, right, lower, the last two exclusive; None if there are none."""
    left, upper = np.maximum(np.floor(points.min(axis=0)), 0).astype(int).tolist()
    right, lower = np.minimum(np.ceil(points.max(axis=0)) + 1, (grid.cols, grid.rows)).astype(int).tolist()
    return (left, upper, right, lower) if left < right and upper < lower else None


def _shrink(points: Floats, ends: Sequence[int]) -> tuple[Floats, list[bool]]:
    """Move every side of every polygon inwards, (N, 2) to (N, 2), and say which polygons are no slivers."""
    count = len(points)
    following, preceding = np.arange(1, count + 1), np.arange(-1, count - 1)
    lasts = np.array(ends) - 1
    firsts = np.concatenate(([0], lasts[:-1] + 1))
    following[lasts], preceding[firsts] = firsts, lasts
    step = points[following] - points
    length = np.hypot(step[:, 0], step[:, 1]) + 1e-9
    side = step / length[:, None]
    before = side[preceding]
    turns = np.abs(before[:, 0] * side[:, 1] - before[:, 1] * side[:, 0])
    amount = np.where(turns < 0.05, 0.0, _INSET / np.maximum(turns, 0.2))
    doubled = np.add.reduceat(points[:, 0] * step[:, 1] - points[:, 1] * step[:, 0], firsts)
    wide = np.abs(doubled) > _SLIVER * np.add.reduceat(length, firsts)
    inner: Floats = points + (side - before) * amount[:, None]
    return inner, wide.tolist()
