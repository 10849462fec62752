"""The images of a film, whatever it is read by: each with its index and its time."""

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError


@dataclass(frozen=True)
class VideoImage:
    """One image of a video: its index, its time in seconds from the first image, its pixels."""

    index: int
    seconds: float
    image: RgbImage


class FilmReader(Protocol):
    """Images that follow one another in time, counted from 0: a ``Video``, or an ``AnimatedPicture``."""

    @property
    def path(self) -> Path:
        """The film's file."""

    @property
    def times(self) -> tuple[float, ...]:
        """Each image's time in seconds from the first."""

    def indices(self) -> range:
        """The indices of all images."""

    def files(self, indices: Sequence[int]) -> list[Path]:
        """The film's own file; PhotoError if an index lies outside the film."""

    def stamp(self, index: int) -> Hashable:
        """A value that changes when the film's file changes."""

    def read(self, index: int, longest: int | None = None) -> RgbImage:
        """The image at ``index``, upright, scaled down to ``longest`` if given; PhotoError if it is broken."""

    def read_each(self, indices: Sequence[int], longest: int | None = None) -> Iterator[VideoImage]:
        """The images at ``indices`` (increasing); PhotoError if one is not there or broken."""

    def moments(self, longest: int, rate: float) -> Iterator[VideoImage]:
        """The images in order, about ``rate`` a second, scaled down to ``longest``, without broken ones."""

    def label(self, index: int) -> str:
        """The index and its time."""


def require_in_film(index: int, count: int, name: str) -> None:
    """Raise PhotoError unless a film of so many images has an image ``index``."""
    if not 0 <= index < count:
        raise PhotoError(f"image {index} is not in {name}, whose images are 0..{count - 1}")


def clock(seconds: float) -> str:
    """A time in a film, as ``0:04.0``: minutes, seconds and tenths."""
    tenths = round(10 * seconds)
    return f"{tenths // 600}:{tenths % 600 / 10:04.1f}"


def image_label(index: int, seconds: float) -> str:
    """An image's index and time, as ``120  0:04.0``."""
    return f"{index}  {clock(seconds)}"
