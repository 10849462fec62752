"""A crease pattern with its faults marked: rings at places, bands along creases and outlines at fault, joined ends in green."""

from collections.abc import Iterable

import numpy as np

from folding_server.arrays import Floats
from folding_server.diagram.svg import svg_text
from folding_server.interchange.crease_pattern_svg import PATTERN_MARGIN, crease_pattern_svg
from folding_server.simulator.foldability import CreasePattern, Fault, FilePlace

SIZE = 768
FAULT_COLOR, JOINED_COLOR = "#e07000", "#0a8a3a"
RING = 11
"""Radius of a ring in pixels."""
NUMBERED = 99
"""Places that get a number beside their ring; more would cover the pattern."""


def marked_svg(pattern: CreasePattern, faults: Iterable[Fault]) -> str:
    """The drawing of a pattern with a number at each fault, in the order in which they are listed."""
    page = _Page(pattern)
    body = []
    for number, fault in enumerate(faults, 1):
        body += [page.band(line) for line in fault.lines]
        body += [page.ring(place, number) for place in fault.places]
    for end in pattern.joined:
        body.append(page.dot(end.after))
    drawn = crease_pattern_svg(pattern, SIZE, legend=True)
    return drawn.replace("</svg>", "\n".join([*body, "</svg>"]))


class _Page:
    """Where the drawing of a pattern has places of its file."""

    def __init__(self, pattern: CreasePattern) -> None:
        self.pattern = pattern
        points = np.array(pattern.vertices_coords, float)
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        self.border = SIZE * PATTERN_MARGIN
        self.scale = SIZE * (1 - 2 * PATTERN_MARGIN) / float((self.high - self.low).max() or 1.0)

    def on_page(self, point: Floats) -> tuple[float, float]:
        """Pixels of a point of the sheet."""
        return (
            self.border + float(point[0] - self.low[0]) * self.scale,
            self.border + float(self.high[1] - point[1]) * self.scale,
        )

    def of_place(self, place: FilePlace) -> tuple[float, float]:
        """Pixels of a place of the file."""
        axes = self.pattern.axes
        if axes is None:
            return self.on_page(np.array(place[:2]))
        away = np.array(place) - np.array(axes.origin)
        return self.on_page(np.array([away @ np.array(axes.right), away @ np.array(axes.up)]))

    def ring(self, place: FilePlace, number: int) -> str:
        """A ring with a number beside it."""
        x, y = self.of_place(place)
        ring = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{RING}" fill="none" stroke="{FAULT_COLOR}" stroke-width="3"/>'
        if number > NUMBERED:
            return ring
        left = x > SIZE - 3 * RING
        anchor = 'text-anchor="end"' if left else ""
        return ring + svg_text(
            x + (-RING - 3 if left else RING + 3), y - RING + 3, str(number), 15, FAULT_COLOR, anchor
        )

    def band(self, line: tuple[FilePlace, FilePlace]) -> str:
        """A broad line along a crease."""
        (x1, y1), (x2, y2) = map(self.of_place, line)
        return (
            f'<path d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}" fill="none" stroke="{FAULT_COLOR}" stroke-width="9" '
            'stroke-opacity="0.35"/>'
        )

    def dot(self, point: tuple[float, float]) -> str:
        """A ring where an end was joined."""
        x, y = self.on_page(np.array(point))
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{RING / 2:g}" fill="none" stroke="{JOINED_COLOR}" stroke-width="3"/>'
