"""The stillest moments of a film in which nothing ever rests: of every second, the image at which least moves."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from folding_server.frames.film_image import VideoImage
from folding_server.frames.image_differences import SmallImage, changed_pixels, soften
from folding_server.frames.stillness import MOVING_STEP, Still

APART_SECONDS = 1.0
"""Of each stretch of so many seconds one moment is looked at: a fold by a quick hand takes about as long."""
MOST_MOMENTS = 200
"""Stretches are longer in films that would have more: 500 keyframes at most, and 40 MB of pictures."""
CALM_PART = 0.6
"""A moment counts as still if at most this part moves of what moves at the film's usual moment."""


@dataclass
class MotionWatch:
    """Watches a film of ``seconds`` go by, and keeps of each stretch the image at which least moves."""

    seconds: float
    _calmest: dict[int, tuple[float, VideoImage]] = field(default_factory=dict)
    _motions: list[float] = field(default_factory=list)

    def over(self, moments: Iterable[VideoImage]) -> Iterator[VideoImage]:
        """The moments as they come; each is compared with the one before it and the one after."""
        before: tuple[VideoImage, SmallImage] | None = None
        came: float | None = None
        for moment in moments:
            picture = soften(moment.image)
            if before is not None:
                goes = float(changed_pixels(before[1], picture, MOVING_STEP).mean())
                self._see(before[0], goes + (goes if came is None else came))
                came = goes
            before = moment, picture
            yield moment

    def stillest(self) -> list[Still]:
        """The calmest moments, each a stretch away from calmer ones, where less moves than usually; as spans so long."""
        usual = float(np.median(self._motions)) if self._motions else 0.0
        chosen: list[VideoImage] = []
        for motion, moment in sorted(self._calmest.values(), key=lambda each: each[0]):
            near = any(abs(moment.seconds - other.seconds) < self._apart for other in chosen)
            if motion <= CALM_PART * usual and not near:
                chosen.append(moment)
        return [_span(moment, self._apart) for moment in sorted(chosen, key=lambda each: each.seconds)]

    @property
    def _apart(self) -> float:
        return max(APART_SECONDS, self.seconds / MOST_MOMENTS)

    def _see(self, moment: VideoImage, motion: float) -> None:
        self._motions.append(motion)
        stretch = int(moment.seconds / self._apart)
        if stretch not in self._calmest or motion < self._calmest[stretch][0]:
            self._calmest[stretch] = motion, moment


def _span(moment: VideoImage, seconds: float) -> Still:
    start = moment.seconds - seconds / 2
    return Still(moment.index, start, start + seconds, soften(moment.image))
