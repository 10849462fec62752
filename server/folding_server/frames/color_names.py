"""Colours of paper as people write them: a CSS name, a few names for paper, or #rrggbb."""

import re

from PIL import ImageColor

from folding_server.errors import PhotoError

PAPER_NAMES = {
    "cream": "#fffdd0",
    "offwhite": "#faf9f6",
    "kraft": "#b5915f",
    "lightbrown": "#b5824c",
    "darkyellow": "#c9a300",
    "lightred": "#ff7f7f",
    "lightpurple": "#c9a0dc",
    "darkpurple": "#4b1d6b",
    "darkpink": "#e75480",
    "brightgreen": "#3fd13f",
    "brightred": "#f03020",
}
_HEX = re.compile(r"#[0-9a-f]{6}")
_SPACING = re.compile(r"[\s_-]+")


def color_rgb(color: str) -> tuple[int, int, int]:
    """Red, green and blue (0 to 255) of a colour: #rrggbb, or a name such as 'red' or 'light blue'.

    Raises PhotoError for anything else.
    """
    plain = _SPACING.sub("", color).lower()
    if plain in ImageColor.colormap:
        red, green, blue = ImageColor.getrgb(plain)[:3]
        return red, green, blue
    written = PAPER_NAMES.get(plain, plain)
    if not _HEX.fullmatch(written):
        raise PhotoError(
            f"the colour {color!r} is not known: write it as #rrggbb, "
            "or as a plain name such as 'red' or 'light blue'"
        )
    red, green, blue = bytes.fromhex(written[1:])
    return red, green, blue
