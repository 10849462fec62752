"""Text on a sheet: how wide it is in the packaged fonts, and where its lines break."""

from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from folding_server.diagram.rasterise import COVERED

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

MEASURED_AT = 100
"""Size in pixels at which the packaged fonts are measured: widths grow with the size."""


def font_file(*, bold: bool) -> Path:
    """A packaged font."""
    return Path(str(files("folding_server.diagram") / "fonts" / f"DejaVuSans{'-Bold' if bold else ''}.ttf"))


def text_width(text: str, size: float, *, bold: bool = False) -> float:
    """How wide a line is in points. Letters that the packaged fonts lack are as wide as high."""
    known = "".join(letter for letter in text if letter <= COVERED)
    return size * (_font(bold).getlength(known) / MEASURED_AT + len(text) - len(known))


def broken_lines(text: str, size: float, width: float) -> list[str]:
    """The text in lines no wider than ``width`` points; broken between words, or where there are no spaces between letters."""
    lines = [""]
    for word in _words(text):
        if lines[-1] and text_width((lines[-1] + word).rstrip(), size) > width:
            lines[-1] = lines[-1].rstrip()
            lines.append(word.lstrip())
        else:
            lines[-1] += word
    return [line.rstrip() for line in lines]


NEVER_FIRST = "、。」°\uff09\uff1a"
"""Signs of Japanese that may not begin a line."""


def _words(text: str) -> list[str]:
    """Pieces between which a line may break, with the spaces after them."""
    words = [""]
    for letter in text:
        wide = letter > COVERED and letter not in NEVER_FIRST
        if words[-1] and (wide or (words[-1][-1] == " " and letter != " ")):
            words.append(letter)
        else:
            words[-1] += letter
    return words


@cache
def _font(bold: bool) -> "FreeTypeFont":
    from PIL import ImageFont

    return ImageFont.truetype(str(font_file(bold=bold)), MEASURED_AT)
