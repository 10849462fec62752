"""Animated pictures (GIF, WebP, PNG) as films: every image with the time for which it is shown."""

import warnings
from collections.abc import Hashable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.frames.film_image import VideoImage, image_label, require_in_film
from folding_server.frames.image_files import MAX_PIXELS, MIN_SIDE, scale_to
from folding_server.frames.sources import file_stamp

ANIMATED_FORMATS = ("GIF", "WEBP", "PNG")
"""Formats that may hold several images, as Pillow calls them."""
UNSET_SECONDS, LEAST_SECONDS = 0.1, 0.011
"""How long browsers show an image whose file says no longer than the second of these: files that leave it out say 0 or 10 ms."""
MOST_IMAGES = 20_000
"""More than ten minutes at 30 a second: whoever has more has a film."""
_BROKEN = (OSError, SyntaxError, ValueError, EOFError, IndexError, Image.DecompressionBombError)


@dataclass(frozen=True)
class AnimatedPicture:
    """An animated picture; ``durations`` has the seconds for which each of its images is shown, played through once."""

    path: Path
    durations: tuple[float, ...] = field(repr=False)

    @property
    def times(self) -> tuple[float, ...]:
        """Each image's time in seconds from the first."""
        return (0.0, *accumulate(self.durations[:-1]))

    def indices(self) -> range:
        """The indices of all images, from 0."""
        return range(len(self.durations))

    def files(self, indices: Sequence[int]) -> list[Path]:
        """The picture's own file; PhotoError if an index lies outside it."""
        for index in indices:
            require_in_film(index, len(self.durations), self.path.name)
        return [self.path]

    def stamp(self, index: int) -> Hashable:
        """Path, time of change and size of the file."""
        self.files([index])
        return file_stamp(self.path)

    def read(self, index: int, longest: int | None = None) -> RgbImage:
        """The image at ``index`` on white, scaled down to ``longest`` if given; PhotoError if it is broken."""
        return next(self.read_each([index], longest)).image

    def read_each(self, indices: Sequence[int], longest: int | None = None) -> Iterator[VideoImage]:
        """The images at ``indices`` (increasing), in one pass; PhotoError for one that is not there or broken."""
        self.files(indices)
        times = self.times
        with _opened(self.path) as picture:
            for index in indices:
                yield VideoImage(index, times[index], _pixels(picture, index, longest))

    def moments(self, longest: int, rate: float) -> Iterator[VideoImage]:
        """The images in order, scaled down to ``longest``, without those shown so briefly that more than ``rate`` a second would
        come.

        The last one comes once more when its time is over, so that its rest is seen too.
        """
        due, last = 0.0, len(self.durations) - 1
        with _opened(self.path) as picture:
            for index, (start, seconds) in enumerate(zip(self.times, self.durations, strict=True)):
                if index < last and start + 1e-9 < due and seconds < 1 / rate:
                    continue
                due = start + 1 / rate
                image = _pixels(picture, index, longest)
                yield VideoImage(index, start, image)
                if index == last:
                    yield VideoImage(index, start + seconds, image)

    def label(self, index: int) -> str:
        """The index and its time, as ``120  0:04.0``."""
        return image_label(index, self.times[index])

    def rests(self, least_seconds: float) -> bool:
        """Whether every image is shown for so long: a series of pictures, not a film."""
        return min(self.durations) >= least_seconds - 1e-6


def animated_picture(path: Path) -> AnimatedPicture | None:
    """The animated picture at ``path``; None if it is a picture of one image or of another format.

    PhotoError for one that is broken, cut off, too large, or of too many images.
    """
    try:
        with Image.open(path, formats=ANIMATED_FORMATS) as picture:
            count = getattr(picture, "n_frames", 1)
            if count == 1:
                return None
            _check(path, picture, count)
    except UnidentifiedImageError:
        return None
    except _BROKEN as error:
        raise _damaged(path, error) from error
    with _opened(path) as picture:
        return AnimatedPicture(path, tuple(_seconds(picture, index) for index in range(count)))


def _check(path: Path, picture: Image.Image, count: int) -> None:
    if min(picture.size) < MIN_SIDE or picture.width * picture.height > MAX_PIXELS:
        raise PhotoError(
            f"{path.name} has images of {picture.width}x{picture.height} pixels: "
            f"at least {MIN_SIDE}x{MIN_SIDE} and at most {MAX_PIXELS // 10**6} million pixels are read"
        )
    if count > MOST_IMAGES:
        raise PhotoError(
            f"{path.name} holds {count} images, more than {MOST_IMAGES}: save it as a film, such as MP4"
        )


@contextmanager
def _opened(path: Path) -> Iterator[Image.Image]:
    """The file with its images; what is broken becomes one sentence."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path, formats=ANIMATED_FORMATS) as picture:
                yield picture
    except _BROKEN as error:
        raise _damaged(path, error) from error


def _damaged(path: Path, error: BaseException) -> PhotoError:
    return PhotoError(f"{path.name} is broken or cut off ({error}): copy it again from where it came")


def _seconds(picture: Image.Image, index: int) -> float:
    """How long an image is shown."""
    picture.seek(index)
    picture.load()  # WebP tells the duration of an image once it is decoded
    seconds = float(picture.info.get("duration") or 0) / 1000
    return seconds if seconds >= LEAST_SECONDS else UNSET_SECONDS


def _pixels(picture: Image.Image, index: int, longest: int | None) -> RgbImage:
    """An image over white as RGB, scaled down to ``longest``."""
    picture.seek(index)
    clear = picture.convert("RGBA")
    flat = Image.alpha_composite(Image.new("RGBA", clear.size, "white"), clear).convert("RGB")
    rgb = np.asarray(flat, np.uint8)
    return rgb if longest is None else scale_to(rgb, longest)
