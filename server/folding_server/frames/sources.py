"""Where a sequence's images come from: a folder of files named by index, or a video."""

import re
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.frames.image_files import decode

IMAGE_SUFFIXES = ("jpg", "jpeg", "png", "heic", "heif", "webp", "avif", "tif", "tiff", "bmp")
"""Endings of the names of photos that are read, in any case."""
_IMAGE_NAME = re.compile(rf"(?:.*[^0-9])?([0-9]{{1,8}})\.({'|'.join(IMAGE_SUFFIXES)})", re.IGNORECASE)
"""A photo whose name ends in a number: as a camera calls it, or the number alone."""


class FrameSource(Protocol):
    """Images by their index in the video."""

    def indices(self) -> Sequence[int]:
        """The indices of all images there are, increasing."""

    def read(self, index: int, longest: int | None = None) -> RgbImage:
        """The image at `index`, scaled down to `longest` if given; PhotoError if it cannot be read."""

    def files(self, indices: Sequence[int]) -> list[Path]:
        """The files that hold these images, without repetition."""

    def stamp(self, index: int) -> Hashable:
        """A value that changes when the file that holds the image changes."""


@dataclass(frozen=True)
class ImageFolder:
    """Images in one folder, each by its index: the number at the end of its name, `000004.jpg` or `IMG_0004.HEIC`."""

    folder: Path
    paths: dict[int, Path] = field(repr=False)

    def indices(self) -> list[int]:
        """The indices of all images in the folder, increasing."""
        return sorted(self.paths)

    def read(self, index: int, longest: int | None = None) -> RgbImage:
        """The image at `index`, scaled down to `longest` if given; PhotoError if it cannot be read."""
        return decode(self._path(index), longest)

    def files(self, indices: Sequence[int]) -> list[Path]:
        """One file for each index; PhotoError names the first that is missing."""
        return [self._path(index) for index in indices]

    def stamp(self, index: int) -> Hashable:
        """Path, time of change and size of the image's file."""
        return file_stamp(self._path(index))

    def _path(self, index: int) -> Path:
        path = self.paths.get(index)
        if path is None:
            raise PhotoError(
                f"the image of keyframe {index} is missing: expected {self.folder.name}/{index:06d}.jpg"
            )
        return path


def image_folder(folder: Path, within: Path) -> ImageFolder:
    """The images in `folder`, none of which may lead out of the folder `within`.

    An image named by a number alone goes before one that a number only ends. Raises PhotoError if the folder is missing,
    leads elsewhere, or holds two images of one index.
    """
    _require_images(folder, within)
    paths: dict[int, Path] = {}
    for path in sorted(folder.iterdir(), key=lambda path: (not path.stem.isdecimal(), path.name)):
        match = _IMAGE_NAME.fullmatch(path.name)
        if match is None or not path.is_file():
            continue
        index = int(match[1])
        if index in paths:
            if paths[index].stem.isdecimal() and not path.stem.isdecimal():
                continue
            raise PhotoError(
                f"{paths[index].name} and {path.name} in {within.name} are both image {index}: "
                "remove one, or name the files in keyframes.json"
            )
        if path.is_symlink():
            require_inside(path, within)
        paths[index] = path
    return ImageFolder(folder, paths)


def named_images(folder: Path, within: Path, names: Sequence[str]) -> ImageFolder:
    """The images of these names in `folder`, numbered from 1 in the order given; PhotoError if one is missing."""
    _require_images(folder, within)
    paths: dict[int, Path] = {}
    for index, name in enumerate(names, start=1):
        path = folder / name
        if not path.is_file():
            raise PhotoError(
                f"the image {name!r:.80} of keyframe {index} is missing in {folder.name}: put it there, or correct keyframes.json"
            )
        require_inside(path, within)
        paths[index] = path
    return ImageFolder(folder, paths)


def _require_images(folder: Path, within: Path) -> None:
    """Raise PhotoError unless there is such a folder, inside the folder `within`."""
    if not folder.is_dir():
        raise PhotoError(
            f"the sequence {within.name} has no folder {folder.name!r} of images; "
            "make it, or give the name of the right one in keyframes.json"
        )
    require_inside(folder, within)


def require_inside(path: Path, folder: Path) -> None:
    """Raise PhotoError if `path`, its links followed, is not inside `folder`."""
    if not path.resolve().is_relative_to(folder.resolve()):
        raise PhotoError(
            f"{path.name} in {folder.name} leads out of the sequence's folder: copy the file into it"
        )


def file_stamp(path: Path) -> Hashable:
    """Path, time of change and size of a file; PhotoError if it is gone."""
    try:
        status = path.stat()
    except OSError as error:
        raise PhotoError(f"{path.name} cannot be read: {error.strerror or error}") from error
    return path, status.st_mtime_ns, status.st_size
