"""Pictures in other sizes, for models that count their pixels, and joined to one, for models that take no more."""

import io
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

from folding_client.messages import Picture

_QUALITY = 90
JOINED_SIDE = 1568
"""Pixels of the longer side of a sheet: what Claude's models scale larger pictures down to."""
_LABEL, _GAP = 28, 8
"""Pixels of the line of text above each picture of a sheet, and between two."""
_KEPT = 64
"""Pictures kept in their smaller size: those of a few steps, which go out with every query of theirs."""


def in_its_resolution(picture: Picture) -> Picture:
    """A picture that is to be seen small with half the width and height, a quarter of the pixels; others as they are."""
    if picture.resolution != "small":
        return picture
    return replace(picture, data=_halved(picture.data), mime="image/jpeg")


@lru_cache(_KEPT)
def _halved(data: bytes) -> bytes:
    from PIL import Image

    with Image.open(io.BytesIO(data)) as image:
        half = image.convert("RGB").resize(
            (max(1, image.width // 2), max(1, image.height // 2)), Image.Resampling.LANCZOS
        )
    encoded = io.BytesIO()
    half.save(encoded, "JPEG", quality=_QUALITY)
    return encoded.getvalue()


def joined_sheet(pictures: Sequence[Picture]) -> Picture:
    """Pictures in one, in rows of at most two, each under its caption or what it shows."""
    from PIL import Image, ImageDraw, ImageFont

    columns = min(len(pictures), 2)
    rows = -(-len(pictures) // columns)
    side = (JOINED_SIDE - _GAP * (columns - 1)) // max(columns, rows)
    size = (columns * (side + _GAP) - _GAP, rows * (side + _LABEL + _GAP) - _GAP)
    sheet = Image.new("RGB", size, "white")
    drawing, font = ImageDraw.Draw(sheet), ImageFont.load_default(size=_LABEL * 2 // 3)
    for place, picture in enumerate(pictures):
        left, top = (place % columns) * (side + _GAP), (place // columns) * (side + _LABEL + _GAP)
        drawing.text((left, top), picture.caption or picture.subject, "black", font)
        with Image.open(io.BytesIO(picture.data)) as image:
            shown = image.convert("RGB")
        shown.thumbnail((side, side), Image.Resampling.LANCZOS)
        sheet.paste(shown, (left, top + _LABEL))
    encoded = io.BytesIO()
    sheet.save(encoded, "JPEG", quality=_QUALITY)
    subjects = "; ".join(picture.caption or picture.subject for picture in pictures)
    return Picture(encoded.getvalue(), "image/jpeg", subjects)
