"""Pictures made of pictures: captioned tiles side by side, in a table, or as columns that wrap."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError

PAPER = (255, 255, 255)
INK = (30, 30, 30)
ACCENT = (176, 42, 32)
TILE_GAP = 6
MAX_SIDE = 2000
MAX_TILE = 768
MIN_CELL = 24
MIN_TEXT = 9
DOTS = ".."

Font = ImageFont.FreeTypeFont | ImageFont.ImageFont


class Size(NamedTuple):
    """Width and height in pixels."""

    width: int
    height: int


LIMIT = Size(MAX_SIDE, MAX_SIDE)


@dataclass(frozen=True)
class Tile:
    """One image, RGB of shape (height, width, 3), with a caption above it; `marked` frames it in red."""

    image: RgbImage
    caption: str = ""
    marked: bool = False


def side_by_side(
    images: Sequence[RgbImage], captions: Sequence[str], max_width: int = MAX_SIDE, max_height: int = MAX_TILE
) -> RgbImage:
    """`images` in one row, scaled to one height, each under its caption.

    The row is at most `max_width` wide and its images at most `max_height` high.
    """
    return table([_tiles(images, captions)], Size(max_width, max_height + 64))


def columns(
    photos: Sequence[RgbImage],
    diagrams: Sequence[RgbImage],
    captions: Sequence[str],
    max_side: int = MAX_SIDE,
) -> RgbImage:
    """Photos above, diagrams below, a caption over each column; columns wrap where that makes them larger.

    The three lists have the same length, from 1. No side of the panel is longer than `max_side`.
    """
    tops, bottoms = _tiles(photos, captions), _tiles(diagrams, [""] * len(diagrams))
    if len(tops) != len(bottoms):
        raise ValueError(f"{len(tops)} photos but {len(bottoms)} diagrams")
    per_band = _best_wrap(len(tops), 2, _aspect([*tops, *bottoms]), max_side)
    starts = range(0, len(tops), per_band)
    rows = [part[start : start + per_band] for start in starts for part in (tops, bottoms)]
    return table(rows, Size(max_side, max_side))


def wrapped(tiles: Sequence[Tile], max_side: int = MAX_SIDE) -> RgbImage:
    """`tiles` in reading order, in as many rows as make them largest within a square of `max_side`."""
    per_row = _best_wrap(len(tiles), 1, _aspect(tiles), max_side)
    rows = [tiles[start : start + per_row] for start in range(0, len(tiles), per_row)]
    return table(rows, Size(max_side, max_side))


def table(rows: Sequence[Sequence[Tile]], limit: Size = LIMIT) -> RgbImage:
    """Tiles in rows, all cells of one size, within `limit`; images keep their shape, centred in their cell.

    Raises PhotoError when there are so many tiles that a cell would be smaller than 24 pixels.
    """
    every = [tile for row in rows for tile in row]
    if not every:
        raise ValueError("a panel needs at least one image")
    bars = [any(tile.caption for tile in row) for row in rows]
    cell, bar = _cell(max(map(len, rows)), bars, _aspect(every), limit)
    canvas = Image.new("RGB", _canvas(max(map(len, rows)), bars, cell, bar), PAPER)
    top = TILE_GAP
    for row, has_bar in zip(rows, bars, strict=True):
        top += bar if has_bar else 0
        for column, tile in enumerate(row):
            _draw(canvas, tile, Size(TILE_GAP + column * (cell.width + TILE_GAP), top), cell, bar)
        top += cell.height + TILE_GAP
    return np.asarray(canvas)


def _tiles(images: Sequence[RgbImage], captions: Sequence[str]) -> list[Tile]:
    return [Tile(image, caption) for image, caption in zip(images, captions, strict=True)]


def _aspect(tiles: Sequence[Tile]) -> float:
    """The usual width over height of the tiles."""
    return float(np.median([tile.image.shape[1] / tile.image.shape[0] for tile in tiles])) if tiles else 1.0


def _bar_height(cell_width: int) -> int:
    return max(16, min(30, cell_width // 10 + 8))


def _cell(across: int, bars: Sequence[bool], aspect: float, limit: Size) -> tuple[Size, int]:
    """The largest cell that lets the table fit, and the height of a caption bar over it."""
    width = min((limit.width - TILE_GAP * (across + 1)) // across, round(MAX_TILE * max(1.0, aspect)))
    bar = _bar_height(width)
    free = limit.height - TILE_GAP * (len(bars) + 1) - bar * sum(bars)
    height = min(free // len(bars), round(width / aspect), MAX_TILE)
    cell = Size(min(width, round(height * aspect)), height)
    if min(cell) < MIN_CELL:
        raise PhotoError(f"{across} by {len(bars)} images do not fit one picture: ask for fewer")
    return cell, bar


def _canvas(across: int, bars: Sequence[bool], cell: Size, bar: int) -> Size:
    return Size(
        across * (cell.width + TILE_GAP) + TILE_GAP,
        len(bars) * (cell.height + TILE_GAP) + TILE_GAP + bar * sum(bars),
    )


def _best_wrap(count: int, rows_a_band: int, aspect: float, max_side: int) -> int:
    """How many columns to put in a band so that cells are as large as they can be."""
    wraps = {bands: -(-count // bands) for bands in range(1, count + 1)}
    widths = {
        bands: min(
            (max_side - TILE_GAP) / across - TILE_GAP,
            ((max_side - TILE_GAP - 30 * bands) / (bands * rows_a_band) - TILE_GAP) * aspect,
        )
        for bands, across in wraps.items()
    }
    return wraps[max(widths, key=lambda bands: (widths[bands], -bands))]


def _draw(canvas: Image.Image, tile: Tile, corner: Size, cell: Size, bar: int) -> None:
    """Put one tile, its caption in the bar above, at `corner` of the canvas."""
    image = _fit(Image.fromarray(tile.image), cell)
    left = corner.width + (cell.width - image.width) // 2
    top = corner.height + (cell.height - image.height) // 2
    canvas.paste(image, (left, top))
    pen = ImageDraw.Draw(canvas)
    if tile.marked:
        pen.rectangle(
            (left - 3, top - 3, left + image.width + 2, top + image.height + 2), outline=ACCENT, width=3
        )
    if tile.caption:
        text, font = _fit_text(tile.caption, cell.width, bar)
        ink = ACCENT if tile.marked else INK
        pen.text((corner.width + cell.width / 2, corner.height - bar / 2 - 1), text, ink, font, anchor="mm")


def _fit(image: Image.Image, cell: Size) -> Image.Image:
    factor = min(cell.width / image.width, cell.height / image.height)
    size = max(1, round(image.width * factor)), max(1, round(image.height * factor))
    return image.resize(size, Image.Resampling.LANCZOS, reducing_gap=2.0)


def _fit_text(text: str, width: int, bar: int) -> tuple[str, Font]:
    """`text` in the largest size that fits `width`, cut short with dots if the smallest does not."""
    size = max(MIN_TEXT, round(bar * 0.66))
    font: Font = ImageFont.load_default(size)
    while font.getlength(text) > width and size > MIN_TEXT:
        size -= 1
        font = ImageFont.load_default(size)
    while font.getlength(text) > width and len(text) > len(DOTS) + 1:
        text = text[: -len(DOTS) - 1] + DOTS
    return text, font
