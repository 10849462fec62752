"""Connections that do not outlast their use."""

import asyncio
from http import HTTPStatus

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

IDLE_SECONDS = 30
"""Seconds that a connection may go without a complete request. Clients that keep connections for reuse (httpx: 5 s)
give them up earlier, so that none sends on a connection that is just being closed."""
HEAD_BYTES = 65_536
"""Bytes of a request before its body, as many as uvicorn's other parser takes; this one has no limit of its own."""


class ExpiringConnection(HttpToolsProtocol):
    """A connection that is closed when a request, from its first byte to its last, does not come in time.

    Uvicorn itself times only the pause after an answer: a connection that never asks, or asks half a question,
    would stay open for ever, and would keep the server from ending. A head that is too long is refused.
    """

    _expiry: asyncio.TimerHandle | None = None
    _whole = False
    _in_body = False
    _heads = 0
    _head_bytes = 0

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a request."""
        super().connection_made(transport)
        self._watch()

    def data_received(self, data: bytes) -> None:
        """Take in what has come, and wait for the rest."""
        heads, in_body = self._heads, self._in_body
        super().data_received(data)
        if self._heads == heads and not in_body:
            self._head_bytes += len(data)
            if self._head_bytes > HEAD_BYTES and not self.transport.is_closing():
                self._refuse_head()
        self._watch()

    def on_message_begin(self) -> None:
        """A request begins."""
        super().on_message_begin()
        self._whole = False

    def on_headers_complete(self) -> None:
        """The head of the request has come."""
        super().on_headers_complete()
        self._heads += 1
        self._head_bytes = 0
        self._in_body = True

    def on_message_complete(self) -> None:
        """The request has come whole."""
        super().on_message_complete()
        self._whole, self._in_body = True, False

    def on_response_complete(self) -> None:
        """Wait for the next request."""
        super().on_response_complete()
        self._watch()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no more."""
        super().connection_lost(exc)
        self._watch()

    def shutdown(self) -> None:
        """End with the server: at once if no complete request has come, else after its answer."""
        if self._incomplete():
            self.transport.close()
        else:
            super().shutdown()

    def _refuse_head(self) -> None:
        """Answer that the head is too long, and close."""
        refusal = HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE
        self.transport.write(
            f"HTTP/1.1 {refusal.value} {refusal.phrase}\r\nconnection: close\r\ncontent-length: 0\r\n\r\n".encode()
        )
        self.transport.close()

    def _incomplete(self) -> bool:
        asked = self.cycle is not None and self._whole and not self.cycle.response_complete
        return not asked and not self.transport.is_closing()

    def _watch(self) -> None:
        """One timer for each request: what comes in drops does not set it back."""
        if not self._incomplete():
            if self._expiry is not None:
                self._expiry.cancel()
            self._expiry = None
        elif self._expiry is None:
            self._expiry = self.loop.call_later(self.config.timeout_keep_alive, self.transport.close)
