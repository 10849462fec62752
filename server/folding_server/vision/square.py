"""The flat square of the first photo: found, or a plain sentence that says what was seen instead."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import ByteMask, Floats, Image, RgbImage
from folding_server.errors import PhotoError
from folding_server.vision.colours import cluster, skin, to_lab
from folding_server.vision.straight import edge_support, line_support, refine_polygon
from folding_server.vision.surfaces import fit_surface

WORKING_SIDE = 400
"""Longest side, in pixels, of the picture in which the sheet is looked for."""
QUAD_IOU = 0.955
"""How well four straight sides must cover the shape."""
LEAST_PICTURE_SHARE = 0.012
"""Share of the picture that the sheet must fill."""
NOT_SQUARE = 0.14
"""Relative difference of the sides, and cosine of the corners, that still counts as a square."""
EDGE_FACTORS = (3.0, 4.5, 7.0)
"""How many times steeper than usual the picture must be where the edge of a sheet of the table's colour is."""
LEAST_SUPPORT = 0.6
"""Share of every side along which the picture must show a sharp step."""
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


def find_square(rgb: RgbImage, where: str) -> Floats:
    """The four corners (4, 2) of the flat sheet in (column, row), clockwise as seen, sub-pixel.

    PhotoError with ``where`` and what was seen if there is no flat, fully visible square.
    """
    scale = min(1.0, WORKING_SIDE / max(rgb.shape[:2]))
    small = np.asarray(cv2.resize(rgb, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
    lab = to_lab(np.asarray(cv2.medianBlur(small, 3), np.uint8))
    standing_out = [shape for mask in _differing(lab) for shape in _shapes(mask)]
    clustered = [shape for count in (3, 5) for mask in _clusters(lab, count) for shape in _shapes(mask)]
    enclosed = [shape for mask in _enclosed(lab) for shape in _shapes(mask)]
    candidates = [(s, edge_support) for s in _best(standing_out + clustered)]
    candidates += [(s, line_support) for s in _best(enclosed)]
    for shape, support in candidates:
        ratio = np.array([small.shape[1] / rgb.shape[1], small.shape[0] / rgb.shape[0]])
        corners = _clockwise((np.asarray(shape.quad) + 0.5) / ratio - 0.5)
        corners = refine_polygon(rgb, corners, reach=max(4.0, 2.0 / scale))
        if squareness(corners, rgb.shape[:2]) <= NOT_SQUARE and support(rgb, corners) >= LEAST_SUPPORT:
            return corners
    raise PhotoError(
        f"{where} must show the flat, fully visible square sheet, but {_what(small, standing_out)}."
    )


def _best(shapes: list[Shape]) -> list[Shape]:
    """The shapes that have four straight sides, the best first."""
    quads = [s for s in shapes if s.quad_iou >= QUAD_IOU and not s.at_border]
    return sorted(_innermost(quads), key=lambda s: (round(s.quad_iou, 2), s.area), reverse=True)


def _enclosed(lab: Image) -> Iterator[ByteMask]:
    """Masks of what an unbroken edge encloses, however faint: a sheet on a table of its own colour."""
    smooth = cv2.GaussianBlur(lab, (0, 0), 1.2)
    steps = np.hypot(cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1)).max(axis=-1)
    usual = float(np.median(steps)) + 1e-3
    for factor in EDGE_FACTORS:
        edges = cv2.morphologyEx((steps > factor * usual).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3)))
        open_space = np.pad(1 - edges, 1, constant_values=1).astype(np.uint8)
        cv2.floodFill(open_space, None, (0, 0), 2)
        inside = (open_space[1:-1, 1:-1] != 2).astype(np.uint8)
        yield np.asarray(cv2.erode(inside, np.ones((3, 3), np.uint8)), np.uint8)


def _differing(lab: Image) -> Iterator[ByteMask]:
    """Masks of what differs from the table, at several thresholds."""
    difference = table_difference(lab)
    levels = np.clip(difference * 8, 0, 255).astype(np.uint8)
    otsu = float(cv2.threshold(levels, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[0]) / 8
    for threshold in sorted({max(otsu, 4.0), max(otsu / 2, 3.5), max(2 * otsu, 6.0)}):
        yield (difference > threshold).astype(np.uint8)


def table_difference(lab: Image) -> Image:
    """How many deviations each pixel lies from the table, whose colour the picture's border tells."""
    rows, cols = lab.shape[:2]
    y, x = np.mgrid[-1 : 1 : rows * 1j, -1 : 1 : cols * 1j]
    border = np.maximum(np.abs(x), np.abs(y)) > 0.86
    inside = border
    for order in (1, 2):
        surface = fit_surface(x[inside], y[inside], lab[inside].astype(np.float64), order)
        inverse = np.linalg.inv(surface.covariance + np.diag([4.0, 1.5, 1.5]))
        residual = lab - surface.at(x, y)
        difference = np.sqrt(np.einsum("...i,ij,...j->...", residual, inverse.astype(np.float32), residual))
        inside = difference < 3.5
        if inside.sum() < 0.1 * inside.size:
            break
    return np.asarray(difference, np.float32)


def _clusters(lab: Image, count: int) -> Iterator[ByteMask]:
    """One mask for each of ``count`` colour clusters."""
    pixels = lab.reshape(-1, 3)
    _, centres = cluster(pixels[:: max(1, len(pixels) // 8000)], count)
    nearest = np.stack([((lab - centre) ** 2).sum(axis=-1) for centre in centres]).argmin(axis=0)
    for number in range(count):
        yield (nearest == number).astype(np.uint8)


def _shapes(mask: ByteMask) -> Iterator[Shape]:
    """The larger connected regions of a mask."""
    cleaned = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    count, numbered, stats, _ = cv2.connectedComponentsWithStats(cleaned, connectivity=4)
    for i in range(1, count):
        if stats[i, cv2.CC_STAT_AREA] >= LEAST_PICTURE_SHARE * mask.size:
            yield _shape((numbered == i).astype(np.uint8))


def _shape(region: ByteMask) -> Shape:
    rows, cols = region.shape
    outline = _outline(region)
    filled = np.asarray(cv2.drawContours(np.zeros_like(region), [outline], -1, 1, cv2.FILLED), np.uint8)
    x, y, width, height = cv2.boundingRect(outline)
    at_border = x <= 1 or y <= 1 or x + width >= cols - 1 or y + height >= rows - 1
    quad = fit_quad(outline)
    iou = 0.0 if quad is None else polygon_iou(filled, quad)
    return Shape(filled, float(region.sum()) / float(filled.sum()), quad, iou, at_border)


def _outline(mask: ByteMask) -> npt.NDArray[np.int32]:
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


def _innermost(shapes: list[Shape]) -> list[Shape]:
    """Without the frames (a mat, a tray) in whose hole another quadrilateral lies."""
    return [s for s in shapes if s.solid > 0.6 and not any(_is_hole(s, other) for other in shapes)]


def _is_hole(outer: Shape, inner: Shape) -> bool:
    hollow = (1 - outer.solid) * outer.area
    within = int((outer.mask & inner.mask).sum()) > 0.98 * inner.area
    return within and inner.area < 0.95 * outer.area and hollow > 0.8 * inner.area


def _clockwise(corners: Floats) -> Floats:
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


def _what(small: RgbImage, shapes: list[Shape]) -> str:
    """What a photo without a flat square shows, as the rest of a sentence."""
    plain = [s for s in shapes if s.solid > 0.5 and s.area < 0.85 * s.mask.size and not _spread_out(s)]
    if not plain:
        return (
            "nothing stands out from the table: lay the sheet on one of another colour, "
            "or let a light from the side show its edges"
        )
    shape = max(plain, key=lambda s: s.area * (0.3 if s.at_border else 1.0))
    near = cv2.dilate(shape.mask, np.ones((9, 9), np.uint8)) > 0
    skin_share = float((skin(small) & near).sum()) / shape.area
    if shape.at_border and 0.06 < skin_share < 0.85:
        return "a hand or something else of skin colour touches what may be the sheet"
    if shape.at_border:
        return "what may be the sheet reaches beyond the edge of the picture"
    return _shape_in_words(shape, small.shape)


def _spread_out(shape: Shape) -> bool:
    """Whether a region is ragged, as stains, shine and shadow on an empty table are."""
    outline = _outline(shape.mask)
    hull = cv2.contourArea(cv2.convexHull(outline))
    smooth = 4 * pi * shape.area / max(cv2.arcLength(outline, closed=True), 1.0) ** 2
    return shape.area < 0.5 * hull or smooth < 0.12


def _shape_in_words(shape: Shape, size: tuple[int, ...]) -> str:
    outline = _outline(shape.mask)
    ellipse = np.asarray(
        cv2.ellipse(np.zeros_like(shape.mask), cv2.fitEllipse(outline), 1, cv2.FILLED), np.uint8
    )
    round_iou = float((ellipse & shape.mask).sum()) / float((ellipse | shape.mask).sum())
    if round_iou > max(0.97, shape.quad_iou):
        return "the sheet it shows is round"
    triangle = simplified(outline, 3)
    if triangle is not None and polygon_iou(shape.mask, triangle) > 0.93:
        return "it shows a triangle, a sheet that is folded already"
    if shape.quad is not None and shape.quad_iou >= QUAD_IOU:
        off = squareness(_clockwise(shape.quad), size)
        return f"it shows a four-sided shape that is no square (sides or corners are off by {off:.0%})"
    perimeter = cv2.arcLength(outline, closed=True)
    corners = len(cv2.approxPolyDP(outline, 0.015 * perimeter, closed=True))
    return f"it shows a shape with about {corners} corners"
