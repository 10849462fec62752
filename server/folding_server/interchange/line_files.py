"""Lines that programs draw with y running down, as crease patterns with y running up."""

from collections.abc import Sequence

from folding_server.geometry.line import Point
from folding_server.interchange.arrangement import arranged
from folding_server.interchange.drawn_line import DrawnLine
from folding_server.simulator.foldability import Y_DOWN, CreasePattern

ALL_LETTERS = "BMVFU"
"""Every line that lies off the sheet is left out, such as those of a legend."""


def drawn_downwards(lines: Sequence[DrawnLine], gap: float, off_sheet: str = "F") -> CreasePattern:
    """The crease pattern of lines whose y runs down: as they are seen, y turned up; places are those of the lines."""
    turned = [DrawnLine(_turned(line.start), _turned(line.end), line.assignment) for line in lines]
    return arranged(turned, gap=gap, off_sheet=off_sheet, axes=Y_DOWN)


def framed(lines: Sequence[DrawnLine]) -> tuple[list[DrawnLine], tuple[str, ...]]:
    """Lines with the rectangle around them as edge of the sheet, if no line is one, and a note that says so."""
    if any(line.assignment == "B" for line in lines) or not lines:
        return list(lines), ()
    xs, ys = zip(*(point for line in lines for point in (line.start, line.end)), strict=True)
    corners = [(min(xs), min(ys)), (max(xs), min(ys)), (max(xs), max(ys)), (min(xs), max(ys))]
    edges = [DrawnLine(p, q, "B") for p, q in zip(corners, (*corners[1:], corners[0]), strict=True) if p != q]
    return [*edges, *lines], (
        "No edge of the sheet is drawn; the rectangle around the creases is taken for it.",
    )


def _turned(point: Point) -> Point:
    return point[0], 0.0 - point[1]
