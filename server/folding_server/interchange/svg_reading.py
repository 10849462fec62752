"""Crease patterns in drawings: the straight lines of an SVG file by their colour."""

from collections.abc import Iterator
from dataclasses import replace
from io import StringIO
from math import hypot
from typing import TYPE_CHECKING, Any

from folding_server.errors import ProgramError
from folding_server.interchange.colors import letter_of_color
from folding_server.interchange.drawn_line import DrawnLine
from folding_server.interchange.fold_frames import LARGEST
from folding_server.interchange.gaps import GAP
from folding_server.interchange.line_files import ALL_LETTERS, drawn_downwards, framed
from folding_server.interchange.xml_reading import without_declaration, xml_root
from folding_server.simulator.foldability import CreasePattern

if TYPE_CHECKING:
    from svgelements import Shape

FLATNESS = 1e-3
"""How far a curve may leave its chord, in lengths of the chord, to be a straight line."""


def read_svg(text: str, gap: float = GAP) -> CreasePattern:
    """The crease pattern of an SVG drawing, y turned up: lines, polylines, polygons, rectangles and straight parts of paths, with
    transforms and viewBox applied. What lies off the sheet is left out; without a black outline the rectangle around all
    lines is the sheet. ProgramError if it is no SVG, or draws no lines.
    """
    root = xml_root(text, "SVG file")
    if root.tag.rpartition("}")[2] != "svg":
        raise ProgramError(
            f"The file is XML, but its root is <{root.tag[:40]}> and not <svg>; save the drawing as SVG."
        )
    if any(str(each.tag).endswith("}use") or each.tag == "use" for each in root.iter()):
        raise ProgramError(
            "The SVG file draws clones (<use>), which are not read; unlink them and save it again."
        )
    lines, curves = _lines(text)
    if not lines:
        raise ProgramError(
            "The SVG file draws no straight lines with a stroke; draw mountains red, valleys blue and edges of the sheet black."
        )
    lines, notes = framed(lines)
    if curves:
        notes = (
            *notes,
            f"{curves} curved lines of the SVG file were left out; only straight creases are read.",
        )
    pattern = drawn_downwards(lines, gap, off_sheet=ALL_LETTERS)
    return replace(pattern, notes=notes)


def _lines(text: str) -> tuple[list[DrawnLine], int]:
    """The straight lines of a drawing, and how many curves it has."""
    from svgelements import SVG, Shape

    try:
        drawing = SVG.parse(StringIO(without_declaration(text)), reify=True)
        shapes = [each for each in drawing.elements() if isinstance(each, Shape)]
        parts = [part for shape in shapes for part in _parts(shape)]
    except (
        ValueError,
        TypeError,
        AttributeError,
        KeyError,
        IndexError,
        ArithmeticError,
        RecursionError,
        AssertionError,
    ):
        raise ProgramError("The SVG file has a shape that cannot be read; save it as plain SVG.") from None
    lines = [part for part in parts if part is not None]
    if not all(abs(c) <= LARGEST for line in lines for end in (line.start, line.end) for c in end):
        raise ProgramError(
            f"The SVG file has a line with a coordinate beyond {LARGEST:g}; scale the drawing down."
        )
    return lines, len(parts) - len(lines)


def _parts(shape: "Shape") -> Iterator[DrawnLine | None]:
    """The segments of a shape with a stroke: straight ones as lines, curved ones as None."""
    from svgelements import Line, Path

    stroke = shape.stroke
    if stroke is None or stroke.value is None or not stroke.alpha:
        return
    letter = letter_of_color(stroke.red, stroke.green, stroke.blue)
    for segment in Path(shape):
        if segment.start is None or segment.end is None or type(segment).__name__ == "Move":
            continue
        start, end = _xy(segment.start), _xy(segment.end)
        if start == end:
            continue
        straight = isinstance(segment, Line) or type(segment).__name__ == "Close" or _is_straight(segment)
        yield DrawnLine(start, end, letter) if straight else None


def _is_straight(segment: Any) -> bool:  # noqa: ANN401 - svgelements has no types
    """Whether a curve stays on its chord."""
    (x1, y1), (x2, y2) = _xy(segment.start), _xy(segment.end)
    length = hypot(x2 - x1, y2 - y1)
    points = (_xy(segment.point(k / 8)) for k in range(1, 8))
    off = max(abs((x2 - x1) * (y - y1) - (y2 - y1) * (x - x1)) / length for x, y in points)
    return off <= FLATNESS * length


def _xy(point: Any) -> tuple[float, float]:  # noqa: ANN401 - svgelements has no types
    return float(point.x), float(point.y)
