"""What a photo without a flat square shows, in words, and what to do about it."""

from math import pi

import cv2
import numpy as np

from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.vision.colours import skin
from folding_server.vision.drawings import even_share, is_drawing
from folding_server.vision.quads import Shape, clockwise, outline_of, polygon_iou, simplified, squareness

QUAD_IOU = 0.955
"""How well four straight sides must cover the shape."""
HALF_SHEET = 0.4
"""Logarithm of the ratio of the sides from which a rectangle may be a sheet folded in half: 1 to 1.5."""
_BEGIN = "begin with a photo of the flat sheet"


def no_square(where: str, seen: str) -> PhotoError:
    """The refusal of a photo that must show the flat sheet, and in which this is ``seen``."""
    return PhotoError(f"{where} must show the flat, fully visible square sheet, but {seen}.")


def too_small(side: float, shape: tuple[int, ...]) -> str:
    """That a sheet of a side is too small in a photo of a shape (rows, columns), and what to do; the rest of a sentence."""
    longest = max(shape[:2])
    return (
        f"the sheet is {side:.0f} pixels wide in a photo of {longest:,}: come closer, until it is at least a quarter of the photo "
        f"wide ({longest // 4:,} pixels)"
    )


def paper_like(shapes: list[Shape]) -> list[Shape]:
    """Those of the shapes that may be paper: not the table itself, nor ragged."""
    return [s for s in shapes if s.solid > 0.5 and s.area < 0.85 * s.mask.size and not _spread_out(s)]


def what_is_seen(small: RgbImage, shapes: list[Shape]) -> str:
    """What a photo without a flat square shows, as the rest of a sentence."""
    plain = paper_like(shapes)
    if is_drawing(small):
        return f"it looks like a drawing: {even_share(small):.0%} of it is perfectly even, as no photo is: give photos of real paper"
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
        return (
            f"what may be the sheet reaches beyond the edge of the picture ({_edges_in_words(shape)}): "
            "move the camera until all of it is seen"
        )
    return _shape_in_words(shape, small.shape)


def _spread_out(shape: Shape) -> bool:
    """Whether a region is ragged, as stains, shine and shadow on an empty table are."""
    outline = outline_of(shape.mask)
    hull = cv2.contourArea(cv2.convexHull(outline))
    smooth = 4 * pi * shape.area / max(cv2.arcLength(outline, closed=True), 1.0) ** 2
    return shape.area < 0.5 * hull or smooth < 0.12


def _shape_in_words(shape: Shape, size: tuple[int, ...]) -> str:
    outline = outline_of(shape.mask)
    ellipse = np.asarray(
        cv2.ellipse(np.zeros_like(shape.mask), cv2.fitEllipse(outline), 1, cv2.FILLED), np.uint8
    )
    round_iou = float((ellipse & shape.mask).sum()) / float((ellipse | shape.mask).sum())
    if round_iou > max(0.97, shape.quad_iou):
        return "the sheet it shows is round"
    triangle = simplified(outline, 3)
    if triangle is not None and polygon_iou(shape.mask, triangle) > 0.93:
        return f"it shows a triangle, a sheet that is folded already: {_BEGIN}"
    if shape.quad is not None and shape.quad_iou >= QUAD_IOU:
        off = squareness(clockwise(shape.quad), size)
        said = f"it shows a four-sided shape that is no square (sides or corners are off by {off:.0%})"
        return f"{said}, as a sheet folded in half is: {_BEGIN}" if off > HALF_SHEET else said
    perimeter = cv2.arcLength(outline, closed=True)
    corners = len(cv2.approxPolyDP(outline, 0.015 * perimeter, closed=True))
    return f"it shows a shape with about {corners} corners, as a folded sheet has: {_BEGIN}"


def _edges_in_words(shape: Shape) -> str:
    """Which edges of the picture a shape reaches."""
    x, y, width, height = cv2.boundingRect(outline_of(shape.mask))
    rows, cols = shape.mask.shape
    reached = (y <= 1, x + width >= cols - 1, y + height >= rows - 1, x <= 1)
    names = [name for name, is_so in zip(("top", "right", "bottom", "left"), reached, strict=True) if is_so]
    return " and ".join(names)
