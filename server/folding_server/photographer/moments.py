"""When the images of a sequence are taken: at the keyframes, and at times in between."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from folding_server.errors import PhotoError
from folding_server.photographer.pinhole_camera import Matrix
from folding_server.photographer.rng import stream

MOST_BETWEEN = 30
"""Images that can be asked for between two keyframes."""
UNEVEN = 0.3
"""How far from evenly spaced images in between are, as a part of the space between them."""
_KEYFRAMES = 1 << 32


@dataclass(frozen=True)
class Moment:
    """``keyframe`` (from 0) was the last; ``image`` is 0 for that itself, else the number of the image after it.

    ``share`` of the way to the next keyframe, from 0 to 1, has gone by.
    """

    keyframe: int
    image: int = 0
    share: float = 0.0

    @property
    def number(self) -> int:
        """What tells the moment from all others of the sequence; the keyframe's own number for keyframes."""
        return self.keyframe + _KEYFRAMES * self.image


def moments(seed: int, keyframes: int, between: int) -> Iterator[Moment]:
    """All moments in order, with ``between`` images after each keyframe but the last."""
    for keyframe in range(keyframes):
        yield Moment(keyframe)
        if keyframe < keyframes - 1:
            early = stream(seed, "pace", keyframe).uniform(-UNEVEN, UNEVEN, between)
            for image in range(1, between + 1):
                yield Moment(keyframe, image, float(image + early[image - 1]) / (between + 1))


def checked_between(between: int) -> int:
    """The number itself. PhotoError if there cannot be so many images between two keyframes."""
    if not 0 <= between <= MOST_BETWEEN:
        raise PhotoError(f"There cannot be {between} images between two keyframes; give 0 to {MOST_BETWEEN}.")
    return between


def frame_jitter(seed: int, purpose: str, moment: Moment) -> Matrix:
    """Three standard normal numbers at each keyframe, and between keyframes what lies between theirs."""
    here = stream(seed, purpose, moment.keyframe).normal(0, 1, 3)
    if moment.share == 0:
        return here
    there = stream(seed, purpose, moment.keyframe + 1).normal(0, 1, 3)
    return np.asarray(here + moment.share * (there - here))
