"""The tasks extension (``io.modelcontextprotocol/tasks``, SEP-2663): a long call is answered with a handle to ask again by.

A client of the protocol of 2026-07-28 that declares it with its calls gets the handle where a tool that takes long has no answer
within PROMPT_SECONDS. Tasks live in this process; they are their owner's alone, few, and forgotten after a while.
"""

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any, Literal
from uuid import uuid4

import anyio
from anyio.abc import TaskGroup
from mcp.server.context import CallNext, HandlerResult, ServerRequestContext
from mcp.server.extension import Extension, MethodBinding
from mcp.server.mcpserver import require_client_extension
from mcp.shared.exceptions import MCPError
from mcp.types import INTERNAL_ERROR, INVALID_PARAMS, CallToolRequestParams, ErrorData, RequestParams
from pydantic import BaseModel

from folding_server.mcp.auth import caller
from folding_server.mcp.errors import short_name

PROMPT_SECONDS = 2.0
"""Seconds within which a call is answered as any other: a handle and the question after it cost more than waiting."""
TTL_SECONDS = 600
"""Seconds for which a task is kept, from the call on: as long as our own client waits for an answer."""
TASK_POLL_SECONDS = 1.0
"""Seconds after which a client may ask again: a photo is explained in 1 to 10."""
MOST_TASKS = 256
"""Tasks kept at once; each holds at most an answer of 800 kB."""
MOST_OF_OWNER = 32
"""Tasks kept at once of an owner of tokens."""
_MODERN = frozenset({"2026-07-28"})
"""The versions of the protocol with this extension."""

_Request = ServerRequestContext[Any, Any]
_Status = Literal["working", "completed", "failed", "cancelled"]


class TaskRequestParams(RequestParams):
    """Which task a request is about."""

    task_id: str


@dataclass(eq=False)
class CallTask:
    """A call that goes on by itself: how it stands, and what it came to."""

    owner: str | None
    task_id: str = field(default_factory=lambda: str(uuid4()))
    created: datetime = field(default_factory=lambda: datetime.now(UTC))
    updated: datetime = field(default_factory=lambda: datetime.now(UTC))
    status: _Status = "working"
    message: str = ""
    result: dict[str, Any] | None = None
    error: ErrorData | None = None
    over: anyio.Event = field(default_factory=anyio.Event)
    scope: anyio.CancelScope = field(default_factory=anyio.CancelScope)

    def say(self, message: str) -> None:
        """What is being done now."""
        self.message, self.updated = message, datetime.now(UTC)

    def end(
        self, status: _Status, result: dict[str, Any] | None = None, error: ErrorData | None = None
    ) -> None:
        """What it came to; the first end stands."""
        if self.status == "working":
            self.status, self.result, self.error = status, result, error
            self.updated = datetime.now(UTC)
            self.over.set()

    def as_told(self) -> dict[str, Any]:
        """The task as it travels."""
        told: dict[str, Any] = {
            "taskId": self.task_id,
            "status": self.status,
            "createdAt": self.created.isoformat(),
            "lastUpdatedAt": self.updated.isoformat(),
            "ttlMs": TTL_SECONDS * 1000,
            "pollIntervalMs": round(TASK_POLL_SECONDS * 1000),
        }
        if self.message:
            told["statusMessage"] = self.message
        if self.result is not None:
            told["result"] = self.result
        if self.error is not None:
            told["error"] = self.error.model_dump(mode="json", exclude_none=True)
        return told


CURRENT_TASK: ContextVar[CallTask | None] = ContextVar("current_task", default=None)
"""The task that a call is computed for, if it is for one."""


class CallTasks(Extension):
    """Calls of the ``tools`` that take long, as tasks for those clients that have them."""

    identifier = "io.modelcontextprotocol/tasks"

    def __init__(self, tools: Sequence[str], prompt_seconds: float) -> None:
        self._tools = frozenset(tools)
        self._prompt_seconds = prompt_seconds
        self._tasks: dict[str, CallTask] = {}
        self._groups: list[TaskGroup] = []

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Let tasks go on as long as a server does; what is not over then is cancelled."""
        async with anyio.create_task_group() as group:
            self._groups.append(group)
            try:
                yield
            finally:
                self._groups.remove(group)
                group.cancel_scope.cancel()

    def methods(self) -> Sequence[MethodBinding]:
        """The three requests about a task."""
        handlers = {"tasks/get": self._get, "tasks/update": self._update, "tasks/cancel": self._cancel}
        return [
            MethodBinding(method, TaskRequestParams, handler, _MODERN) for method, handler in handlers.items()
        ]

    async def intercept_tool_call(
        self, params: CallToolRequestParams, ctx: _Request, call_next: CallNext
    ) -> HandlerResult:
        """Answer a call, with a handle if it takes long and the client has tasks. A call that is cancelled before is stopped."""
        owner = caller()
        if params.name not in self._tools or not self._groups or not _has_tasks(ctx) or self._full(owner):
            return await call_next(ctx)
        task = CallTask(owner)
        self._groups[-1].start_soon(_carry_out, task, ctx, call_next)
        try:
            with anyio.move_on_after(self._prompt_seconds):
                await task.over.wait()
        except BaseException:
            task.scope.cancel()
            raise
        if task.error is not None:
            raise MCPError.from_error_data(task.error)
        if task.result is not None:
            return task.result
        self._tasks[task.task_id] = task
        return {"resultType": "task", **task.as_told()}

    async def _get(self, ctx: _Request, params: TaskRequestParams) -> HandlerResult:
        return self._known(ctx, params).as_told()

    async def _update(self, ctx: _Request, params: TaskRequestParams) -> HandlerResult:
        """No task of ours asks for anything: answers to unknown questions are passed over, as the extension says."""
        self._known(ctx, params)
        return {}

    async def _cancel(self, ctx: _Request, params: TaskRequestParams) -> HandlerResult:
        task = self._known(ctx, params)
        task.end("cancelled")
        task.scope.cancel()
        return {}

    def _known(self, ctx: _Request, params: TaskRequestParams) -> CallTask:
        """The caller's own task. MCPError if there is none, or the client has no tasks."""
        require_client_extension(ctx, self.identifier)
        self._forget_old()
        task = self._tasks.get(params.task_id)
        if task is None or task.owner != caller():
            raise MCPError(
                INVALID_PARAMS,
                f"There is no task {short_name(params.task_id)}; tasks are kept for {TTL_SECONDS // 60} minutes by the "
                "server process that began them: call the tool again.",
            )
        return task

    def _full(self, owner: str | None) -> bool:
        """Whether no other task may be kept for this owner."""
        self._forget_old()
        own = sum(task.owner == owner for task in self._tasks.values())
        return len(self._tasks) >= MOST_TASKS or (owner is not None and own >= MOST_OF_OWNER)

    def _forget_old(self) -> None:
        """Forget tasks whose time is over, and stop those that are still computed."""
        now = datetime.now(UTC)
        old = [each for each in self._tasks.values() if (now - each.created).total_seconds() > TTL_SECONDS]
        for task in old:
            task.scope.cancel()
            del self._tasks[task.task_id]


def _has_tasks(ctx: _Request) -> bool:
    """Whether the client declared tasks with this request, in a version of the protocol that has them."""
    capabilities = ctx.session.client_capabilities
    declared = (capabilities.extensions or {}) if capabilities else {}
    return ctx.protocol_version in _MODERN and CallTasks.identifier in declared


async def _carry_out(task: CallTask, ctx: _Request, call_next: CallNext) -> None:
    """Carry out a task's call and keep what it comes to."""
    CURRENT_TASK.set(task)
    try:
        with task.scope:
            task.end("completed", _as_told(await call_next(ctx)))
    except MCPError as error:
        task.end("failed", error=error.error)
    except Exception as error:  # noqa: BLE001 - other tasks go on; the SDK says as little of such errors
        task.end(
            "failed", error=ErrorData(code=INTERNAL_ERROR, message=f"Internal error ({type(error).__name__})")
        )
    finally:
        task.end("cancelled")


def _as_told(result: HandlerResult) -> dict[str, Any]:
    """The answer of a call as it travels."""
    if isinstance(result, BaseModel):
        return result.model_dump(by_alias=True, mode="json", exclude_none=True)
    return dict(result) if isinstance(result, dict) else {}
