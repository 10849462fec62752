"""Telling the host how far a long tool has come, and ending it where the host has called it off."""

import anyio.from_thread

from folding_server.mcp.context import ToolContext
from folding_server.mcp.tasks import CURRENT_TASK


class ToolProgress:
    """Counts the steps of one call. Hosts that did not ask for progress get none.

    For work that goes to the workers it is who waits: ``seconds`` is then the time that it took, None until it is over.
    """

    def __init__(self, ctx: ToolContext, total: int) -> None:
        self._ctx = ctx
        self._total = total
        self._done = 0
        self.seconds: float | None = None

    async def announced(self, doing: str) -> None:
        """Say, in the event loop, what is being done now; the steps before it are done."""
        if (task := CURRENT_TASK.get()) is not None:
            task.say(doing)
        done = self._done
        self._done += 1
        await self._ctx.report_progress(done, self._total, doing)

    async def queued(self, before: int) -> None:
        """Say that the work waits, which is one step more."""
        self._total += 1
        await self.announced(f"waiting, {before} before this call")

    def took(self, seconds: float) -> None:
        """Keep the time."""
        self.seconds = seconds


class ToolPercent:
    """Tells the host what part of one long piece of work is done, at each percent.

    Tools run in worker threads, which nothing interrupts: the work ends where it tells its progress, once the host has
    cancelled the call.
    """

    def __init__(self, ctx: ToolContext, message: str) -> None:
        self._ctx = ctx
        self._message = message
        self._told = -1

    def tell(self, part: float) -> None:
        """Say what part is done, 0 to 1. Raises what the event loop cancels tasks with if the call was cancelled."""
        anyio.from_thread.check_cancelled()
        percent = int(100 * part)
        if percent > self._told:
            self._told = percent
            anyio.from_thread.run(self._ctx.report_progress, percent, 100, self._message)
