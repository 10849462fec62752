"""What the lines of a drawing are by their colour: red mountains, blue valleys, black edges."""

import colorsys

from folding_server.simulator.foldability import Assignment

GREY = 0.25
"""Saturation below which a colour is a shade of grey."""
BLACK_BELOW = 0.35
"""Brightness below which a shade of grey, or any colour of half of it, is black."""
HUES: tuple[tuple[float, float, Assignment], ...] = (
    (0, 25, "M"),
    (190, 262, "V"),
    (262, 330, "U"),
    (330, 360, "M"),
)
"""Degrees from, to, letter: red, blue, purple (a crease of no direction); the other hues are marks."""


def letter_of_color(red: int, green: int, blue: int) -> Assignment:
    """The assignment of a line of a colour (0 to 255): black an edge, red a mountain, blue a valley, purple unassigned,
    anything else, such as grey or yellow, a mark.
    """
    hue, saturation, value = colorsys.rgb_to_hsv(red / 255, green / 255, blue / 255)
    if value < BLACK_BELOW / 2 or (saturation < GREY and value < BLACK_BELOW):
        return "B"
    if saturation < GREY:
        return "F"
    return next((letter for low, high, letter in HUES if low <= hue * 360 < high), "F")
