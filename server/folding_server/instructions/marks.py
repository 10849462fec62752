"""What a sheet is drawn with: paths, letters and photos, in points (1/72 inch), y down, free of any file format."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from folding_server.geometry.convex import Box
from folding_server.geometry.line import Point

Segment = tuple[Point, ...]
"""A part of a path: one point starts it, two go straight, four are a cubic curve; the first is where the one before ended."""


@dataclass(frozen=True)
class DrawnPath:
    """A path; ``kind`` names the symbol that it is or is part of. Colours are ``#rrggbb``, None for none; widths in points."""

    kind: str
    segments: tuple[Segment, ...]
    stroke: str | None = None
    fill: str | None = None
    width: float = 0.0
    dashes: tuple[float, ...] = ()
    closed: bool = False

    def corners(self) -> Iterable[Point]:
        """Points around it: a curve lies within its own."""
        return (point for segment in self.segments for point in segment)


@dataclass(frozen=True)
class DrawnText:
    """A line of text with its baseline at ``at``; ``anchor`` is start, middle or end."""

    kind: str
    at: Point
    text: str
    size: float
    ink: str = "#1d1d1f"
    bold: bool = False
    anchor: str = "start"

    def corners(self) -> Iterable[Point]:
        """The corners of the box around it."""
        from folding_server.instructions.lettering import text_width

        width = text_width(self.text, self.size, bold=self.bold)
        left = self.at[0] - {"start": 0.0, "middle": width / 2, "end": width}[self.anchor]
        return (left, self.at[1] - 0.76 * self.size), (left + width, self.at[1] + 0.24 * self.size)


@dataclass(frozen=True)
class DrawnPhoto:
    """A JPEG that fills a box (left, top, right, bottom)."""

    kind: str
    box: Box
    jpeg: bytes

    def corners(self) -> Iterable[Point]:
        """Two corners of it."""
        return self.box[:2], self.box[2:]


Drawn = DrawnPath | DrawnText | DrawnPhoto


def polyline(points: Sequence[Point]) -> tuple[Segment, ...]:
    """The segments of a path through points."""
    return ((points[0],), *pairwise(points))


def bounds_of(drawn: Iterable[Drawn]) -> Box:
    """The box around what is drawn, lines taken as thin."""
    corners = [corner for each in drawn for corner in each.corners()]
    xs, ys = [x for x, _ in corners], [y for _, y in corners]
    return min(xs), min(ys), max(xs), max(ys)
