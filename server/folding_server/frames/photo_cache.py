"""A bounded memory of decoded photos, shared between sequences and threads."""

from collections.abc import Callable, Hashable
from threading import Lock

from cachetools import LRUCache

from folding_server.arrays import RgbImage

CAPACITY = 256 * 2**20
"""Bytes of pixels: some forty photos of two megapixels."""


class PhotoCache:
    """The most recently used photos, up to `capacity` bytes of pixels; what it hands out is read-only."""

    def __init__(self, capacity: int = CAPACITY) -> None:
        self._photos: LRUCache[Hashable, RgbImage] = LRUCache(capacity, getsizeof=lambda photo: photo.nbytes)
        self._lock = Lock()

    @property
    def bytes_held(self) -> int:
        """How many bytes of pixels are in memory."""
        return int(self._photos.currsize)

    def get(self, key: Hashable, make: Callable[[], RgbImage]) -> RgbImage:
        """The photo kept under `key`, or the one that `make` returns; two threads may both make it."""
        with self._lock:
            if (kept := self._photos.get(key)) is not None:
                return kept
        photo = make()
        photo.setflags(write=False)
        with self._lock:
            if photo.nbytes <= self._photos.maxsize:
                self._photos[key] = photo
        return photo
