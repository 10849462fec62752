"""What a sequence folder holds, written from images of any kind: keyframes, images between them, manifest, contact sheet."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from folding_server.errors import PhotoError
from folding_server.frames.color_names import color_rgb
from folding_server.frames.contact_sheet import contact_sheet, fewer_images
from folding_server.frames.filmstrip import MAX_STRIP_IMAGES, evenly_spaced
from folding_server.frames.image_files import encode_jpeg, encode_png
from folding_server.frames.image_supply import ImageSupply
from folding_server.frames.manifest import FILE_NAME
from folding_server.frames.sequences import load_sequence

CONTACT_SHEET = "contact_sheet.png"
_QUALITY = 93
_SHEET_TILES = 240

PartDone = Callable[[float], None]
"""Told the part of the work that is done, 0 to 1."""


@dataclass(frozen=True)
class DeclaredSheet:
    """What a manifest tells about the sheet; None is left out."""

    name: str | None = None
    front_color: str | None = None
    back_color: str | None = None


NOTHING_DECLARED = DeclaredSheet()


def fill_folder(
    folder: Path,
    images: ImageSupply,
    indices: Sequence[int],
    *,
    between: int = MAX_STRIP_IMAGES,
    around: Sequence[int] = (),
    moving: Sequence[int] = (),
    paper: DeclaredSheet = NOTHING_DECLARED,
    progress: PartDone | None = None,
) -> list[int]:
    """Write into an empty folder everything that a sequence holds, and read it back as a sequence to be sure of it.

    Keyframes of which something is ``moving`` are told as such. Images ``around`` come before the first keyframe or after the last; they are for the contact sheet alone. The indices of
    all images written. Raises PhotoError for an image that cannot be read, OSError where the folder
    cannot be written; it is then the caller's to remove.
    """
    frames = folder / "frames"
    frames.mkdir()
    (folder / FILE_NAME).write_text(manifest_text(indices, paper, moving=moving), encoding="utf-8")
    wanted = sorted({*_with_between(indices, between), *around})
    for count, moment in enumerate(images.read_each(wanted), start=1):
        (frames / f"{moment.index:06d}.jpg").write_bytes(encode_jpeg(moment.image, _QUALITY).data)
        if progress is not None:
            progress(count / len(wanted))
    load_sequence(folder)
    shown = fewer_images(indices, wanted, _SHEET_TILES)
    sheet = contact_sheet(frames, indices, shown, images.label, moving=moving)
    (folder / CONTACT_SHEET).write_bytes(encode_png(sheet).data)
    return wanted


def manifest_text(
    indices: Sequence[int], paper: DeclaredSheet, frames: str = "frames", moving: Sequence[int] = ()
) -> str:
    """The text of a manifest whose images lie in the folder ``frames``; at those ``moving`` something moves."""
    content = {
        "name": paper.name,
        "frames": frames,
        "front_color": paper.front_color,
        "back_color": paper.back_color,
        "keyframes": list(indices),
        "moving": list(moving) or None,
    }
    told = {key: value for key, value in content.items() if value is not None}
    return json.dumps(told, indent=1, ensure_ascii=False) + "\n"


def _with_between(indices: Sequence[int], between: int) -> list[int]:
    """The indices and up to `between` evenly spaced ones in each gap."""
    gaps = pairwise(indices)
    inner = [index for start, end in gaps for index in evenly_spaced(range(start + 1, end), between)]
    return sorted([*indices, *inner])


def require_images(images: ImageSupply, indices: Sequence[int]) -> None:
    """Raise PhotoError unless the indices increase and each is there."""
    _require_increasing(indices)
    images.files(indices)


def _require_increasing(indices: Sequence[int]) -> None:
    if not indices:
        raise PhotoError("no keyframes are named: give at least one index of an image")
    for before, after in pairwise(indices):
        if after <= before:
            raise PhotoError(f"keyframes must increase, but {after} comes after {before}")


def require_colors(paper: DeclaredSheet) -> None:
    """Raise PhotoError for a colour that is not known."""
    for color in (paper.front_color, paper.back_color):
        if color is not None:
            color_rgb(color)
