"""A bounded memory of decoded photos, shared between sequences and threads."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock

from folding_server.arrays import RgbImage

CAPACITY = 256 * 2**20


class PhotoCache:
    """The most recently used photos, up to `capacity` bytes of pixels; what it hands out is read-only."""

    def __init__(self, capacity: int = CAPACITY) -> None:
        self._capacity = capacity
        self._photos: OrderedDict[Hashable, RgbImage] = OrderedDict()
        self._lock = Lock()
        self.bytes_held = 0

    def get(self, key: Hashable, make: Callable[[], RgbImage]) -> RgbImage:
        """The photo kept under `key`, or the one that `make` returns; two threads may both make it."""
        with self._lock:
            if key in self._photos:
                self._photos.move_to_end(key)
                return self._photos[key]
        photo = make()
        photo.setflags(write=False)
        with self._lock:
            self._keep(key, photo)
        return photo

    def _keep(self, key: Hashable, photo: RgbImage) -> None:
        if key in self._photos or photo.nbytes > self._capacity:
            return
        self._photos[key] = photo
        self.bytes_held += photo.nbytes
        while self.bytes_held > self._capacity:
            _, oldest = self._photos.popitem(last=False)
            self.bytes_held -= oldest.nbytes
