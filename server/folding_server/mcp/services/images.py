"""The pictures that several tools show: diagrams of papers, and panels made of photos and diagrams."""

from collections.abc import Sequence as ListOf
from typing import TYPE_CHECKING, Protocol

from folding_server.simulator import Paper

if TYPE_CHECKING:
    from folding_server.arrays import RgbImage
    from folding_server.frames.image_files import EncodedImage
    from folding_server.frames.sequences import Sequence

DIAGRAM_SIZE = 768
"""Side of a diagram in pixels."""

SMALL_SIZE = 480
"""Side in pixels of a diagram among others."""

PHOTO_BESIDE_OTHERS = 180_000
"""The most bytes of a photo that travels with other pictures."""


class TwoSided(Protocol):
    """What has the colours of a sheet, such as a run; None where they are not told."""

    @property
    def front_color(self) -> str | None:
        """The colour of the front."""
        ...

    @property
    def back_color(self) -> str | None:
        """The colour of the back."""
        ...


def diagram_svg(run: TwoSided, paper: Paper, *, labels: bool = False, size: int = DIAGRAM_SIZE) -> str:
    """A paper in the colours of its run, as SVG."""
    from folding_server.diagram.drawing import draw_svg  # noqa: PLC0415  (loads shapely)
    from folding_server.diagram.palette import colors_of  # noqa: PLC0415

    return draw_svg(paper, colors_of(run.front_color, run.back_color), labels, size)


def diagram(run: TwoSided, paper: Paper, *, labels: bool = False, size: int = DIAGRAM_SIZE) -> "EncodedImage":
    """A paper in the colours of its run, as PNG."""
    from folding_server.diagram.rasterise import rasterise  # noqa: PLC0415
    from folding_server.frames.image_files import EncodedImage  # noqa: PLC0415

    png = rasterise(diagram_svg(run, paper, labels=labels, size=size), size)
    return EncodedImage(png, "image/png", size, size)


def photo_beside_others(photos: "Sequence", frame: int) -> "EncodedImage":
    """A keyframe's photo, small enough to travel with three more pictures.

    PhotoError if there is no such frame.
    """
    from folding_server.frames.image_files import MODEL_SIDE, encode_for_model  # noqa: PLC0415

    pixels = photos.source.read(photos.index(frame), MODEL_SIDE)
    return encode_for_model(pixels, MODEL_SIDE, PHOTO_BESIDE_OTHERS)


def overview(
    photos: ListOf["RgbImage"], diagrams: ListOf["EncodedImage | None"], captions: ListOf[str]
) -> "EncodedImage":
    """Photos above, diagrams below (blank where there is none), as one JPEG that a model can read."""
    from folding_server.frames.image_files import encode_for_model  # noqa: PLC0415
    from folding_server.frames.panels import columns  # noqa: PLC0415

    panel = columns(photos, [_pixels(drawn) for drawn in diagrams], captions)
    return encode_for_model(panel, max(panel.shape))


def half_size(image: "EncodedImage") -> "EncodedImage":
    """The same picture, half as wide and high, in the same format."""
    from folding_server.frames.image_files import (  # noqa: PLC0415
        decode_bytes,
        encode_for_model,
        encode_png,
        scale_to,
    )

    half = max(image.width, image.height) // 2
    pixels = scale_to(decode_bytes(image.data, "the picture"), half)
    if image.mime == "image/png":
        return encode_png(pixels, image.caption)
    return encode_for_model(pixels, half, caption=image.caption)


def _pixels(drawn: "EncodedImage | None") -> "RgbImage":
    """The pixels of a diagram; a light blank where there is none."""
    import numpy as np  # noqa: PLC0415

    from folding_server.frames.image_files import decode_bytes  # noqa: PLC0415

    if drawn is None:
        return np.full((SMALL_SIZE, SMALL_SIZE, 3), 245, dtype=np.uint8)
    return decode_bytes(drawn.data, "the diagram")
