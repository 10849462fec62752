"""Proposes the keyframes of a folding video: still moments, hands off where they ever are, the paper changed."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from folding_server.errors import PhotoError
from folding_server.frames.differences import border_ring, difference, regions, usual
from folding_server.frames.stillness import Still, Watched, watch
from folding_server.frames.video import Moment, Video, open_video

SIDE = 256
RATE = 15.0
STILL_SECONDS = 0.4
HELD_SECONDS = 1.0
"""How long hands must rest for a moment with hands in the picture to count as a keyframe of its own."""
CHANGED_PART = 0.001
TOUCHED_PART = 0.02
_BORDER_SAMPLES = 120

Progress = Callable[[float], None]
"""Told the part of the video seen so far, 0 to 1."""


def propose_keyframes(
    video: Path, still_seconds: float = STILL_SECONDS, progress: Progress | None = None
) -> list[int]:
    """Indices of the images of `video` in which the paper lies still and has changed since the one before.

    A moment with a hand over the border gives way to one without, if that shows the same paper; otherwise it counts
    when the hand rests for a second. Raises PhotoError if the video cannot be read or never comes to rest.
    """
    clip = open_video(video)
    watched = watch(_told(clip, clip.moments(SIDE, RATE), progress), still_seconds)
    if not watched.stills:
        raise PhotoError(
            f"nothing in {video.name} lies still for {still_seconds:g} seconds: allow shorter rests or name the images"
        )
    return [still.index for still in choose(watched)]


def choose(watched: Watched) -> list[Still]:
    """The still spans that show new states of the paper, in order."""
    chosen: list[tuple[Still, bool]] = []
    for still, free in zip(watched.stills, _hands_free(watched), strict=True):
        if not free and still.seconds < HELD_SECONDS and chosen:
            continue
        if not chosen or _changed(*chosen[-1], still, free):
            chosen.append((still, free))
        elif free and not chosen[-1][1]:
            chosen[-1] = still, free
    return [still for still, _ in chosen]


def _hands_free(watched: Watched) -> list[bool]:
    """For each span, whether the border of its picture looks as it mostly does."""
    picture = watched.stills[0].picture
    ring = border_ring(picture.shape)
    step = -(-len(watched.border) // _BORDER_SAMPLES)
    bare = usual(watched.border[::step])[None]
    parts = [float(difference(bare, still.picture[ring][None]).mean()) for still in watched.stills]
    return [part < TOUCHED_PART for part in parts]


def _changed(before: Still, before_free: bool, after: Still, after_free: bool) -> bool:
    """Whether the paper differs; differences that reach the border are hands if either span has some."""
    height, width = after.picture.shape[:2]
    ring = None if before_free and after_free else border_ring(after.picture.shape)
    return regions(difference(before.picture, after.picture), CHANGED_PART * height * width, ring) > 0


def _told(clip: Video, moments: Iterable[Moment], progress: Progress | None) -> Iterator[Moment]:
    """The moments as they come, with `progress` told about each."""
    last = max(clip.times[-1], 1e-9)
    for moment in moments:
        if progress is not None:
            progress(float(np.clip(moment.seconds / last, 0.0, 1.0)))
        yield moment
