"""The contact sheet of a sequence: its keyframes, framed in red, among images between them, each under its number."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

from folding_server.arrays import RgbImage
from folding_server.frames.filmstrip import MAX_STRIP_IMAGES, evenly_spaced
from folding_server.frames.image_files import decode
from folding_server.frames.panels import MAX_SIDE, Tile, wrapped

_TILE_SIDE = 400


def contact_sheet(
    images: Path,
    keyframes: Sequence[int],
    shown: Sequence[int],
    label: Callable[[int], str],
    max_side: int = MAX_SIDE,
    moving: Sequence[int] = (),
) -> RgbImage:
    """The images ``shown`` of the folder ``images``, ``000012.jpg`` and so on; those that are keyframes are framed in red.

    ``label`` tells what stands over an image; "moving" is said besides of keyframes at which something moves. No side of the picture is longer than ``max_side`` pixels.
    """
    numbers = {index: frame for frame, index in enumerate(keyframes, start=1)}
    tiles = []
    for index in shown:
        caption = label(index)
        if index in numbers:
            caption = f"frame {numbers[index]}: {caption}{' moving' if index in moving else ''}"
        image = decode(images / f"{index:06d}.jpg", _TILE_SIDE)
        tiles.append(Tile(image, caption, marked=index in numbers))
    return wrapped(tiles, max_side)


def fewer_images(keyframes: Sequence[int], written: Sequence[int], most: int) -> list[int]:
    """The keyframes and as many of the images ``written`` between and around them as make at most ``most``, evenly spaced.

    All keyframes are shown, also where they are more.
    """
    if len(written) <= most:
        return list(written)
    for between in range(MAX_STRIP_IMAGES, 0, -1):
        shown = _with_inner(keyframes, written, between)
        if len(shown) <= most:
            return shown
    return list(keyframes)


def _with_inner(keyframes: Sequence[int], written: Sequence[int], between: int) -> list[int]:
    gaps = pairwise([-1, *keyframes, written[-1] + 1])
    inner = [
        index
        for start, end in gaps
        for index in evenly_spaced([each for each in written if start < each < end], between)
    ]
    return sorted([*keyframes, *inner])
