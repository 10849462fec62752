"""How the table plane is laid on a picture: one scale for all steps, so that diagrams can be compared."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import hypot

from folding_server.geometry.line import Point
from folding_server.simulator.paper import Paper

REFERENCE_SIZE = 768
"""The picture size in pixels at which line widths and label sizes are stated."""

VIEW_MARGIN = 0.07
"""Free border, as a fraction of the picture's side."""


@dataclass(frozen=True)
class View:
    """A square picture of ``size`` pixels with the point ``center`` in its middle; pixel y points down."""

    size: float
    pixels_per_unit: float
    center: Point

    def pixel(self, point: Point) -> Point:
        """Where a point of the table plane lies in the picture."""
        return self.pixels((point,))[0]

    def pixels(self, points: Iterable[Point]) -> list[Point]:
        """Where points of the table plane lie in the picture."""
        half, scale, (left, low) = self.size / 2, self.pixels_per_unit, self.center
        return [(half + (x - left) * scale, half - (y - low) * scale) for x, y in points]


def steady_view(papers: Iterable[Paper], size: float) -> View:
    """The view for one state of a run, or for several states side by side.

    The scale depends on the sheet alone: its diagonal fits between the margins. Folding never makes a sheet
    wider than its diagonal, so every state fits at this scale. The picture is centred where the flat sheet
    started, and shifts only as far as it must to keep the paper between the margins.
    """
    states = list(papers)
    width, height = states[0].sheet
    reach = hypot(width, height) / 2
    points = [point for paper in states for point in paper.folded_vertices_coords.values()]
    center = (
        _shifted(width / 2, reach, [x for x, _ in points]),
        _shifted(height / 2, reach, [y for _, y in points]),
    )
    span = max(max(abs(x - center[0]), abs(y - center[1])) for x, y in points)
    return View(size, (1 - 2 * VIEW_MARGIN) * size / (2 * max(reach, span)), center)


def centred_view(paper: Paper, size: float) -> View:
    """The view at the same scale with the paper in the middle, for pictures that stand by themselves."""
    xs, ys = zip(*paper.folded_vertices_coords.values(), strict=True)
    center = (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2
    return View(size, steady_view([paper], size).pixels_per_unit, center)


def _shifted(middle: float, reach: float, values: list[float]) -> float:
    """The centre nearest to ``middle`` from which all values are within reach (their midpoint if none is)."""
    low, high = max(values) - reach, min(values) + reach
    if low > high:
        return (low + high) / 2
    return min(max(middle, low), high)
