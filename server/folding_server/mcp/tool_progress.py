"""Telling the host how far a long tool has come."""

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
