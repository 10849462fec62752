"""Several diagrams in one picture, each with a caption: the steps of a program as a strip or grid."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from folding_schemas.actions import Action, AddVertex, Flip, Fold, Program, Rotate, Unfold

from folding_server.diagram.colors import DEFAULT_COLORS, Colors, Palette, colors_of, palette
from folding_server.diagram.drawing import FONT, draw_body, svg_document
from folding_server.diagram.view import centred_view
from folding_server.errors import ProgramError
from folding_server.simulator.paper import Paper, new_paper

CAPTION_LINE = 17
CAPTION_SIZE = 12.5
GAP = 6


@dataclass(frozen=True)
class Panel:
    """One state and the lines of text under it."""

    paper: Paper
    caption: tuple[str, ...] = ()


def draw_program_strip(
    program: Program, colors: Colors | None = None, columns: int | None = None, panel_size: int = 240
) -> str:
    """The keyframes of a program from the flat sheet on, captioned with the actions that lead to each.

    The colours are the program's own unless given. ActionRefused if the program cannot be folded.
    """
    from folding_server.simulator import apply

    paper = new_paper(program.sheet)
    panels = [Panel(paper, ("start",))]
    for step in program.steps:
        for action in step:
            paper = apply(paper, action)
        panels.append(Panel(paper, tuple(describe_action(action) for action in step)))
    return draw_panels_svg(
        panels, colors or colors_of(program.front_color, program.back_color), columns, panel_size
    )


def draw_panels_svg(
    panels: Sequence[Panel],
    colors: Colors = DEFAULT_COLORS,
    columns: int | None = None,
    panel_size: int = 240,
    labels: bool = False,
) -> str:
    """The panels in rows of ``columns`` (all in one row if None), at one scale, each ``panel_size`` pixels square."""
    if not panels:
        raise ProgramError("There is nothing to draw: give at least one state.")
    inks = palette(colors)
    across = min(columns or len(panels), len(panels))
    body: list[str] = []
    y = GAP
    for first in range(0, len(panels), across):
        row = panels[first : first + across]
        for column, panel in enumerate(row):
            corner = (GAP + column * (panel_size + GAP), y)
            body += _draw_panel(panel, first + column + 1, inks, panel_size, labels, corner)
        y += panel_size + GAP + 8 + CAPTION_LINE * max(len(panel.caption) for panel in row)
    return svg_document(GAP + across * (panel_size + GAP), y, "#ffffff", body)


def describe_action(action: Action) -> str:
    """An action in a few words, as a caption."""
    match action:
        case AddVertex(edge=edge, position=position):
            return f"vertex on {edge[0]}-{edge[1]} at {position:.3g}"
        case Fold(edge=edge, direction=direction):
            return f"fold {edge[0]}-{edge[1]}, {'+' if direction > 0 else '-'} side"
        case Unfold(edge=crease):
            return f"unfold {crease[0]}-{crease[1]}" if crease else "unfold"
        case Rotate(angle=angle):
            return f"rotate {angle:g}°"
        case Flip(axis=axis):
            return f"flip {axis}"


def _draw_panel(
    panel: Panel, number: int, inks: Palette, size: int, labels: bool, corner: tuple[int, int]
) -> list[str]:
    x, y = corner
    captions = [
        f'<text x="{size / 2:g}" y="{size + 4 + (i + 0.8) * CAPTION_LINE:.1f}" font-family="{FONT}" '
        f'font-size="{CAPTION_SIZE}" text-anchor="middle" fill="#333333">{escape(line)}</text>'
        for i, line in enumerate(panel.caption)
    ]
    return [
        f'<g transform="translate({x:g} {y:g})">',
        f'<rect width="{size}" height="{size}" fill="{inks.table}"/>',
        *draw_body(panel.paper, inks, centred_view(panel.paper, size), labels),
        f'<text x="8" y="20" font-family="{FONT}" font-size="{CAPTION_SIZE}" fill="#444444">{number}</text>',
        *captions,
        "</g>",
    ]
