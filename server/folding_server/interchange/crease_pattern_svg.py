"""The crease pattern as SVG: mountain red dash-dotted, valley blue dashed, edge black, mark grey."""

from collections.abc import Sequence
from dataclasses import dataclass

from folding_server.diagram.svg import svg_document, svg_text
from folding_server.geometry.line import Point
from folding_server.simulator.foldability import CreasePattern

PATTERN_MARGIN = 0.06
LEGEND_HEIGHT = 40


@dataclass(frozen=True)
class LineStyle:
    """How the edges of one assignment look; widths and dashes are in pixels of a picture 768 pixels wide."""

    name: str
    color: str
    width: float
    dashes: str | None


STYLES = {
    "F": LineStyle("mark", "#9a9a9a", 1.4, None),
    "U": LineStyle("unassigned", "#b070c8", 1.8, "2 4"),
    "V": LineStyle("valley", "#1f5fd0", 2.0, "10 6"),
    "M": LineStyle("mountain", "#d02a2a", 2.0, "12 5 2 5"),
    "B": LineStyle("edge", "#000000", 2.4, None),
}
"""By assignment, in the order in which they are drawn: what matters most comes last."""


def crease_pattern_svg(
    pattern: CreasePattern,
    size: int = 768,
    *,
    legend: bool = False,
    marked: Sequence[tuple[Point, Point]] = (),
    mark: str = "",
) -> str:
    """The pattern seen from its front, ``size`` pixels wide, with a legend below if asked for.

    ``marked`` are stretches of it that are drawn below its lines, with the attributes ``mark``.
    """
    xs, ys = zip(*pattern.vertices_coords, strict=True)
    span = max(max(xs) - min(xs), max(ys) - min(ys))
    scale, border = size * (1 - 2 * PATTERN_MARGIN) / span, size * PATTERN_MARGIN
    height = (max(ys) - min(ys)) * scale + 2 * border
    stretches = "".join(
        "M"
        + "L".join(
            f"{border + (x - min(xs)) * scale:.2f} {border + (max(ys) - y) * scale:.2f}" for x, y in ends
        )
        for ends in marked
    )
    body = [f'<path d="{stretches}" {mark}/>'] if stretches else []
    for assignment, style in STYLES.items():
        path = "".join(
            "M"
            + "L".join(
                f"{border + (x - min(xs)) * scale:.2f} {border + (max(ys) - y) * scale:.2f}"
                for x, y in (pattern.vertices_coords[u], pattern.vertices_coords[v])
            )
            for (u, v), assigned in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
            if assigned == assignment
        )
        if path:
            body.append(f'<path class="{style.name}" d="{path}" {_stroke(style, size / 768)}/>')
    if legend:
        body += _legend(
            sorted(set(pattern.edges_assignment), key=list(STYLES).index, reverse=True), size, height
        )
    full = height + (LEGEND_HEIGHT * size / 768 if legend else 0)
    return svg_document(size, full, "#ffffff", body)


def _stroke(style: LineStyle, unit: float) -> str:
    dashes = ""
    if style.dashes:
        dashes = (
            ' stroke-dasharray="' + " ".join(f"{float(d) * unit:.2f}" for d in style.dashes.split()) + '"'
        )
    return f'fill="none" stroke="{style.color}" stroke-width="{style.width * unit:.2f}"{dashes}'


def _legend(assignments: list[str], size: int, top: float) -> list[str]:
    """A sample of each kind of line in the pattern with its name."""
    unit = size / 768
    drawn = []
    for i, assignment in enumerate(assignments):
        style, x, y = STYLES[assignment], size * PATTERN_MARGIN + i * 140 * unit, top + 8 * unit
        drawn.append(f'<path d="M{x:.1f} {y:.1f}L{x + 48 * unit:.1f} {y:.1f}" {_stroke(style, unit)}/>')
        drawn.append(svg_text(x + 56 * unit, y + 5 * unit, style.name, 14 * unit, "#222222"))
    return drawn
