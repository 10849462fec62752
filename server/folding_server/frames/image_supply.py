"""What a sequence is written from: images counted in order, whether a film shows them or photos are named one by one."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from natsort import natsorted, ns

from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.frames.image_files import decode_bytes
from folding_server.frames.sources import IMAGE_SUFFIXES

PHOTO_ENDINGS = tuple(f".{suffix}" for suffix in IMAGE_SUFFIXES)


class SuppliedImage(Protocol):
    """One image and its index."""

    @property
    def index(self) -> int:
        """Its index."""

    @property
    def image(self) -> RgbImage:
        """Its pixels."""


class ImageSupply(Protocol):
    """Images by index, some of which become keyframes: a ``Video``, or ``NamedPhotos``."""

    def files(self, indices: Sequence[int]) -> list[Path]:
        """The files that hold these images; PhotoError if an index is not there."""

    def read_each(self, indices: Sequence[int]) -> Iterator[SuppliedImage]:
        """The images at ``indices`` (increasing); PhotoError if one cannot be read."""

    def label(self, index: int) -> str:
        """The index as it is written over the image: with its time, where it has one."""


@dataclass(frozen=True)
class NumberedPhoto:
    """A photo and its number."""

    index: int
    image: RgbImage


@dataclass(frozen=True)
class NamedPhotos:
    """Photo files in order, numbered from 1; errors name each as ``called``, in the same order."""

    paths: tuple[Path, ...]
    called: tuple[str, ...]

    def files(self, indices: Sequence[int]) -> list[Path]:
        """One file for each number; PhotoError if a number is not there."""
        for index in indices:
            if not 1 <= index <= len(self.paths):
                raise PhotoError(f"there is no photo {index}: the photos are 1..{len(self.paths)}")
        return [self.paths[index - 1] for index in indices]

    def read_each(self, indices: Sequence[int]) -> Iterator[NumberedPhoto]:
        """The photos with these numbers, upright; PhotoError if one cannot be read."""
        for index, path in zip(indices, self.files(indices), strict=True):
            name = self.called[index - 1]
            try:
                data = path.read_bytes()
            except OSError as error:
                raise PhotoError(f"{name} cannot be read: {error.strerror or error}") from error
            yield NumberedPhoto(index, decode_bytes(data, name))

    def label(self, index: int) -> str:
        """The number."""
        return str(index)


def photos_in(folder: Path) -> list[Path]:
    """The photos in a folder in the order of their names, where 10 comes after 9. Hidden files are left out."""
    found = [
        path
        for path in folder.iterdir()
        if path.suffix.lower() in PHOTO_ENDINGS and not path.name.startswith(".")
    ]
    return natsorted(found, key=lambda path: path.name, alg=ns.IGNORECASE)
