"""Filmstrips: what happened between two keyframes, as a few images side by side."""

from collections.abc import Sequence

from folding_server.frames.image_files import MAX_BYTES, Picture, Rgb, encode_for_model
from folding_server.frames.panels import side_by_side

MAX_IMAGES = 5
WIDTH = 2000
HEIGHT = 640


def evenly_spaced(items: Sequence[int], count: int) -> list[int]:
    """At most `count` of `items`, evenly spaced and clear of both ends where there are enough."""
    if len(items) <= count:
        return list(items)
    step = (len(items) + 1) / (count + 1)
    return [items[round(step * (place + 1)) - 1] for place in range(count)]


def filmstrip(images: Sequence[Rgb], captions: Sequence[str], caption: str) -> Picture:
    """`images` side by side under their captions as one picture of at most 590 kB, told by `caption`."""
    strip = side_by_side(images, captions, WIDTH, HEIGHT)
    return encode_for_model(strip, WIDTH, MAX_BYTES, caption)
