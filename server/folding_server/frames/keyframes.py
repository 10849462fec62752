"""Proposes the keyframes of a video: the paper lies still, has changed, and no hand is near if possible."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.frames.animated_pictures import AnimatedPicture
from folding_server.frames.film_image import FilmReader, VideoImage
from folding_server.frames.films import open_film
from folding_server.frames.hand_detection import HandlessScene, handless_scene
from folding_server.frames.stillest_moments import MotionWatch
from folding_server.frames.stillness import Still, StillSpans, still_spans

WATCHED_SIDE = 256
RATE = 15.0
STILL_SECONDS = 0.4
"""How long everything must rest for a keyframe, unless another time is asked for."""
STILL_RANGE = (0.1, 10.0)
"""The shortest rests that may be asked for: two images at RATE, and longer than anybody waits between two folds."""
FEWEST_STATES = 2
"""States that a film of a folding shows at least: the flat sheet, and the paper after a step."""
HELD_SECONDS = 1.0
"""How long hands must rest for a moment with hands in the picture to count as a keyframe of its own."""
CHANGED_PART = 0.001

VideoProgress = Callable[[float], None]
"""Told the part of the video seen so far, 0 to 1."""


@dataclass(frozen=True)
class KeyframeProposal:
    """Indices of images; ``moving`` are those at which something still moves, where the film never rests."""

    indices: tuple[int, ...]
    moving: tuple[int, ...] = ()


def propose_keyframes(
    video: Path, still_seconds: float = STILL_SECONDS, progress: VideoProgress | None = None
) -> list[int]:
    """The indices of ``keyframe_proposal``."""
    return list(keyframe_proposal(video, still_seconds, progress).indices)


def keyframe_proposal(
    video: Path, still_seconds: float = STILL_SECONDS, progress: VideoProgress | None = None
) -> KeyframeProposal:
    """The images of `video` in which the paper lies still for so long and has changed since the one before.

    A moment with a hand over the border gives way to one without, if that shows the same paper; otherwise it
    counts when the hand rests for a second. Of an animated picture whose every image rests, each is one. Where no two states rest,
    as hands never leave, the stillest moments are taken, and told as ``moving``. Raises PhotoError if
    the video cannot be read, or nothing in it is ever even that still.
    """
    check_still_seconds(still_seconds)
    clip = open_film(video)
    if isinstance(clip, AnimatedPicture) and clip.rests(still_seconds):
        return KeyframeProposal(tuple(_different_images(clip)))
    watch = MotionWatch(clip.times[-1])
    watched = still_spans(watch.over(_told(clip, clip.moments(WATCHED_SIDE, RATE), progress)), still_seconds)
    rests = [still.index for still in choose(watched)] if watched.stills else []
    if len(rests) >= FEWEST_STATES:
        return KeyframeProposal(tuple(rests))
    calm = watch.stillest()
    found = [still.index for still in choose(StillSpans(calm, watched.border))] if calm else []
    if len(found) > len(rests):
        return KeyframeProposal(tuple(found), tuple(found))
    if not rests:
        raise PhotoError(
            f"nothing in {video.name} lies still for {still_seconds:g} seconds: "
            "allow shorter rests or name the images"
        )
    return KeyframeProposal(tuple(rests))


def check_still_seconds(seconds: float) -> None:
    """Raise PhotoError for a shortest rest that cannot be looked for."""
    low, high = STILL_RANGE
    if not low <= seconds <= high:
        raise PhotoError(
            f"a shortest rest of {seconds:g} seconds cannot be looked for: give {low:g} to {high:g}, or leave it out for "
            f"{STILL_SECONDS:g}"
        )


def _different_images(clip: AnimatedPicture) -> Iterator[int]:
    """The images of a series that differ from the one before."""
    before: RgbImage | None = None
    for moment in clip.read_each(clip.indices(), WATCHED_SIDE):
        if before is None or not np.array_equal(before, moment.image):
            yield moment.index
        before = moment.image


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


def _told(
    clip: FilmReader, moments: Iterable[VideoImage], progress: VideoProgress | None
) -> Iterator[VideoImage]:
    """The moments as they come, with `progress` told about each."""
    last = max(clip.times[-1], 1e-9)
    for moment in moments:
        if progress is not None:
            progress(float(np.clip(moment.seconds / last, 0.0, 1.0)))
        yield moment
