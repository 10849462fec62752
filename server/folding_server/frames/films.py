"""Opening a film of whatever kind: a video, or a picture that moves. A photo is told apart from both."""

from pathlib import Path

from folding_server.errors import PhotoError
from folding_server.frames.animated_pictures import animated_picture
from folding_server.frames.film_image import FilmReader
from folding_server.frames.image_files import photo_format
from folding_server.frames.sources import IMAGE_SUFFIXES

MAY_MOVE = (".gif", ".webp", ".png", ".apng")
"""Endings of pictures that may hold several images."""

PICTURES = (*(f".{suffix}" for suffix in IMAGE_SUFFIXES), ".gif", ".apng")
"""Endings of pictures, which may be taken for films by mistake."""


def open_film(path: Path) -> FilmReader:
    """The film at ``path``; its images are counted.

    Raises PhotoError for a missing file, a photo, a file without moving pictures, and one that is cut off.
    """
    moving = moving_picture(path) if path.is_file() else None
    if moving is not None:
        return moving
    found = photo_format(path) if path.is_file() and path.suffix.lower() in PICTURES else None
    if found is not None:
        raise PhotoError(
            f"{path.name} is a single photo ({found}), and a film is needed: name a film, or the folder of the photos of all steps"
        )
    from folding_server.frames.video import open_video  # noqa: PLC0415  (loads the video library)

    return open_video(path)


def moving_picture(path: Path) -> FilmReader | None:
    """The picture at ``path`` if it holds several images; None for any other file."""
    return animated_picture(path) if path.suffix.lower() in MAY_MOVE else None
