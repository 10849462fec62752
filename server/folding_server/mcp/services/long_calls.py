"""Calls that take long: computed by the workers while the event loop goes on, with progress, counted for their owner."""

import functools
import logging
from collections.abc import Callable
from typing import Any

import anyio
from anyio import to_thread

from folding_server.errors import FoldingError
from folding_server.mcp.auth import caller
from folding_server.mcp.context import AppContext, ToolContext, app_context
from folding_server.mcp.tool_progress import ToolProgress
from folding_server.workers.job import Answer, WorkerJob

_logger = logging.getLogger(__name__)


async def aside(work: Callable[..., Answer], *given: Any, **named: Any) -> Answer:  # noqa: ANN401 - whatever work takes
    """The answer of short work that reads the database, photos or papers, in a thread beside the event loop."""
    return await to_thread.run_sync(functools.partial(work, *given, **named))


async def compute_long(
    ctx: ToolContext,
    tool: str,
    steps: int,
    work: Callable[..., Answer],
    *given: Any,  # noqa: ANN401 - whatever work takes
    place: str | None = None,
) -> Answer:
    """The answer of long work, which announces this many ``steps``, for the caller of a tool.

    If the call is cancelled, the work is. RunError if the owner's time is used up, JobRefused if too many wait.
    """
    app, owner = app_context(ctx), caller()
    limited = owner if app.settings.limits.vision_seconds is not None else None
    if limited is not None:
        await aside(app.store.check_vision, limited)
    progress = ToolProgress(ctx, steps)
    try:
        return await app.workers.compute(WorkerJob(tool, work, given, owner, place), progress)
    finally:
        if limited is not None and progress.seconds is not None:
            with anyio.CancelScope(shield=True):
                await aside(_count, app, limited, progress.seconds)


def _count(app: AppContext, owner: str, seconds: float) -> None:
    """Count the time of a call for its owner. An answer that was computed is not lost for it."""
    try:
        app.store.add_vision(owner, seconds)
    except FoldingError as error:
        _logger.warning("%.1f seconds of %s were not counted: %s", seconds, owner, error)
