"""A folder of photos as a sequence: the order they were taken in, written into a manifest."""

import json
from collections.abc import Callable
from pathlib import Path

from natsort import natsorted, ns

from folding_client.interrupts import UsageError

PHOTO_SUFFIXES = (".jpg", ".jpeg", ".png", ".heic", ".heif", ".webp", ".avif", ".tif", ".tiff", ".bmp")
"""Endings of the names of photos, in any case."""
MANIFEST = "keyframes.json"
FEWEST = 2
"""Photos that a sequence needs: before and after a fold."""
TAKEN, EXIF = 36867, 0x8769
"""EXIF: when a picture was taken (DateTimeOriginal), and the directory that says it."""


def as_sequence(folder: Path, say: Callable[[str], None]) -> None:
    """Write the manifest of a folder of photos that has none; ``say`` is given the order that was taken.

    Folders that have a manifest, or fewer than two photos, stay as they are. UsageError if nothing can be written there.
    """
    if not folder.is_dir() or (folder / MANIFEST).exists():
        return
    photos = [
        p for p in folder.iterdir() if p.suffix.lower() in PHOTO_SUFFIXES and not p.name.startswith(".")
    ]
    if len(photos) < FEWEST:
        return
    by_name = natsorted(photos, key=lambda path: path.name, alg=ns.IGNORECASE)
    times = {path: taken_at(path) for path in photos}
    timed = all(times.values())
    ordered = sorted(by_name, key=lambda path: times[path] or "") if timed else by_name
    names = [path.name for path in ordered]
    try:
        (folder / MANIFEST).write_text(
            json.dumps({"frames": ".", "keyframes": names}, indent=1), encoding="utf-8"
        )
    except OSError as error:
        message = f"{folder} holds photos and no {MANIFEST}, and none can be written there ({error.strerror or error}); copy the photos elsewhere."
        raise UsageError(message) from error
    order = "when they were taken" if timed and ordered != by_name else "their names"
    say(
        f"{len(names)} photos in the order of {order}: {_shown(names)}. {MANIFEST} was written; change the order there if it is wrong."
    )


def taken_at(path: Path) -> str | None:
    """When a photo was taken, as its EXIF data say, sortable; None if they do not."""
    from PIL import Image  # noqa: PLC0415  (loads its formats)

    try:
        with Image.open(path) as image:
            value = image.getexif().get_ifd(EXIF).get(TAKEN)
    except (OSError, ValueError, SyntaxError):
        return None
    return value.strip("\0 ") or None if isinstance(value, str) else None


def _shown(names: list[str]) -> str:
    """Names in a row, the middle ones left out where there are many."""
    return ", ".join(names) if len(names) <= 6 else f"{', '.join(names[:3])}, ..., {names[-1]}"
