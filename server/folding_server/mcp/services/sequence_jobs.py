"""Making a sequence as work for a worker process: the film or the photos are looked through, the folder is written."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from folding_server.errors import PhotoError

if TYPE_CHECKING:
    from folding_server.frames.image_files import EncodedImage
    from folding_server.frames.sequence_building import BuiltSequence, SequenceMaterial
    from folding_server.frames.sequence_folder import DeclaredSheet
    from folding_server.workers.job import Announce

MOST_TILES = 72
"""How many images the contact sheet of an answer has, unless there are more keyframes: their numbers stay readable."""

SHEET_SIDE = 1568
"""Pixels of that sheet's longer side: what Claude's models scale larger pictures down to."""

GLANCE_SIDE = 512
"""Pixels of the longer side at which all photos are looked at for their brightness."""

MOST_WARNINGS = 5
"""Sentences of warning in an answer: whoever's photos are all dark need not be told of each."""

LOOKING_THROUGH = "looking through the images"


@dataclass(frozen=True)
class SequenceWork:
    """What a sequence is made of, with which keyframes, if they are given; ``sheet`` says its name and colours.

    The contact sheet is drawn where it is ``shown``. ``still_seconds`` is the shortest rest of a keyframe, if that is given.
    """

    material: "SequenceMaterial"
    keyframes: tuple[int, ...] | None
    sheet: "DeclaredSheet"
    shown: bool
    still_seconds: float | None = None


@dataclass(frozen=True)
class MadeSequence:
    """What was written, its contact sheet if that is shown, and sentences about what speaks against its photos."""

    built: "BuiltSequence"
    contact_sheet: "EncodedImage | None"
    warnings: tuple[str, ...] = ()


def make_sequence(announce: "Announce", work: SequenceWork, folder: Path) -> MadeSequence:
    """Write a sequence into an empty folder. PhotoError if a file cannot be read, a keyframe is not there, or the disk is full."""
    from folding_server.frames.sequence_building import build_sequence  # noqa: PLC0415  (loads numpy and Pillow)

    told = -1

    def progress(part: float) -> None:
        nonlocal told
        if int(100 * part) > told:
            told = int(100 * part)
            announce(LOOKING_THROUGH, part)

    with writing_sequences():
        built = build_sequence(
            work.material, work.keyframes, work.sheet, folder, progress, work.still_seconds
        )
        sheet = _contact_sheet(built, folder / "frames") if work.shown else None
        return MadeSequence(built, sheet, _warnings(folder))


def _warnings(folder: Path) -> tuple[str, ...]:
    """What speaks against the photos of a sequence: all that can be told of the first, and which others are too dark."""
    from folding_server.frames.sequences import load_sequence  # noqa: PLC0415  (loads Pillow)
    from folding_server.vision.photo_doubts import darkness, doubts_about_start  # noqa: PLC0415  (loads OpenCV)

    photos = load_sequence(folder)
    said = doubts_about_start(photos).words
    for frame in range(2, photos.frame_count + 1):
        small = photos.source.read(photos.index(frame), GLANCE_SIDE)
        said += filter(None, [darkness(small, f"the photo of frame {frame}")])
    return tuple(said[:MOST_WARNINGS])


@contextmanager
def writing_sequences() -> Iterator[None]:
    """PhotoError, without a path, where the disk does not take what is written."""
    try:
        yield
    except OSError as error:
        raise PhotoError(
            f"the sequence could not be kept ({error.strerror or 'the disk cannot be written'}), and nothing was changed: "
            "make room on the server's disk and call again"
        ) from error


def _contact_sheet(built: "BuiltSequence", images: Path) -> "EncodedImage":
    """The keyframes, framed in red, among images between them, each under its number."""
    from folding_server.frames.contact_sheet import contact_sheet, fewer_images  # noqa: PLC0415
    from folding_server.frames.image_files import encode_for_model  # noqa: PLC0415

    shown = fewer_images(built.keyframes, list(built.labels), MOST_TILES)
    sheet = contact_sheet(images, built.keyframes, shown, built.labels.__getitem__, SHEET_SIDE, built.moving)
    return encode_for_model(sheet, SHEET_SIDE)
