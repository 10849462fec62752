"""Writes a sequence folder from a video: keyframes, images between them, manifest, and a contact sheet."""

import json
import os
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from folding_server.errors import PhotoError
from folding_server.frames.color_names import color_rgb
from folding_server.frames.filmstrip import MAX_STRIP_IMAGES, evenly_spaced
from folding_server.frames.image_files import decode, encode_jpeg, encode_png
from folding_server.frames.keyframes import STILL_SECONDS, VideoProgress, propose_keyframes
from folding_server.frames.manifest import FILE_NAME
from folding_server.frames.panels import Tile, wrapped
from folding_server.frames.sequences import load_sequence
from folding_server.frames.video import Video, open_video

CONTACT_SHEET = "contact_sheet.png"
_QUALITY = 93
_TILE_SIDE = 400
_SHEET_TILES = 240


@dataclass(frozen=True)
class KeyframesReport:
    """What was written: the sequence folder, its keyframes by index and second, and the contact sheet."""

    folder: Path
    keyframes: tuple[int, ...]
    seconds: tuple[float, ...]
    contact_sheet: Path


@dataclass(frozen=True)
class DeclaredSheet:
    """What a manifest tells about the sheet; None is left out."""

    name: str | None = None
    front_color: str | None = None
    back_color: str | None = None


NOTHING_DECLARED = DeclaredSheet()


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
    _require_known(paper)
    chosen = list(indices) if indices is not None else propose_keyframes(video, still_seconds, progress)
    return write_sequence(video, out, chosen, paper=paper)


def write_sequence(
    video: Path,
    folder: Path,
    indices: Sequence[int],
    *,
    between: int = MAX_STRIP_IMAGES,
    paper: DeclaredSheet = NOTHING_DECLARED,
) -> KeyframesReport:
    """Write `folder` as a sequence whose keyframes are the images `indices` of `video`, increasing.

    Between two keyframes up to `between` evenly spaced images are written too. The folder appears complete or
    not at all. Raises PhotoError for wrong indices, wrong colours, or a folder that cannot be written or holds
    something already.
    """
    _require_free(folder)
    _require_known(paper)
    clip = open_video(video)
    _require_increasing(indices)
    clip.files(indices)
    try:
        _make(folder, clip, indices, between, paper)
    except OSError as error:
        raise PhotoError(f"{folder} cannot be written ({error.strerror}): name another folder") from error
    seconds = tuple(clip.times[index] for index in indices)
    return KeyframesReport(folder, tuple(indices), seconds, folder / CONTACT_SHEET)


def _make(folder: Path, clip: Video, indices: Sequence[int], between: int, paper: DeclaredSheet) -> None:
    """Write the folder beside its place and put it there."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    making = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    try:
        _fill(making, clip, indices, between, paper)
        _settle(making, folder)
    finally:
        shutil.rmtree(making, ignore_errors=True)


def _fill(folder: Path, clip: Video, indices: Sequence[int], between: int, paper: DeclaredSheet) -> None:
    """Write everything a sequence folder holds, then read it back as a sequence to be sure of it."""
    frames = folder / "frames"
    frames.mkdir()
    (folder / FILE_NAME).write_text(_manifest(clip, indices, paper), encoding="utf-8")
    wanted = _with_between(indices, between)
    for moment in clip.read_each(wanted):
        (frames / f"{moment.index:06d}.jpg").write_bytes(encode_jpeg(moment.image, _QUALITY).data)
    load_sequence(folder)
    (folder / CONTACT_SHEET).write_bytes(_contact_sheet(frames, clip, indices, wanted))


def _manifest(clip: Video, indices: Sequence[int], paper: DeclaredSheet) -> str:
    content = {
        "name": paper.name or clip.path.stem,
        "frames": "frames",
        "front_color": paper.front_color,
        "back_color": paper.back_color,
        "keyframes": list(indices),
    }
    told = {key: value for key, value in content.items() if value is not None}
    return json.dumps(told, indent=1, ensure_ascii=False) + "\n"


def _with_between(indices: Sequence[int], between: int) -> list[int]:
    """The indices and up to `between` evenly spaced ones in each gap."""
    gaps = pairwise(indices)
    inner = [index for start, end in gaps for index in evenly_spaced(range(start + 1, end), between)]
    return sorted([*indices, *inner])


def _contact_sheet(frames: Path, clip: Video, indices: Sequence[int], wanted: Sequence[int]) -> bytes:
    """A PNG of the keyframes, framed in red, among the images between them as far as they fit."""
    shown = wanted if len(wanted) <= _SHEET_TILES else indices
    numbers = {index: frame for frame, index in enumerate(indices, start=1)}
    tiles = []
    for index in shown:
        caption = f"{index}  {_clock(clip.times[index])}"
        if index in numbers:
            caption = f"frame {numbers[index]}: {caption}"
        image = decode(frames / f"{index:06d}.jpg", _TILE_SIDE)
        tiles.append(Tile(image, caption, marked=index in numbers))
    return encode_png(wrapped(tiles)).data


def _clock(seconds: float) -> str:
    return f"{int(seconds // 60)}:{seconds % 60:04.1f}"


def _require_increasing(indices: Sequence[int]) -> None:
    if not indices:
        raise PhotoError("no keyframes are named: give at least one index of an image")
    for before, after in pairwise(indices):
        if after <= before:
            raise PhotoError(f"keyframes must increase, but {after} comes after {before}")


def _require_free(folder: Path) -> None:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise PhotoError(f"{folder} already holds something: name a new or empty folder")
    above = next(parent for parent in folder.absolute().parents if parent.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        raise PhotoError(f"{folder} cannot be written, since {above} cannot: name another folder")


def _require_known(paper: DeclaredSheet) -> None:
    for color in (paper.front_color, paper.back_color):
        if color is not None:
            color_rgb(color)


def _settle(making: Path, folder: Path) -> None:
    """Put the finished folder in its place."""
    if folder.exists():
        folder.rmdir()
    making.chmod(0o755)
    making.rename(folder)
