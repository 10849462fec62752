"""Calls that take about a millisecond are carried out in the event loop: a thread costs half as much again, and where many calls
come at once, threads wait for the interpreter within every transaction.
"""

from collections.abc import Awaitable, Callable
from functools import partial, wraps
from typing import Any

import anyio.to_thread

from folding_server.mcp.context import ToolContext, app_context
from folding_server.store.non_blocking import WouldBlock, non_blocking


def in_event_loop(function: Callable[..., Any]) -> Callable[..., Awaitable[Any]]:
    """A brief tool's function as a coroutine: carried out at once, and in a thread where it would have to wait.

    The first call is a thread's, which loads what the tool needs. What is answered is on the disk.
    """
    loaded = False

    @wraps(function)
    async def call(ctx: ToolContext, **arguments: Any) -> Any:
        nonlocal loaded
        if loaded:
            try:
                with non_blocking():
                    answer = function(ctx, **arguments)
            except WouldBlock:
                pass
            else:
                await app_context(ctx).on_disk()
                return answer
        answer = await anyio.to_thread.run_sync(partial(function, ctx, **arguments))
        loaded = True
        return answer

    return call
