"""The colours of a diagram: the two sides of the paper, the table behind it, and ink that shows on each."""

import re
from dataclasses import dataclass

from folding_server.errors import ProgramError

RGB = tuple[int, int, int]

PAPER_SHADES = {
    "white": "#fbfaf5",
    "black": "#2b2b2e",
    "gray": "#8f9297",
    "grey": "#8f9297",
    "red": "#d9503f",
    "orange": "#ef8e3b",
    "yellow": "#f4cf4d",
    "green": "#57a05b",
    "blue": "#4a7fc6",
    "purple": "#8a63b0",
    "pink": "#f0a3b8",
    "brown": "#9a6b45",
}
"""Plain colour names as paper usually has them; every other name is read as CSS defines it."""

TABLE_GREYS = ("#d2d2d2", "#a4a4a4", "#e8e8e8")
INKS = ("#1d1d1f", "#f4f4f4")


@dataclass(frozen=True)
class Colors:
    """Front and back of the sheet, each a colour name or ``#rrggbb``."""

    front: str = "#d9503f"
    back: str = "#fbfaf5"


DEFAULT_COLORS = Colors()


@dataclass(frozen=True)
class DiagramColors:
    """The colours a diagram is drawn in, all ``#rrggbb``: sheet sides, ink on each of them, and the table."""

    front: str
    back: str
    front_ink: str
    back_ink: str
    table: str


def diagram_colors(colors: Colors) -> DiagramColors:
    """Ink and table grey such that both sides of the paper stand out. ProgramError for an unknown colour."""
    front, back = hex_color(colors.front), hex_color(colors.back)
    return DiagramColors(front, back, _ink_on(front), _ink_on(back), _table_behind(front, back))


def colors_of(front: str | None, back: str | None) -> Colors:
    """Colours with the defaults in place of what is not given."""
    return Colors(front or DEFAULT_COLORS.front, back or DEFAULT_COLORS.back)


def hex_color(color: str) -> str:
    """A colour name or code as ``#rrggbb``. ProgramError if it is neither."""
    name = re.sub(r"[\s_-]+", "", color.strip().lower())
    if name in PAPER_SHADES:
        return PAPER_SHADES[name]
    if re.fullmatch(r"#?[0-9a-f]{6}", name):
        return "#" + name.removeprefix("#")
    return _css_color(name, color)


def _css_color(name: str, given: str) -> str:
    from PIL import ImageColor

    try:
        red, green, blue = ImageColor.getrgb(name)[:3]
    except ValueError:
        raise ProgramError(
            f"{given!r} is not a colour; give a name such as 'red' or 'light blue', or a code such as "
            "'#d9503f'."
        ) from None
    return f"#{red:02x}{green:02x}{blue:02x}"


def _channels(color: str) -> RGB:
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)


def _luminance(color: str) -> float:
    """Relative luminance, 0 to 1 (WCAG 2.1, with a plain gamma of 2.2)."""
    red, green, blue = (float((value / 255) ** 2.2) for value in _channels(color))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(first: str, second: str) -> float:
    """Contrast ratio of two colours, 1 to 21 (WCAG 2.1)."""
    bright, dark = sorted((_luminance(first), _luminance(second)), reverse=True)
    return (bright + 0.05) / (dark + 0.05)


def _ink_on(color: str) -> str:
    """Dark ink wherever it can be read, so that most diagrams have one ink."""
    dark, light = INKS
    return dark if contrast(dark, color) >= 3 else light


def _table_behind(front: str, back: str) -> str:
    """The first grey clearly apart from both sides, or else the one furthest from the nearer side."""

    def nearest(grey: str) -> float:
        return min(
            sum(abs(a - b) for a, b in zip(_channels(grey), _channels(c), strict=True)) for c in (front, back)
        )

    return next((grey for grey in TABLE_GREYS if nearest(grey) >= 75), max(TABLE_GREYS, key=nearest))
