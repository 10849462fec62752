"""Filmstrips: what happened between two keyframes, as a few images side by side."""

from collections.abc import Sequence

from folding_server.arrays import RgbImage
from folding_server.frames.image_files import MAX_ENCODED_BYTES, EncodedImage, encode_for_model
from folding_server.frames.panels import side_by_side

MAX_STRIP_IMAGES = 5
STRIP_WIDTH = 2000
STRIP_HEIGHT = 640


def evenly_spaced(items: Sequence[int], count: int) -> list[int]:
    """At most `count` of `items`, evenly spaced and clear of both ends where there are enough."""
    if len(items) <= count:
        return list(items)
    step = (len(items) + 1) / (count + 1)
    return [items[round(step * (place + 1)) - 1] for place in range(count)]


def filmstrip(images: Sequence[RgbImage], captions: Sequence[str], caption: str) -> EncodedImage:
    """`images` side by side under their captions as one picture of at most 590 kB, told by `caption`."""
    strip = side_by_side(images, captions, STRIP_WIDTH, STRIP_HEIGHT)
    return encode_for_model(strip, STRIP_WIDTH, MAX_ENCODED_BYTES, caption)
