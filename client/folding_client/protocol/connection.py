"""One live connection to a folding server, over stdio or HTTP, kept in a task of its own.

The SDK ends a broken connection by cancelling whatever runs inside its context. A task of its own keeps that
from the run: a caller sees an answer, or ``ConnectionLost``.
"""

import asyncio
import base64
import contextlib
import os
import sys
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO, TypeVar, cast

import httpx2
from mcp import Client, MCPError, StdioServerParameters
from mcp.client.stdio import stdio_client
from mcp.client.streamable_http import streamable_http_client
from mcp.types import BlobResourceContents, CallToolResult, RequestParamsMeta, Tool

from folding_client.interrupts import ConnectionLost, ServerGone
from folding_client.messages import ToolResult
from folding_client.protocol.tool_results import tool_result

_Answer = TypeVar("_Answer")
_CONNECTION_CLOSED = -32000
_TIMED_OUT = -32001
_CONNECT_SECONDS = 30
"""Seconds to connect to a server at a URL and to send a request, as the SDK has it."""
TOKEN_VARIABLE = "FOLDINGAGENT_SERVER_TOKEN"  # noqa: S105 - the name of a variable
"""The environment variable that holds the token for a server at a URL."""


@dataclass(frozen=True)
class ServerAddress:
    """Where the folding server is: a URL, or, without one, a process to start on these folders, with further ``options``."""

    sequences: Path
    data: Path
    url: str | None = None
    timeout: float = 600.0
    """Seconds that an answer may take."""
    options: tuple[str, ...] = ()

    def command(self) -> StdioServerParameters:
        """The process to start. It gets no variable of this environment beyond what a shell needs.

        It sees in its own process: there is one client, whose calls come one after the other.
        """
        folders = ("--sequences", str(self.sequences), "--data", str(self.data))
        return StdioServerParameters(
            command=sys.executable,
            args=["-m", "folding_server", *folders, "--vision-workers", "0", *self.options],
        )


@dataclass(frozen=True)
class _Request:
    name: str
    arguments: Mapping[str, Any]
    meta: RequestParamsMeta | None
    answer: asyncio.Future[CallToolResult]


@dataclass(frozen=True)
class _Reading:
    address: str
    answer: asyncio.Future[bytes]


class Connection:
    """A connection from ``open`` to ``close``. ``log`` takes what the server process writes to stderr."""

    def __init__(self, address: ServerAddress, log: TextIO) -> None:
        self.tools: list[Tool] = []
        self.server_version = ""
        self._address = address
        self._log = log
        self._inbox: asyncio.Queue[_Request | _Reading | None] = asyncio.Queue()
        self._ready: asyncio.Future[None]
        self._task: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Connect and read the server's tools. ConnectionLost if that fails."""
        self._ready = asyncio.get_running_loop().create_future()
        self._task = asyncio.create_task(self._serve())
        await self._until(self._ready)

    async def call(
        self, name: str, arguments: Mapping[str, Any], meta: Mapping[str, Any] | None = None
    ) -> ToolResult:
        """Call a tool; ``meta`` is what the server is told beside the arguments. A request that the server refuses is a
        result that says so.

        ConnectionLost if the server does not live to answer; ServerGone if its answer breaks its own schema.
        """
        told = cast("RequestParamsMeta", dict(meta)) if meta else None
        request = _Request(name, arguments, told, asyncio.get_running_loop().create_future())
        self._inbox.put_nowait(request)
        try:
            return tool_result(await self._until(request.answer), name)
        except MCPError as error:
            return ToolResult(error.message, is_error=True)
        except RuntimeError as error:
            message = f"The folding server's answer to {name} does not fit its own schema: {error}."
            raise ServerGone(message) from error

    async def read(self, address: str) -> bytes:
        """The bytes of a resource, such as a photo; empty if the server has none at this address.

        ConnectionLost if the server does not live to answer.
        """
        reading = _Reading(address, asyncio.get_running_loop().create_future())
        self._inbox.put_nowait(reading)
        try:
            return await self._until(reading.answer)
        except MCPError:
            return b""

    async def close(self) -> None:
        """Disconnect; a process that was started for this connection ends."""
        if self._task is None:
            return
        self._inbox.put_nowait(None)
        await asyncio.wait({self._task}, timeout=10)
        self._task.cancel()
        with contextlib.suppress(asyncio.CancelledError, Exception):
            await self._task

    async def _until(self, answer: asyncio.Future[_Answer]) -> _Answer:
        """The answer, or ConnectionLost if the connection ends before it comes."""
        assert self._task is not None, "the connection is open"
        ending: set[asyncio.Future[Any]] = {self._task, answer}
        await asyncio.wait(ending, return_when=asyncio.FIRST_COMPLETED)
        if not answer.done():
            raise ConnectionLost(self._why_it_ended())
        return answer.result()

    def _client(self) -> Client:
        if self._address.url is not None:
            over_http = _over_http(self._address.url, self._address.timeout)
            return Client(over_http, read_timeout_seconds=self._address.timeout)
        transport = stdio_client(self._address.command(), errlog=self._log)
        return Client(transport, read_timeout_seconds=self._address.timeout)

    async def _serve(self) -> None:
        async with self._client() as client:
            await self._read_tools(client)
            self._ready.set_result(None)
            while (request := await self._inbox.get()) is not None:
                await _answer(client, request)

    async def _read_tools(self, client: Client) -> None:
        page = await client.list_tools()
        self.tools = list(page.tools)
        while page.next_cursor:
            page = await client.list_tools(cursor=page.next_cursor)
            self.tools += page.tools
        self.server_version = client.server_info.version if client.server_info else ""

    def _why_it_ended(self) -> str:
        assert self._task is not None, "the connection is open"
        if self._task.cancelled():
            return "the connection was cancelled"
        error = self._task.exception() if self._task.done() else None
        while isinstance(error, BaseExceptionGroup):
            error = error.exceptions[0]
        return str(error) or type(error).__name__ if error else "the connection ended"


@contextlib.asynccontextmanager
async def _over_http(url: str, seconds: float) -> AsyncIterator[Any]:
    """A transport that shows the server the token in the environment, if there is one."""
    token = os.environ.get(TOKEN_VARIABLE, "").strip()
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    limits = httpx2.Timeout(_CONNECT_SECONDS, read=seconds)
    hooks = {"response": [_refuse_no_token]}
    async with (
        httpx2.AsyncClient(headers=headers, timeout=limits, event_hooks=hooks) as web,
        streamable_http_client(url, http_client=web, max_sse_event_size=None) as streams,
    ):
        yield streams


async def _refuse_no_token(response: httpx2.Response) -> None:
    """ConnectionLost where the server wants a token that it was not shown."""
    if response.status_code == httpx2.codes.UNAUTHORIZED:
        message = f"it takes no calls without a token it knows: set {TOKEN_VARIABLE} to one of its token file"
        raise ConnectionLost(message)


async def _answer(client: Client, request: _Request | _Reading) -> None:
    """Answer one request; what means that the connection is dead is raised, to end it."""
    try:
        if isinstance(request, _Reading):
            request.answer.set_result(await _bytes_at(client, request.address))
        else:
            request.answer.set_result(
                await client.call_tool(request.name, dict(request.arguments), meta=request.meta)
            )
    except MCPError as error:
        if error.code in (_CONNECTION_CLOSED, _TIMED_OUT):
            raise
        request.answer.set_exception(error)


async def _bytes_at(client: Client, address: str) -> bytes:
    """What a resource holds; empty unless it is binary."""
    for part in (await client.read_resource(address)).contents:
        if isinstance(part, BlobResourceContents):
            return base64.b64decode(part.blob)
    return b""
