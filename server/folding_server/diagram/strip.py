"""Several diagrams in one picture, each with a caption: the steps of a program as a strip or grid."""

from collections.abc import Sequence
from dataclasses import dataclass

from folding_schemas.actions import Action, AddVertex, Flip, Fold, Program, Rotate, Unfold

from folding_server.diagram.drawing import draw_body
from folding_server.diagram.palette import DEFAULT_COLORS, Colors, DiagramColors, colors_of, diagram_colors
from folding_server.diagram.svg import svg_document, svg_text
from folding_server.diagram.view import centred_view
from folding_server.errors import ProgramError
from folding_server.simulator import Paper, apply, new_paper

CAPTION_LINE = 17
CAPTION_SIZE = 12.5
PANEL_GAP = 6


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
    """The panels in rows of ``columns`` (one row if None), all at one scale; ``panel_size`` is in pixels."""
    if not panels:
        raise ProgramError("There is nothing to draw: give at least one state.")
    inks = diagram_colors(colors)
    across = min(columns or len(panels), len(panels))
    body: list[str] = []
    y = PANEL_GAP
    for first in range(0, len(panels), across):
        row = panels[first : first + across]
        for column, panel in enumerate(row):
            corner = (PANEL_GAP + column * (panel_size + PANEL_GAP), y)
            body += _draw_panel(panel, first + column + 1, inks, panel_size, labels, corner)
        y += panel_size + PANEL_GAP + 8 + CAPTION_LINE * max(len(panel.caption) for panel in row)
    return svg_document(PANEL_GAP + across * (panel_size + PANEL_GAP), y, "#ffffff", body)


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
    panel: Panel, number: int, inks: DiagramColors, size: int, labels: bool, corner: tuple[int, int]
) -> list[str]:
    x, y = corner
    captions = [
        svg_text(
            size / 2,
            size + 4 + (i + 0.8) * CAPTION_LINE,
            line,
            CAPTION_SIZE,
            "#333333",
            'text-anchor="middle"',
        )
        for i, line in enumerate(panel.caption)
    ]
    return [
        f'<g transform="translate({x:g} {y:g})">',
        f'<rect width="{size}" height="{size}" fill="{inks.table}"/>',
        *draw_body(panel.paper, inks, centred_view(panel.paper, size), labels),
        svg_text(8, 20, str(number), CAPTION_SIZE, "#444444"),
        *captions,
        "</g>",
    ]
