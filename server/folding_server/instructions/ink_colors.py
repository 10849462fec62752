"""Colours for drawings that are printed: as light as black symbols need."""

from folding_server.diagram.palette import DiagramColors, contrast
from folding_server.instructions.symbols import LINE_INK

LEGIBLE = 7.0
"""Contrast of black lines with the paper, as WCAG 2.1 asks of text (level AAA)."""
WHITENING = 0.08
"""How much white is mixed in at a time."""


def printed(inks: DiagramColors) -> DiagramColors:
    """The same colours with so much white in them that black lines show on both sides of the paper."""
    return DiagramColors(_lightened(inks.front), _lightened(inks.back), LINE_INK, LINE_INK, "#ffffff")


def _lightened(color: str) -> str:
    channels = [int(color[i : i + 2], 16) for i in (1, 3, 5)]
    while contrast(color, LINE_INK) < LEGIBLE:
        channels = [round(channel + WHITENING * (255 - channel)) for channel in channels]
        color = "#" + "".join(f"{channel:02x}" for channel in channels)
    return color
