"""Telling the host how far a long tool has come."""

from folding_server.mcp.context import ToolContext
from folding_server.mcp.tasks import CURRENT_TASK

PERCENT = 100
"""Steps of work that announces what part of it is done."""


class ToolProgress:
    """Counts the steps of one call, which workers compute. Hosts that did not ask for progress get none.

    ``seconds`` is the time that the work took, None until it is over.
    """

    def __init__(self, ctx: ToolContext, steps: int) -> None:
        self._ctx = ctx
        self._steps = steps
        self._waits = 0
        self._done = 0
        self.seconds: float | None = None

    async def announced(self, doing: str, part: float | None = None) -> None:
        """Say, in the event loop, what is being done now; the steps before it are done. A ``part`` is of all steps.

        A step that is no further than the one before is not told again.
        """
        if (task := CURRENT_TASK.get()) is not None:
            task.say(doing)
        done = self._done if part is None else self._waits + int(part * self._steps)
        if done >= self._done:
            self._done = done + 1
            await self._ctx.report_progress(done, self._steps + self._waits, doing)

    async def queued(self, before: int) -> None:
        """Say that the work waits, which is one step more."""
        self._waits += 1
        await self.announced(f"waiting, {before} before this call")

    def took(self, seconds: float) -> None:
        """Keep the time."""
        self.seconds = seconds
