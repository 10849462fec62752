"""Serving over stdio so that the last answer is written before the process ends.

The SDK cancels the calls that are being answered as soon as its input ends, which is where piped input always does.
"""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from types import TracebackType
from typing import Any, Self

import anyio
from mcp.server.stdio import stdio_server
from mcp.shared.message import SessionMessage
from mcp.types import JSONRPCError, JSONRPCNotification, JSONRPCRequest, JSONRPCResponse

ANSWER_SECONDS = 600
"""Seconds that calls have to be answered after the input has ended; as long as the client waits for a call."""
_NEVER_ANSWERED = frozenset({"subscriptions/listen"})
"""Requests that stand until the connection ends."""


class OpenRequests:
    """The requests that have come and were not answered yet."""

    def __init__(self) -> None:
        self._ids: set[str | int] = set()
        self._none_left = anyio.Event()
        self._ended = False

    def came(self, message: SessionMessage | Exception) -> None:
        """Note what the host sent."""
        match message.message if isinstance(message, SessionMessage) else None:
            case JSONRPCRequest(id=request, method=method) if method not in _NEVER_ANSWERED:
                self._ids.add(request)
            case JSONRPCNotification(method="notifications/cancelled", params=dict(params)):
                self._ids.discard(params.get("requestId", ""))

    def went(self, message: SessionMessage) -> None:
        """Note what the host was sent."""
        match message.message:
            case JSONRPCResponse(id=request) | JSONRPCError(id=request) if request is not None:
                self._ids.discard(request)
        self._look()

    async def answered(self) -> None:
        """Wait until all are answered, at most ANSWER_SECONDS."""
        self._ended = True
        self._look()
        with anyio.move_on_after(ANSWER_SECONDS):
            await self._none_left.wait()

    def _look(self) -> None:
        if self._ended and not self._ids:
            self._none_left.set()


class _Stream:
    """One direction of a connection, as the SDK's loops use it."""

    def __init__(self, stream: Any, requests: OpenRequests) -> None:  # noqa: ANN401 - the SDK's own types are private
        self._stream = stream
        self._requests = requests

    async def aclose(self) -> None:
        """Close the stream beneath."""
        await self._stream.aclose()

    async def __aenter__(self) -> Self:
        """Closed on leaving."""
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close it."""
        await self.aclose()


class RequestReader(_Stream):
    """What the host says. It ends when the input has ended and every request was answered."""

    @property
    def last_context(self) -> Any:  # noqa: ANN401 - as the stream beneath has it
        """The context variables that the last message was sent with."""
        return self._stream.last_context

    async def receive(self) -> SessionMessage | Exception:
        """The next message. EndOfStream after the last one is answered."""
        try:
            message: SessionMessage | Exception = await self._stream.receive()
        except anyio.EndOfStream:
            await self._requests.answered()
            raise
        self._requests.came(message)
        return message

    def __aiter__(self) -> Self:
        """The messages."""
        return self

    async def __anext__(self) -> SessionMessage | Exception:
        """The next message."""
        try:
            return await self.receive()
        except anyio.EndOfStream:
            raise StopAsyncIteration from None


class AnswerWriter(_Stream):
    """What the host is told."""

    async def send(self, message: SessionMessage) -> None:
        """Send a message."""
        await self._stream.send(message)
        self._requests.went(message)


@asynccontextmanager
async def answering_stdio() -> AsyncIterator[tuple[RequestReader, AnswerWriter]]:
    """The process's stdin and stdout as a connection on which no answer is lost when the input ends."""
    requests = OpenRequests()
    async with stdio_server() as (incoming, outgoing):
        yield RequestReader(incoming, requests), AnswerWriter(outgoing, requests)
