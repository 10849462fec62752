"""The moments of a video in which nothing moves."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from folding_server.arrays import Float32s
from folding_server.frames.film_image import VideoImage
from folding_server.frames.image_differences import (
    SmallImage,
    border_ring,
    changed_pixels,
    soften,
    solid_area,
)

MOVING_PART = 0.0012
"""The part of the picture that must change for something to be moving."""
MOVING_STEP = 16.0
"""How much a pixel must change, of 255, for that: coarse compression repaints still pictures by less."""
_RING_SECONDS = 0.5


@dataclass(frozen=True)
class Still:
    """A span without motion: its middle image's index, when it starts and ends, its mean picture."""

    index: int
    start: float
    end: float
    picture: SmallImage = field(repr=False, compare=False)

    @property
    def seconds(self) -> float:
        """How long it lasts."""
        return self.end - self.start


@dataclass(frozen=True)
class StillSpans:
    """A video seen once: its still spans, and samples of the picture's border, (count, pixels, 3)."""

    stills: list[Still]
    border: Float32s = field(repr=False, compare=False)


class _Span:
    """A still span in the making."""

    def __init__(self, moment: VideoImage, picture: SmallImage) -> None:
        self.first = self.last = picture
        self.sum = picture.astype(np.float64)
        self.seen = [(moment.seconds, moment.index)]

    def goes_on(self, picture: SmallImage) -> bool:
        """Whether nothing has moved since the last picture, nor crept away since the first."""
        least = MOVING_PART * picture.shape[0] * picture.shape[1]
        return not any(
            solid_area(changed_pixels(earlier, picture, MOVING_STEP), least)
            for earlier in (self.last, self.first)
        )

    def add(self, moment: VideoImage, picture: SmallImage) -> None:
        """Take one more picture into the span."""
        self.last = picture
        self.sum += picture
        self.seen.append((moment.seconds, moment.index))

    def still(self, end: float) -> Still:
        """The span as it stands when the next picture comes at `end`."""
        start = self.seen[0][0]
        middle = min(self.seen, key=lambda at: abs(at[0] - (start + self.seen[-1][0]) / 2))
        mean = (self.sum / len(self.seen)).astype(np.float32)
        return Still(middle[1], start, end, mean)


def still_spans(moments: Iterable[VideoImage], least_seconds: float) -> StillSpans:
    """The spans of at least `least_seconds` without motion; a picture counts until the next one comes.

    Only the span in the making and the means of finished ones are held in memory.
    """
    stills: list[Still] = []
    border: list[Float32s] = []
    span: _Span | None = None
    sampled = now = step = 0.0
    for moment in moments:
        picture = soften(moment.image)
        step, now = moment.seconds - now, moment.seconds
        if not border or now - sampled >= _RING_SECONDS:
            border.append(picture[border_ring(picture.shape)])
            sampled = now
        if span is not None and span.goes_on(picture):
            span.add(moment, picture)
            continue
        _keep(stills, span, now, least_seconds)
        span = _Span(moment, picture)
    _keep(stills, span, now + step, least_seconds)
    return StillSpans(stills, np.array(border, np.float32))


def _keep(stills: list[Still], span: _Span | None, end: float, least_seconds: float) -> None:
    """Add the finished span if it lasted long enough."""
    if span is None:
        return
    still = span.still(end)
    if still.seconds >= least_seconds - 1e-6:
        stills.append(still)
