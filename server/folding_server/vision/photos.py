"""What seeing needs of a sequence of photos, and nothing more."""

from typing import Protocol, runtime_checkable

from folding_server.arrays import RgbImage


class Photos(Protocol):
    """Photos of one sheet being folded, numbered from 1; the first shows the flat square, front up."""

    @property
    def name(self) -> str:
        """What messages call the sequence."""
        ...

    @property
    def frame_count(self) -> int:
        """How many photos there are."""
        ...

    @property
    def front_color(self) -> str | None:
        """The declared colour of the front: a hint, often a rough one."""
        ...

    @property
    def back_color(self) -> str | None:
        """The declared colour of the back: a hint, often a rough one."""
        ...

    def photo(self, frame: int) -> RgbImage:
        """One photo at full size. PhotoError if there is no such frame."""
        ...


@runtime_checkable
class Film(Photos, Protocol):
    """Photos with images in between, as a video has them."""

    def between(self, frame: int, count: int | None) -> list[int]:
        """Indices of evenly spaced images between photos ``frame`` - 1 and ``frame``, at most ``count``."""
        ...

    def image(self, index: int) -> RgbImage:
        """The image at an index, at full size."""
        ...
