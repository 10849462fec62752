"""Regions of a picture that may be a sheet of paper, and the four sides that fit each best."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import ByteMask, Floats

LEAST_PICTURE_SHARE = 0.012
"""Share of the picture that the sheet must fill."""
STEEPEST = 0.72
"""Cosine of the largest angle at which the camera may look at the table."""


@dataclass(frozen=True)
class Shape:
    """One region that may be the sheet: a filled ``mask`` (rows, cols), and the best four sides about it."""

    mask: ByteMask
    solid: float
    quad: Floats | None
    quad_iou: float
    at_border: bool

    @property
    def area(self) -> int:
        """In pixels."""
        return int(self.mask.sum())


def shapes_in(mask: ByteMask, least_share: float = LEAST_PICTURE_SHARE) -> Iterator[Shape]:
    """The larger connected regions of a mask."""
    cleaned = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    count, numbered, stats, _ = cv2.connectedComponentsWithStats(cleaned, connectivity=4)
    for i in range(1, count):
        if stats[i, cv2.CC_STAT_AREA] >= least_share * mask.size:
            yield _shape((numbered == i).astype(np.uint8))


def _shape(region: ByteMask) -> Shape:
    rows, cols = region.shape
    outline = outline_of(region)
    filled = np.asarray(cv2.drawContours(np.zeros_like(region), [outline], -1, 1, cv2.FILLED), np.uint8)
    x, y, width, height = cv2.boundingRect(outline)
    at_border = x <= 1 or y <= 1 or x + width >= cols - 1 or y + height >= rows - 1
    quad = fit_quad(outline)
    iou = 0.0 if quad is None else polygon_iou(filled, quad)
    return Shape(filled, float(region.sum()) / float(filled.sum()), quad, iou, at_border)


def outline_of(mask: ByteMask) -> npt.NDArray[np.int32]:
    """The outer contour of the largest region of a mask, (N, 1, 2)."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return np.asarray(max(outlines, key=cv2.contourArea), np.int32)


def fit_quad(outline: npt.NDArray[np.int32]) -> Floats | None:
    """Four corners (4, 2) about an outline, each side fitted to its own points; None if not four."""
    corners = simplified(outline, 4)
    if corners is None:
        return None
    points = outline.reshape(-1, 2).astype(np.float64)
    for _ in range(2):
        lines = [_fit_side(points, corners[i], corners[(i + 1) % 4]) for i in range(4)]
        if any(line is None for line in lines):
            return corners
        met = [_cross(lines[i - 1], lines[i]) for i in range(4)]
        if any(point is None for point in met):
            return corners
        corners = np.array(met)
    return corners


def simplified(outline: npt.NDArray[np.int32], count: int) -> Floats | None:
    """The outline's convex hull with just ``count`` corners, by the least simplification."""
    hull = cv2.convexHull(outline)
    perimeter = cv2.arcLength(hull, closed=True)
    for epsilon in np.geomspace(0.006, 0.12, 24):
        corners = cv2.approxPolyDP(hull, float(epsilon) * perimeter, closed=True).reshape(-1, 2)
        if len(corners) <= count:
            return corners.astype(np.float64) if len(corners) == count else None
    return None


def _fit_side(points: Floats, start: Floats, end: Floats) -> Floats | None:
    """A line (vx, vy, x, y) through the outline points near the middle of a side."""
    along = end - start
    length = float(np.hypot(*along)) + 1e-9
    relative = (points - start) @ np.column_stack([along / length, [along[1] / length, -along[0] / length]])
    near = (np.abs(relative[:, 1]) < 0.06 * length + 2) & (np.abs(relative[:, 0] / length - 0.5) < 0.38)
    if near.sum() < 6:
        return None
    fitted = cv2.fitLine(points[near].astype(np.float32), cv2.DIST_HUBER, 0, 0.01, 0.01)
    return np.asarray(fitted, np.float64).ravel()


def _cross(first: Floats | None, second: Floats | None) -> Floats | None:
    if first is None or second is None:
        return None
    matrix = np.column_stack([first[:2], -second[:2]])
    if abs(np.linalg.det(matrix)) < 0.1:
        return None
    return np.asarray(first[2:] + first[:2] * np.linalg.solve(matrix, second[2:] - first[2:])[0], np.float64)


def polygon_iou(mask: ByteMask, polygon: Floats) -> float:
    """Intersection over union of a mask and a polygon of pixel corners."""
    drawn = np.zeros_like(mask)
    cv2.fillPoly(drawn, [np.rint(polygon * 16).astype(np.int32)], 1, cv2.LINE_8, 4)
    union = int(np.count_nonzero(drawn | mask))
    return float(np.count_nonzero(drawn & mask)) / max(union, 1)


def clockwise(corners: Floats) -> Floats:
    """In the order that is clockwise on screen."""
    x, y = corners[:, 0], corners[:, 1]
    twice = float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    return corners if twice > 0 else corners[::-1]


def squareness(corners: Floats, shape: tuple[int, ...]) -> float:
    """How far a quadrilateral is from a perspective view of a square; 0 is exact.

    For every focal length a camera of this picture ``shape`` (rows, cols) may have, the homography tells the
    sides' relative difference and the cosine of their angle; the best focal length counts.
    """
    rows, cols = shape[:2]
    unit = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    homography = cv2.getPerspectiveTransform(unit, corners.astype(np.float32))
    centred = np.array([[1, 0, -cols / 2], [0, 1, -rows / 2], [0, 0, 1.0]]) @ homography
    errors = []
    for focal in np.geomspace(0.6, 6.0, 24) * max(rows, cols):
        axes = np.diag([1 / focal, 1 / focal, 1.0]) @ centred[:, :2]
        first, second = np.linalg.norm(axes, axis=0)
        if abs(np.cross(axes[:, 0], axes[:, 1])[2]) < STEEPEST * first * second:
            continue
        errors.append(max(abs(np.log(first / second)), abs(axes[:, 0] @ axes[:, 1]) / (first * second)))
    return float(min(errors, default=1.0))
