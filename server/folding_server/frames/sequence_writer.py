"""Writes a sequence folder from a video or photos: keyframes, images between them, manifest, and a contact sheet."""

import os
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from folding_server.errors import PhotoError
from folding_server.frames.films import open_film
from folding_server.frames.filmstrip import MAX_STRIP_IMAGES
from folding_server.frames.image_supply import ImageSupply
from folding_server.frames.keyframes import STILL_SECONDS, VideoProgress, keyframe_proposal
from folding_server.frames.sequence_folder import (
    CONTACT_SHEET,
    NOTHING_DECLARED,
    DeclaredSheet,
    fill_folder,
    require_colors,
    require_images,
)


@dataclass(frozen=True)
class KeyframesReport:
    """What was written: the sequence folder, its keyframes by index and second, those of them at which something is ``moving``,
    and the contact sheet.
    """

    folder: Path
    keyframes: tuple[int, ...]
    seconds: tuple[float, ...]
    contact_sheet: Path
    moving: tuple[int, ...] = ()


def keyframes_command(
    video: Path,
    out: Path,
    *,
    indices: Sequence[int] | None = None,
    still_seconds: float = STILL_SECONDS,
    paper: DeclaredSheet = NOTHING_DECLARED,
    progress: VideoProgress | None = None,
) -> KeyframesReport:
    """Propose keyframes of `video`, or take `indices`; write the sequence folder `out` and a contact sheet.

    Raises PhotoError for a broken video, an index outside it, a colour that is not known, and an `out` that
    cannot be written or holds something already.
    """
    _require_free(out)
    require_colors(paper)
    if indices is not None:
        return write_sequence(video, out, indices, paper=paper)
    found = keyframe_proposal(video, still_seconds, progress)
    return write_sequence(video, out, found.indices, moving=found.moving, paper=paper)


def write_sequence(
    video: Path,
    folder: Path,
    indices: Sequence[int],
    *,
    between: int = MAX_STRIP_IMAGES,
    moving: Sequence[int] = (),
    paper: DeclaredSheet = NOTHING_DECLARED,
) -> KeyframesReport:
    """Write `folder` as a sequence whose keyframes are the images `indices` of `video`, increasing; at those
    `moving` something moves.

    Between two keyframes up to `between` evenly spaced images are written too. The folder appears complete or
    not at all. Raises PhotoError for wrong indices, wrong colours, or a folder that cannot be written or holds
    something already.
    """
    _require_free(folder)
    require_colors(paper)
    clip = open_film(video)
    require_images(clip, indices)
    told = replace(paper, name=paper.name or video.stem)
    try:
        _make(folder, clip, indices, between, moving, told)
    except OSError as error:
        raise PhotoError(f"{folder} cannot be written ({error.strerror}): name another folder") from error
    seconds = tuple(clip.times[index] for index in indices)
    return KeyframesReport(folder, tuple(indices), seconds, folder / CONTACT_SHEET, tuple(moving))


def _make(
    folder: Path,
    clip: ImageSupply,
    indices: Sequence[int],
    between: int,
    moving: Sequence[int],
    paper: DeclaredSheet,
) -> None:
    """Write the folder beside its place and put it there."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    making = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    try:
        fill_folder(making, clip, indices, between=between, moving=moving, paper=paper)
        _settle(making, folder)
    finally:
        shutil.rmtree(making, ignore_errors=True)


def _require_free(folder: Path) -> None:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise PhotoError(f"{folder} already holds something: name a new or empty folder")
    above = next(parent for parent in folder.absolute().parents if parent.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        raise PhotoError(f"{folder} cannot be written, since {above} cannot: name another folder")


def _settle(making: Path, folder: Path) -> None:
    """Put the finished folder in its place."""
    if folder.exists():
        folder.rmdir()
    making.chmod(0o755)
    making.rename(folder)
