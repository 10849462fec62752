"""A run's photos for the page: small, seen from above, each filling the square in which the states are drawn."""

import base64
from collections.abc import Iterable
from typing import TYPE_CHECKING

from folding_server.errors import PhotoError
from folding_server.view.stops import ViewWindow

if TYPE_CHECKING:
    from folding_server.arrays import RgbImage
    from folding_server.frames.sequences import Sequence
    from folding_server.vision.pose import Pose

PHOTO_SIDE = 480
"""Side of a photo in pixels: about as large as the page shows it."""

MOST_PHOTO_BYTES = 24_000
"""The most bytes of one photo, before base64."""

ALL_PHOTO_BYTES = 240_000
"""The most bytes of all photos together, before base64 adds a third: what the states leave of 800 kB."""


LEAST_PHOTO_BYTES = 2000
"""Fewer bytes show nothing, and the smallest JPEG that is made takes up to 1400: of more photos the last are shown."""


def photos_of(sequence: "Sequence", frames: Iterable[int], window: ViewWindow) -> dict[int, str]:
    """The photos of the keyframes as data URLs; a frame the sequence does not have, or cannot read, is left out.

    They are rectified with the sheet of frame 1, so that they lie under the states as these are drawn; where
    that photo shows no sheet, they are shown as they were taken. Of very many the first are left out.
    """
    known = [frame for frame in sorted(set(frames)) if frame <= sequence.frame_count]
    wanted = known[-(ALL_PHOTO_BYTES // LEAST_PHOTO_BYTES) :]
    pose = _pose(sequence)
    most = min(MOST_PHOTO_BYTES, ALL_PHOTO_BYTES // max(1, len(wanted)))
    found: dict[int, str] = {}
    for frame in wanted:
        try:
            found[frame] = _data_url(_seen_from_above(sequence.photo(frame), pose, window), most)
        except PhotoError:
            continue
    return found


def _pose(sequence: "Sequence") -> "Pose | None":
    """Where the sheet lies in the first photo; None if it shows none."""
    from folding_server.vision.pose import pose_of  # loads OpenCV
    from folding_server.vision.square import find_square

    try:
        return pose_of(find_square(sequence.photo(1), f"Frame 1 of {sequence.name}"))
    except PhotoError:
        return None


def _seen_from_above(photo: "RgbImage", pose: "Pose | None", window: ViewWindow) -> "RgbImage":
    from folding_server.vision.grid import Grid

    if pose is None:
        return photo
    left, bottom, side = window
    grid = Grid(left, bottom + side, PHOTO_SIDE / side, PHOTO_SIDE, PHOTO_SIDE)
    return pose.rectify(photo, grid)[0]


def _data_url(rgb: "RgbImage", most: int) -> str:
    from folding_server.frames.image_files import encode_for_model

    picture = encode_for_model(rgb, PHOTO_SIDE, most)
    return f"data:{picture.mime};base64,{base64.b64encode(picture.data).decode('ascii')}"
