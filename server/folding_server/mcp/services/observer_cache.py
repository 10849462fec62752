"""Seeing: the observer for each sequence, made once and used by one call at a time."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import TYPE_CHECKING

from cachetools import LRUCache

if TYPE_CHECKING:
    from folding_server.vision.photos import Photos
    from folding_server.vision.seeing import SequenceObserver


class ObserverCache:
    """Observers by sequence, for the few used last: finding the sheet and learning its colours takes a while."""

    def __init__(self, size: int = 4) -> None:
        self._observers: LRUCache[str, tuple[Lock, list[SequenceObserver]]] = LRUCache(size)
        self._guard = Lock()

    @contextmanager
    def on(self, key: str, load: "Callable[[], Photos]") -> Iterator["SequenceObserver"]:
        """The observer kept under a key, or a new one for the photos that ``load`` gives, for this caller alone.

        PhotoError if frame 1 shows no flat square.
        """
        from folding_server.vision.seeing import see_sequence  # noqa: PLC0415  (loads OpenCV)

        turn, made = self._place(key)
        with turn:
            if not made:
                made.append(see_sequence(load()))
            yield made[0]

    def _place(self, key: str) -> "tuple[Lock, list[SequenceObserver]]":
        """The lock for a sequence's observer, and the observer once it is made."""
        with self._guard:
            return self._observers.setdefault(key, (Lock(), []))
