"""HTTP as benchmarks send it: requests as bytes over kept connections, so that the hosts cost little beside the server."""

import asyncio
import json
import re
from typing import Any, NamedTuple, Self
from urllib.parse import urlsplit

from mcp.types import LATEST_PROTOCOL_VERSION

META = {
    "io.modelcontextprotocol/protocolVersion": LATEST_PROTOCOL_VERSION,
    "io.modelcontextprotocol/clientCapabilities": {},
    "io.modelcontextprotocol/clientInfo": {"name": "benchmark", "version": "1"},
}
"""What every request of the protocol of 2026-07-28 says of its host."""

_LENGTH = re.compile(rb"content-length: *(\d+)", re.IGNORECASE)
_HEAD_END = b"\r\n\r\n"


class Reply(NamedTuple):
    """An answer as it came. ``head`` is the status line and the headers."""

    status: int
    head: bytes
    body: bytes


class KeptConnection(asyncio.Protocol):
    """One connection, on which one request after the other is answered; only answers that say their length are read."""

    def __init__(self) -> None:
        self._come = b""
        self._waiting: asyncio.Future[Reply] | None = None
        self._transport: asyncio.WriteTransport | None = None

    @classmethod
    async def to(cls, url: str) -> Self:
        """A connection to the server at a URL."""
        place = urlsplit(url)
        _, connection = await asyncio.get_running_loop().create_connection(
            cls, place.hostname or "", place.port or 80
        )
        return connection

    async def send(self, request: bytes) -> Reply:
        """The answer to a request. ConnectionError if the server closes the connection without one."""
        if self._transport is None:
            raise ConnectionError
        self._waiting = asyncio.get_running_loop().create_future()
        self._transport.write(request)
        return await self._waiting

    def close(self) -> None:
        """Close it."""
        if self._transport is not None:
            self._transport.close()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin."""
        assert isinstance(transport, asyncio.WriteTransport)
        self._transport = transport

    def data_received(self, data: bytes) -> None:
        """Take in a part of an answer."""
        self._come += data
        head, found, rest = self._come.partition(_HEAD_END)
        length = _LENGTH.search(head)
        size = int(length.group(1)) if length else 0
        if found and len(rest) >= size and self._waiting is not None:
            self._come = rest[size:]
            self._waiting.set_result(Reply(int(head[9:12]), head, rest[:size]))
            self._waiting = None

    def connection_lost(self, exc: Exception | None) -> None:
        """Tell whoever waits."""
        self._transport = None
        if self._waiting is not None and not self._waiting.done():
            self._waiting.set_exception(exc or ConnectionError("closed without an answer"))


def tool_call(url: str, number: int, tool: str, arguments: dict[str, Any]) -> bytes:
    """The bytes of a call of a tool."""
    parameters = {"name": tool, "arguments": arguments, "_meta": META}
    message = {"jsonrpc": "2.0", "id": number, "method": "tools/call", "params": parameters}
    return post(url, json.dumps(message).encode(), {"Mcp-Method": "tools/call", "Mcp-Name": tool})


def post(url: str, body: bytes, headers: dict[str, str]) -> bytes:
    """The bytes of a POST to a URL, with the headers that the protocol asks for and these."""
    place = urlsplit(url)
    lines = {
        "Host": place.netloc,
        "Content-Type": "application/json",
        "Accept": "application/json, text/event-stream",
        "MCP-Protocol-Version": LATEST_PROTOCOL_VERSION,
        "Content-Length": str(len(body)),
        **headers,
    }
    head = "".join(f"{name}: {value}\r\n" for name, value in lines.items())
    return f"POST {place.path} HTTP/1.1\r\n{head}\r\n".encode("latin-1") + body


async def get(url: str) -> Reply:
    """What is read at a URL, on a connection of its own."""
    place = urlsplit(url)
    connection = await KeptConnection.to(url)
    try:
        return await connection.send(f"GET {place.path} HTTP/1.1\r\nHost: {place.netloc}\r\n\r\n".encode())
    finally:
        connection.close()
