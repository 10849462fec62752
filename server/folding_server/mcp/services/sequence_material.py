"""What a caller's paths mean: one film, the photos of a folder, or photos one by one; and what to call the sequence."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from folding_server.errors import FoldingError, PhotoError

if TYPE_CHECKING:
    from folding_server.frames.allowed_folders import AllowedFolders
    from folding_server.frames.sequence_building import SequenceMaterial

_LONGEST_TITLE = 100
"""Characters of a name taken from a file, which leaves room for a number behind it."""


def material_at(paths: Sequence[str], allowed: "AllowedFolders") -> "SequenceMaterial":
    """The film or the photos at paths as a caller typed them. PhotoError if they are neither, or may not be read."""
    from folding_server.frames.films import moving_picture  # noqa: PLC0415  (loads numpy and Pillow)
    from folding_server.frames.image_supply import PHOTO_ENDINGS  # noqa: PLC0415  (loads numpy and Pillow)
    from folding_server.frames.sequence_building import SequenceMaterial  # noqa: PLC0415

    if not paths:
        raise PhotoError(
            "no path is given: give that of a film, of a folder of photos, or of each photo in order"
        )
    found = [allowed.find(path) for path in paths]
    if len(found) == 1 and found[0].is_dir():
        return _photos_of(found[0], _last_part(paths[0]), allowed)
    for path, typed in zip(found, paths, strict=True):
        _require_file(path, typed)
        if len(found) > 1 and path.suffix.lower() not in PHOTO_ENDINGS:
            raise PhotoError(
                f"{_last_part(typed)!r} is no photo ({', '.join(PHOTO_ENDINGS)}): give one film alone, one folder of photos, or photos"
            )
    alone = len(found) == 1
    film = found[0].suffix.lower() not in PHOTO_ENDINGS or (alone and moving_picture(found[0]) is not None)
    return SequenceMaterial(tuple(found), tuple(map(_last_part, paths)), film)


def title_of(paths: Sequence[str]) -> str:
    """What a sequence is called after its film, its folder or the folder of its photos; a plain word where that says nothing."""
    from folding_server.frames.manifest import check_name  # noqa: PLC0415

    first = Path(paths[0])
    name = first.stem if len(paths) == 1 else first.parent.name or first.stem
    try:
        return check_name(name[:_LONGEST_TITLE].strip())
    except FoldingError:
        return "photos"


def _photos_of(folder: Path, called: str, allowed: "AllowedFolders") -> "SequenceMaterial":
    """The photos in a folder."""
    from folding_server.frames.image_supply import photos_in  # noqa: PLC0415
    from folding_server.frames.manifest import FILE_NAME  # noqa: PLC0415
    from folding_server.frames.sequence_building import MOST_KEYFRAMES, SequenceMaterial  # noqa: PLC0415

    if (folder / FILE_NAME).is_file():
        raise PhotoError(
            f"the folder {called} is a sequence already, since it has a {FILE_NAME}: start the server with --sequences and "
            "that folder, or give the folder of its photos"
        )
    photos = _listed(folder, called, photos_in)
    if not photos:
        raise PhotoError(
            f"the folder {called} holds no photos as JPEG or PNG: save them so, or give another folder or a film"
        )
    if len(photos) > MOST_KEYFRAMES:
        raise PhotoError(
            f"the folder {called} holds {len(photos)} photos, more than {MOST_KEYFRAMES}: give one with the photos of one folding"
        )
    for photo in photos:
        allowed.require(photo, photo.name)
        _require_file(photo, photo.name)
    return SequenceMaterial(tuple(photos), tuple(photo.name for photo in photos), film=False)


def _listed(folder: Path, called: str, photos_in: Callable[[Path], list[Path]]) -> list[Path]:
    try:
        return photos_in(folder)
    except OSError as error:
        raise PhotoError(f"the folder {called} cannot be read ({error.strerror}); give another") from error


def _require_file(path: Path, typed: str) -> None:
    if not path.is_file():
        kind = "a folder among other paths" if path.is_dir() else "no ordinary file"
        raise PhotoError(f"{_last_part(typed)!r} is {kind}: give one film, one folder of photos, or photos")


def _last_part(typed: str) -> str:
    """The last part of a path, which names it well enough to whoever typed it."""
    return Path(typed).name or typed
