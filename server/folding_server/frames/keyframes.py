"""Proposes the keyframes of a video: the paper lies still, has changed, and no hand is near if possible."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from folding_server.errors import PhotoError
from folding_server.frames.hand_detection import HandlessScene, handless_scene
from folding_server.frames.stillness import Still, StillSpans, still_spans
from folding_server.frames.video import Video, VideoImage, open_video

WATCHED_SIDE = 256
RATE = 15.0
STILL_SECONDS = 0.4
HELD_SECONDS = 1.0
"""How long hands must rest for a moment with hands in the picture to count as a keyframe of its own."""
CHANGED_PART = 0.001

VideoProgress = Callable[[float], None]
"""Told the part of the video seen so far, 0 to 1."""


def propose_keyframes(
    video: Path, still_seconds: float = STILL_SECONDS, progress: VideoProgress | None = None
) -> list[int]:
    """Indices of the images of `video` in which the paper lies still and has changed since the one before.

    A moment with a hand over the border gives way to one without, if that shows the same paper; otherwise it
    counts when the hand rests for a second. Raises PhotoError if the video cannot be read or never rests.
    """
    clip = open_video(video)
    watched = still_spans(_told(clip, clip.moments(WATCHED_SIDE, RATE), progress), still_seconds)
    if not watched.stills:
        raise PhotoError(
            f"nothing in {video.name} lies still for {still_seconds:g} seconds: "
            "allow shorter rests or name the images"
        )
    return [still.index for still in choose(watched)]


def choose(watched: StillSpans) -> list[Still]:
    """The still spans that show new states of the paper, in order; at least one span must be given.

    A state is shown by a span without hands if the film has one. One with hands counts where the paper plainly
    differs from what the spans without hands before and after it show.
    """
    scene = handless_scene(watched)
    least = CHANGED_PART * scene.table.shape[0] * scene.table.shape[1]
    chosen: list[Still] = []
    held: list[Still] = []
    for still, free in zip(watched.stills, scene.free, strict=True):
        if free:
            hidden = _hidden_states(scene, least, chosen[-1:], held, [still])
            if hidden or not chosen or scene.changed(chosen[-1].picture, still.picture, least, free=True):
                chosen += [*hidden, still]
            held = []
        elif still.seconds >= HELD_SECONDS or not chosen:
            held.append(still)
    return chosen + _hidden_states(scene, least, chosen[-1:], held, [])


def _hidden_states(
    scene: HandlessScene, least: float, before: list[Still], held: list[Still], after: list[Still]
) -> list[Still]:
    """Of the spans `held` under hands those that show states of their own, the least covered one for each.

    `before` and `after` hold the neighbours without hands, if there are any.
    """
    found: list[Still] = []
    for still in held:
        if all(_differ(scene, least, other, still) for other in (found or before)[-1:]):
            found.append(still)
        elif found and scene.covered(still.picture) < scene.covered(found[-1].picture):
            found[-1] = still
    while found and after and not _differ(scene, least, found[-1], after[0]):
        found.pop()
    return found


def _differ(scene: HandlessScene, least: float, first: Still, second: Still) -> bool:
    """Whether two spans, hands in them or not, show different papers."""
    return scene.changed(first.picture, second.picture, least, free=False)


def _told(clip: Video, moments: Iterable[VideoImage], progress: VideoProgress | None) -> Iterator[VideoImage]:
    """The moments as they come, with `progress` told about each."""
    last = max(clip.times[-1], 1e-9)
    for moment in moments:
        if progress is not None:
            progress(float(np.clip(moment.seconds / last, 0.0, 1.0)))
        yield moment
