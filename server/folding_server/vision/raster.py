"""Folded paper to label images, by painting the faces bottom to top; fast enough for every search."""

from collections.abc import Sequence
from functools import lru_cache
from math import ceil, floor
from typing import NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Floats, Indices
from folding_server.geometry.convex import Polygon
from folding_server.geometry.isometry import IDENTITY
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACK, FRONT, LabelImage

_SHIFT = 6
"""Binary places of coordinates given to OpenCV."""
_FINE = 4
"""Fine pixels a side of each pixel kept: OpenCV fills every pixel that an outline passes through."""
_INSET = 0.2
"""Fine pixels that every side moves inwards to make up for that; half a pixel would open cracks."""
_SLIVER = 0.6
"""Fine pixels of mean width below which a face is not drawn."""


def draw_labels(
    polygons: Sequence[Polygon], backs: Sequence[bool], grid: Grid, motion: Similarity = IDENTITY
) -> LabelImage:
    """The label image of convex folded faces.

    ``polygons`` run bottom to top in sheet units, ``backs`` says which lie back up, ``motion`` (an isometry
    or a similarity, as the same six numbers) is applied first. A pixel belongs to a face if its centre does.
    """
    return draw_values(polygons, [BACK if back else FRONT for back in backs], grid, motion)


def draw_paper(paper: Paper, grid: Grid, motion: Similarity = IDENTITY) -> LabelImage:
    """The label image of a folded sheet."""
    order = paper.order
    return draw_labels([paper.polygon(f) for f in order], [paper.back_up(f) for f in order], grid, motion)


def draw_values(
    polygons: Sequence[Polygon], values: Sequence[int], grid: Grid, motion: Similarity = IDENTITY
) -> npt.NDArray[np.uint8]:
    """Like :func:`draw_labels` with any values 1 to 255, such as a face's place in the stack plus one."""
    image = np.zeros((grid.rows, grid.cols), np.uint8)
    if not polygons:
        return image
    points = _to_pixels(np.array([point for polygon in polygons for point in polygon]), grid, motion)
    box = _box(points, grid)
    if box is None:
        return image
    left, upper, right, lower = box
    fine = np.zeros(((lower - upper) * _FINE, (right - left) * _FINE), np.uint8)
    cycles = _cycles(tuple(map(len, polygons)))
    inner, wide = _shrink((points - (left, upper)) * _FINE, cycles)
    fixed = _fixed(inner)
    for span, value, shows in zip(cycles.spans, values, wide, strict=True):
        if shows:
            cv2.fillConvexPoly(fine, fixed[span], value, cv2.LINE_8, _SHIFT)
    image[upper:lower, left:right] = fine[::_FINE, ::_FINE]
    return image


def draw_touched(
    polygons: Sequence[Polygon], grid: Grid, motion: Similarity = IDENTITY
) -> npt.NDArray[np.uint8]:
    """1 at all pixels that convex polygons touch, else 0: half a pixel wider than :func:`draw_values`, and much faster."""
    image = np.zeros((grid.rows, grid.cols), np.uint8)
    whole = [polygon for polygon in polygons if len(polygon) > 2]
    if whole:
        points = _to_pixels(np.array([point for polygon in whole for point in polygon]), grid, motion)
        fixed = _fixed(points)
        for span in _cycles(tuple(map(len, whole))).spans:
            cv2.fillConvexPoly(image, fixed[span], 1, cv2.LINE_8, _SHIFT)
    return image


def _fixed(points: Floats) -> npt.NDArray[np.int32]:
    """Pixel coordinates as OpenCV takes them, with _SHIFT binary places."""
    return np.rint(points * (1 << _SHIFT)).astype(np.int32)


def _to_pixels(points: Floats, grid: Grid, motion: Similarity) -> Floats:
    """Motion and grid in one affine map, (N, 2) to (N, 2)."""
    a, b, c, d, e, f = motion
    s = grid.pixels_per_unit
    moved: Floats = points @ np.array([[a * s, -c * s], [b * s, -d * s]])
    moved += ((e - grid.left) * s - 0.5, (grid.top - f) * s - 0.5)
    return moved


def _box(points: Floats, grid: Grid) -> tuple[int, int, int, int] | None:
    """The pixels to draw: left, upper, right, lower, the last two exclusive; None if there are none."""
    (x0, y0), (x1, y1) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    left, upper = max(floor(x0), 0), max(floor(y0), 0)
    right, lower = min(ceil(x1) + 1, grid.cols), min(ceil(y1) + 1, grid.rows)
    return (left, upper, right, lower) if left < right and upper < lower else None


class _Cycles(NamedTuple):
    """Where the corners of each polygon lie in an array of all, and which corner follows and precedes which."""

    spans: tuple[slice, ...]
    firsts: Indices
    following: Indices
    preceding: Indices


@lru_cache(maxsize=4096)
def _cycles(lengths: tuple[int, ...]) -> _Cycles:
    """The cycles of polygons with so many corners."""
    counts = np.array(lengths, np.intp)
    ends = np.cumsum(counts)
    firsts, lasts = ends - counts, ends - 1
    following, preceding = np.arange(1, ends[-1] + 1), np.arange(-1, ends[-1] - 1)
    following[lasts], preceding[firsts] = firsts, lasts
    spans = tuple(slice(*pair) for pair in zip(firsts.tolist(), ends.tolist(), strict=True))
    return _Cycles(spans, firsts, following, preceding)


def _shrink(points: Floats, cycles: _Cycles) -> tuple[Floats, list[bool]]:
    """Move every side of every polygon inwards, (N, 2) to (N, 2), and say which polygons are no slivers."""
    step = points[cycles.following] - points
    length = np.hypot(step[:, 0], step[:, 1]) + 1e-9
    side = step / length[:, None]
    before = side[cycles.preceding]
    turns = np.abs(before[:, 0] * side[:, 1] - before[:, 1] * side[:, 0])
    amount = np.where(turns < 0.05, 0.0, _INSET / np.maximum(turns, 0.2))
    doubled = np.add.reduceat(points[:, 0] * step[:, 1] - points[:, 1] * step[:, 0], cycles.firsts)
    wide = np.abs(doubled) > _SLIVER * np.add.reduceat(length, cycles.firsts)
    inner: Floats = points + (side - before) * amount[:, None]
    return inner, wide.tolist()
