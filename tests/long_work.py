"""Work for workers of tests. It is found by name in their processes, where ``PYTHONPATH`` names this folder."""

import os
import time
from collections.abc import Callable

from folding_server.errors import PhotoError

Announce = Callable[[str], None]


def add(announce: Announce, first: int, second: int) -> int:
    announce("adding")
    print("a library prints")
    return first + second


def compute_for(announce: Announce, seconds: float) -> int:
    """Holds the processor for so long; announces its process first."""
    announce(str(os.getpid()))
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        sum(range(1000))
    return os.getpid()


def process_id(_announce: Announce) -> int:
    return os.getpid()


def niceness(_announce: Announce) -> int:
    return os.nice(0)


def input_left(_announce: Announce) -> bytes:
    return os.read(0, 1)


def refuse(_announce: Announce) -> None:
    raise PhotoError("the photo is blank")


def fail(_announce: Announce) -> None:
    _ = 1 / 0
