"""Proposes the keyframes of a video: the paper lies still, has changed, and no hand is near if possible."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from folding_server.errors import PhotoError
from folding_server.frames.hands import know_scene
from folding_server.frames.stillness import Still, Watched, watch
from folding_server.frames.video import Moment, Video, open_video

SIDE = 256
RATE = 15.0
STILL_SECONDS = 0.4
HELD_SECONDS = 1.0
"""How long hands must rest for a moment with hands in the picture to count as a keyframe of its own."""
CHANGED_PART = 0.001

Progress = Callable[[float], None]
"""Told the part of the video seen so far, 0 to 1."""


def propose_keyframes(
    video: Path, still_seconds: float = STILL_SECONDS, progress: Progress | None = None
) -> list[int]:
    """Indices of the images of `video` in which the paper lies still and has changed since the one before.

    A moment with a hand over the border gives way to one without, if that shows the same paper; otherwise it
    counts when the hand rests for a second. Raises PhotoError if the video cannot be read or never rests.
    """
    clip = open_video(video)
    watched = watch(_told(clip, clip.moments(SIDE, RATE), progress), still_seconds)
    if not watched.stills:
        raise PhotoError(
            f"nothing in {video.name} lies still for {still_seconds:g} seconds: "
            "allow shorter rests or name the images"
        )
    return [still.index for still in choose(watched)]


def choose(watched: Watched) -> list[Still]:
    """The still spans that show new states of the paper, in order; at least one span must be given."""
    scene = know_scene(watched)
    least = CHANGED_PART * scene.table.shape[0] * scene.table.shape[1]
    chosen: list[tuple[Still, bool]] = []
    for still, free in zip(watched.stills, scene.free, strict=True):
        if not chosen:
            chosen.append((still, free))
        elif not free and still.seconds < HELD_SECONDS:
            continue
        elif scene.changed(chosen[-1][0].picture, still.picture, least, free=free and chosen[-1][1]):
            chosen.append((still, free))
        elif free and not chosen[-1][1]:
            chosen[-1] = still, free
    return [still for still, _ in chosen]


def _told(clip: Video, moments: Iterable[Moment], progress: Progress | None) -> Iterator[Moment]:
    """The moments as they come, with `progress` told about each."""
    last = max(clip.times[-1], 1e-9)
    for moment in moments:
        if progress is not None:
            progress(float(np.clip(moment.seconds / last, 0.0, 1.0)))
        yield moment
