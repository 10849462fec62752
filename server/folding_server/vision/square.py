"""The flat square of the first photo: found, or a plain sentence that says what was seen instead."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from folding_server.arrays import ByteMask, Floats, Image, RgbImage
from folding_server.vision.colours import cluster, to_lab
from folding_server.vision.quads import Shape, clockwise, shapes_in, squareness
from folding_server.vision.square_refusals import QUAD_IOU, no_square, paper_like, too_small, what_is_seen
from folding_server.vision.straight import edge_support, line_support, refine_polygon
from folding_server.vision.surfaces import fit_surface

WORKING_SIDE = 400
"""Longest side, in pixels, of the picture in which the sheet is looked for."""
FINER_SIDE = 1600
"""Longest side, in pixels, of the picture in which a smaller sheet is looked for where nothing else stands out."""
SMALL_PICTURE_SHARE = 0.0004
"""Share of the picture that a sheet must fill to be found then: a fiftieth of its width."""
LEAST_SIDE = 40.0
"""Pixels of the sheet's side below which neither its corners nor its creases can be told."""
MOST_TIMES_SMALLER = 12.0
"""A square so many times smaller (area) than something beside it is no sheet of paper for that photo."""
MOST_CANDIDATES = 8
"""Quadrilaterals that are looked at closely, once one is a square."""
SAME_QUAD = 0.8
"""Intersection over union from which two quadrilaterals are one shape seen twice."""
EDGE_FACTORS = (3.0, 4.5, 7.0)
"""How many times steeper than usual the picture must be where the edge of a sheet of the table's colour is."""
NOT_SQUARE = 0.14
"""Relative difference of the sides, and cosine of the corners, that still counts as a square."""
LEAST_SUPPORT = 0.6
"""Share of every side along which the picture must show a sharp step."""
Support = Callable[[RgbImage, Floats], float]


@dataclass(frozen=True)
class FoundSquare:
    """The flat sheet of a photo: its four ``corners`` (4, 2), and the widths in pixels of other squares beside it."""

    corners: Floats
    others: tuple[float, ...] = ()

    @property
    def side(self) -> float:
        """The mean length of its sides in pixels."""
        return _mean_side(self.corners)

    @property
    def remarks(self) -> tuple[str, ...]:
        """That the photo shows other squares besides, which was taken, and why; empty if it shows none."""
        if not self.others:
            return ()
        widths = " and ".join(f"{width:.0f}" for width in self.others)
        said = (
            f"the first photo shows {len(self.others) + 1} squares: the largest, {self.side:.0f} pixels wide, is taken for the "
            f"sheet, and not those {widths} pixels wide; take other squares away if that is wrong"
        )
        return (said,)


def find_square(rgb: RgbImage, where: str) -> Floats:
    """The four corners (4, 2) of the flat sheet in (column, row), clockwise as seen, sub-pixel.

    PhotoError with ``where`` and what was seen if there is no flat, fully visible square.
    """
    return look_for_square(rgb, where).corners


def look_for_square(rgb: RgbImage, where: str) -> FoundSquare:
    """The flat sheet, and what else in the photo might be one: of squares that lie apart the largest is the sheet.

    PhotoError with ``where``, what was seen and what to do if there is no flat, fully visible square, if one is many times smaller
    than something beside it, or if it is too small to be read.
    """
    scale = min(1.0, WORKING_SIDE / max(rgb.shape[:2]))
    small = np.asarray(cv2.resize(rgb, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
    lab = to_lab(np.asarray(cv2.medianBlur(small, 3), np.uint8))
    standing_out = [shape for mask in _differing(lab) for shape in shapes_in(mask)]
    clustered = [shape for count in (3, 5) for mask in _clusters(lab, count) for shape in shapes_in(mask)]
    enclosed = [shape for mask in _enclosed(lab) for shape in shapes_in(mask)]
    candidates = [(s, edge_support) for s in _best(standing_out + clustered)]
    candidates += [(s, line_support) for s in _best(enclosed)]
    squares = _squares(rgb, candidates)
    if not squares and not paper_like(standing_out):
        squares = _small_squares(rgb)
    if not squares:
        raise no_square(where, what_is_seen(small, standing_out))
    return _chosen(rgb, squares, small, standing_out, where)


def _squares(rgb: RgbImage, candidates: Sequence[tuple[Shape, Support]]) -> list[Floats]:
    """The corners of those quadrilaterals that are squares seen by a camera, each once, in the order of the candidates."""
    found: list[Floats] = []
    judged: list[Floats] = []
    for shape, support in candidates:
        ratio = np.array([shape.mask.shape[1] / rgb.shape[1], shape.mask.shape[0] / rgb.shape[0]])
        corners = clockwise((np.asarray(shape.quad) + 0.5) / ratio - 0.5)
        if (found and len(judged) >= MOST_CANDIDATES) or any(
            _overlap(corners, other) > SAME_QUAD for other in found
        ):
            continue
        judged.append(corners)
        corners = refine_polygon(rgb, corners, reach=max(4.0, 2.0 / float(ratio.max())))
        if squareness(corners, rgb.shape[:2]) <= NOT_SQUARE and support(rgb, corners) >= LEAST_SUPPORT:
            found.append(corners)
    return found


def _small_squares(rgb: RgbImage) -> list[Floats]:
    """Squares that are looked for more closely in a photo that shows nothing else."""
    scale = min(1.0, FINER_SIDE / max(rgb.shape[:2]))
    finer = np.asarray(cv2.resize(rgb, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
    lab = to_lab(np.asarray(cv2.medianBlur(finer, 3), np.uint8))
    shapes = [shape for mask in _differing(lab) for shape in shapes_in(mask, SMALL_PICTURE_SHARE)]
    return _squares(rgb, [(shape, edge_support) for shape in _best(shapes)])


def _chosen(
    rgb: RgbImage, squares: list[Floats], small: RgbImage, standing_out: list[Shape], where: str
) -> FoundSquare:
    """The sheet among squares: the first, or a larger one that lies apart from it."""
    sheet = squares[0]
    for other in squares[1:]:
        if _overlap(sheet, other) == 0 and _area(other) > _area(sheet):
            sheet = other
    whole = rgb.shape[0] * rgb.shape[1]
    share = _area(sheet) / whole
    ratio = np.array([small.shape[1] / rgb.shape[1], small.shape[0] / rgb.shape[0]])
    middle = tuple(np.clip(sheet.mean(axis=0) * ratio, 0, np.array(small.shape[1::-1]) - 1).astype(int))
    beside = [shape for shape in paper_like(standing_out) if not shape.mask[middle[1], middle[0]]]
    times = max((shape.area / shape.mask.size / share for shape in beside), default=0.0)
    if times > MOST_TIMES_SMALLER:
        raise no_square(
            where,
            f"{what_is_seen(small, beside)} (a square beside it is {times:.0f} times smaller, no sheet)",
        )
    if _mean_side(sheet) < LEAST_SIDE:
        raise no_square(where, too_small(_mean_side(sheet), rgb.shape))
    apart = tuple(_mean_side(other) for other in squares if _overlap(sheet, other) == 0)
    return FoundSquare(sheet, apart)


def _area(corners: Floats) -> float:
    return float(cv2.contourArea(corners.astype(np.float32)))


def _mean_side(corners: Floats) -> float:
    return float(np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1).mean())


def _overlap(first: Floats, second: Floats) -> float:
    """Intersection over union of two convex quadrilaterals."""
    common, _ = cv2.intersectConvexConvex(first.astype(np.float32), second.astype(np.float32))
    return float(common) / max(_area(first) + _area(second) - float(common), 1e-9)


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


def _innermost(shapes: list[Shape]) -> list[Shape]:
    """Without the frames (a mat, a tray) in whose hole another quadrilateral lies."""
    return [s for s in shapes if s.solid > 0.6 and not any(_is_hole(s, other) for other in shapes)]


def _is_hole(outer: Shape, inner: Shape) -> bool:
    hollow = (1 - outer.solid) * outer.area
    within = int((outer.mask & inner.mask).sum()) > 0.98 * inner.area
    return within and inner.area < 0.95 * outer.area and hollow > 0.8 * inner.area
