"""Diagrams of a folded sheet: exact visible regions, SVG, PNG, and strips of the steps of a program."""

from folding_server.diagram.drawing import draw_svg
from folding_server.diagram.palette import DEFAULT_COLORS, Colors
from folding_server.diagram.rasterise import rasterise
from folding_server.diagram.strip import Panel, draw_panels_svg, draw_program_strip

__all__ = [
    "DEFAULT_COLORS",
    "Colors",
    "Panel",
    "draw_panels_svg",
    "draw_program_strip",
    "draw_svg",
    "rasterise",
]
