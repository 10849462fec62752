"""Telling the host how far a long tool has come, and ending it where the host has called it off."""

import anyio.from_thread

from folding_server.mcp.context import ToolContext


class ToolProgress:
    """Counts the steps of one call.

    Tools run in worker threads, so each step is sent through the event loop.
    """

    def __init__(self, ctx: ToolContext, total: int) -> None:
        self._ctx = ctx
        self._total = total
        self._done = 0

    def step(self, message: str) -> None:
        """Say what is being done now; the steps before it are done.

        Hosts that did not ask for progress get none.
        """
        anyio.from_thread.run(self._ctx.report_progress, self._done, self._total, message)
        self._done += 1


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
