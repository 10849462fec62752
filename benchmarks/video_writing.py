"""Writing videos with a camera that is known: its rate, its clock, its codec, which way it was held."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import cast

import av
import numpy as np
from av.video.stream import VideoStream
from folding_server.arrays import RgbImage


@dataclass(frozen=True)
class Camera:
    """How a clip is taken: pictures a second (or repeating steps in milliseconds), size, grain, flicker.

    `nudged` is the second from which on the camera stands a little elsewhere.
    """

    rate: int = 20
    steps: tuple[int, ...] = ()
    width: int = 320
    height: int = 240
    grain: float = 2.0
    flicker: float = 0.02
    turned: int = 0
    nudged: float = np.inf
    codec: str = "libx264"


def encode(path: Path, frames: Iterator[RgbImage], times: Sequence[float], camera: Camera = Camera()) -> None:
    """Write `frames` shown at `times` (seconds) as a video."""
    with av.open(str(path), "w") as container:
        stream = cast("VideoStream", container.add_stream(camera.codec, rate=camera.rate))
        stream.pix_fmt = "yuv420p"
        stream.codec_context.time_base = Fraction(1, 1000)
        stream.codec_context.gop_size = 25
        if camera.turned:
            stream.set_display_rotation(camera.turned)
        for frame, time in zip(frames, times, strict=True):
            picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), "rgb24")
            if not stream.codec_context.is_open:
                stream.width, stream.height = picture.width, picture.height
            picture.pts, picture.time_base = round(time * 1000), Fraction(1, 1000)
            container.mux(stream.encode(picture))
        container.mux(stream.encode())
