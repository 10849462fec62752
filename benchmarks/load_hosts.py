"""The hosts of ``benchmarks/load.py``: one that costs little, and one with the SDK's client."""

import json
from contextlib import AsyncExitStack
from typing import Any, Protocol, Self

import httpx2
from kept_connections import KeptConnection, get, tool_call
from mcp import Client
from mcp.client.streamable_http import streamable_http_client

Answer = bytes | dict[str, Any]
"""What a call was answered: the body as it came, or what the SDK's client made of it."""


class LoadHost(Protocol):
    """One host, which makes one call after the other."""

    @classmethod
    async def connected(cls, url: str) -> Self:
        """A host of the server at a URL."""

    async def call(self, tool: str, arguments: dict[str, Any]) -> Answer:
        """Call a tool."""

    async def close(self) -> None:
        """Disconnect."""


class PlainHost:
    """Sends bytes and keeps the bytes that come back."""

    def __init__(self, url: str, connection: KeptConnection) -> None:
        self._url, self._connection, self._sent = url, connection, 0

    @classmethod
    async def connected(cls, url: str) -> Self:
        """A host on a connection of its own."""
        return cls(url, await KeptConnection.to(url))

    async def call(self, tool: str, arguments: dict[str, Any]) -> bytes:
        """The body of the answer."""
        self._sent += 1
        return (await self._connection.send(tool_call(self._url, self._sent, tool, arguments))).body

    async def close(self) -> None:
        """Close the connection."""
        self._connection.close()


class SdkHost:
    """Calls as hosts in Python do, with the SDK's client."""

    def __init__(self, client: Client, stack: AsyncExitStack) -> None:
        self._client, self._stack = client, stack

    @classmethod
    async def connected(cls, url: str) -> Self:
        """A host with a client of its own."""
        stack = AsyncExitStack()
        web = await stack.enter_async_context(httpx2.AsyncClient(timeout=60))
        client = Client(streamable_http_client(url, http_client=web))
        return cls(await stack.enter_async_context(client), stack)

    async def call(self, tool: str, arguments: dict[str, Any]) -> dict[str, Any]:
        """The result, in the names of the wire."""
        answer = await self._client.call_tool(tool, arguments)
        return answer.model_dump(mode="json", by_alias=True)

    async def close(self) -> None:
        """Disconnect."""
        await self._stack.aclose()


def result_of(answer: Answer) -> dict[str, Any]:
    """The result of a call. KeyError if it was answered by an error of the protocol."""
    return dict(json.loads(answer)["result"]) if isinstance(answer, bytes) else answer


async def cpu_seconds(url: str) -> float:
    """The seconds of the processor that a server has used since it started, in all its threads."""
    return float((await get(url.replace("/mcp", "/cpu"))).body)
