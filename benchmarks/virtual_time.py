"""An event loop whose clock jumps: what sleeps for an hour wakes at once, an hour later by ``loop.time()``."""

import asyncio
import selectors
from collections.abc import Mapping
from typing import Any


class _Jumps(selectors.DefaultSelector):
    """Where the loop would wait for files or a time, the time comes at once."""

    def __init__(self) -> None:
        super().__init__()
        self.now = 0.0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        """What is ready now; else the clock goes on by ``timeout``."""
        ready: list[tuple[selectors.SelectorKey, int]] = super().select(0)
        if not ready and timeout:
            self.now += timeout
        return ready


class VirtualLoop(asyncio.SelectorEventLoop):
    """A loop in virtual time, for work that waits for nothing but time."""

    def __init__(self) -> None:
        self._jumps = _Jumps()
        super().__init__(self._jumps)

    def time(self) -> float:
        """Virtual seconds since the loop was made."""
        return self._jumps.now


def run_in_virtual_time(work: Any) -> Mapping[str, float]:  # noqa: ANN401 - any coroutine
    """Run a coroutine to its end; answers how many virtual seconds it took."""
    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        runner.run(work)
        return {"seconds": runner.get_loop().time()}
