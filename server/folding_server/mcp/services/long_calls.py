"""Calls that take long: computed by the workers while the event loop goes on, with progress, counted for their owner."""

import functools
from collections.abc import Callable, Coroutine
from typing import Any

import anyio
from anyio import to_thread
from starlette.requests import Request

from folding_server.errors import RunError
from folding_server.mcp.auth import caller
from folding_server.mcp.context import ToolContext, app_context
from folding_server.mcp.subscriptions import FIRST_MODERN
from folding_server.mcp.tool_progress import ToolProgress
from folding_server.workers.job import Answer, WorkerJob

GONE_SECONDS = 0.25
"""Seconds between two looks whether the client is still there."""


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
    counted: bool = False,
) -> Answer:
    """The answer of long work, which announces this many ``steps``, for the caller of a tool.

    If the call is cancelled, the work is. Work with a ``place`` looks at the photos there: its time counts for the owner, as
    that of other work does if it is ``counted``. RunError if the owner's time is used up, JobRefused if too many wait.
    """
    app, owner = app_context(ctx), caller()
    limited = app.limited_owner() if counted or place is not None else None
    if limited is not None:
        await aside(app.store.check_vision, limited)
    progress, job = ToolProgress(ctx, steps), WorkerJob(tool, work, given, owner, place)
    try:
        return await _while_heard(ctx, app.workers.compute(job, progress))
    finally:
        if limited is not None and progress.seconds is not None:
            with anyio.CancelScope(shield=True):
                await aside(app.count_vision, limited, progress.seconds)


async def _while_heard(ctx: ToolContext, computing: Coroutine[Any, Any, Answer]) -> Answer:
    """What is being computed, as long as someone can be told.

    In protocols before 2026-07-28 a client that hangs up has not cancelled its call. But this server keeps no answers for
    it to come back to, so that nobody would ever see this one.
    """
    request = ctx.request_context.request
    if not isinstance(request, Request) or ctx.request_context.protocol_version >= FIRST_MODERN:
        return await computing  # the SDK itself cancels the call
    failed: Exception | None = None
    answer: list[Answer] = []
    async with anyio.create_task_group() as group:
        group.start_soon(_cancel_when_gone, request, group.cancel_scope)
        try:
            answer.append(await computing)
        except Exception as error:  # noqa: BLE001 - it is raised outside of the group, which would wrap it
            failed = error
        group.cancel_scope.cancel()
    if failed is not None:
        raise failed
    if not answer:
        raise RunError("the call was stopped, since its client has hung up; send it again")
    return answer[0]


async def _cancel_when_gone(request: Request, scope: anyio.CancelScope) -> None:
    """Cancel what is computed for a client that has hung up."""
    while not await request.is_disconnected():  # noqa: ASYNC110 - nothing else tells
        await anyio.sleep(GONE_SECONDS)
    scope.cancel()
