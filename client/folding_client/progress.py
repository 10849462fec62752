"""What a person sees while a run works: frames done, current step, time elapsed; on stderr only."""

import time
from typing import Protocol, Self

from rich.console import Console
from rich.status import Status


class Progress(Protocol):
    """Is told where a run is."""

    def step(self, frame: int, frames: int, saved: int) -> None:
        """A step towards ``frame`` begins; ``saved`` of ``frames`` are done."""
        ...

    def doing(self, what: str) -> None:
        """Something begins within the step."""
        ...


class Silent:
    """Shows nothing."""

    def step(self, frame: int, frames: int, saved: int) -> None:
        """Nothing."""

    def doing(self, what: str) -> None:
        """Nothing."""


class Shown:
    """A live line on a terminal, one line per step elsewhere. A context manager."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._status: Status | None = Status("starting", console=console) if console.is_terminal else None
        self._started = time.monotonic()
        self._where = ""

    def __enter__(self) -> Self:
        if self._status:
            self._status.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._status:
            self._status.stop()

    def step(self, frame: int, frames: int, saved: int) -> None:
        """Show the step; off a terminal, print it."""
        self._where = f"{saved} of {frames} frames done, working on frame {frame}"
        if self._status is None:
            self._console.print(f"{self._where} ({self._elapsed()})", highlight=False)
        else:
            self.doing("thinking")

    def doing(self, what: str) -> None:
        """Show what is being done, on a terminal."""
        if self._status:
            self._status.update(f"{self._where}: {what} ({self._elapsed()})")

    def _elapsed(self) -> str:
        minutes, seconds = divmod(int(time.monotonic() - self._started), 60)
        return f"{minutes}:{seconds:02d}"
