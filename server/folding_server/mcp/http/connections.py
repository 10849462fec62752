"""Connections that do not outlast their use."""

import asyncio

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

IDLE_SECONDS = 30
"""Seconds that a connection may go without a complete request. Clients that keep connections for reuse (httpx: 5 s)
give them up earlier, so that none sends on a connection that is just being closed."""


class ExpiringConnection(H11Protocol):
    """A connection that is closed when a request, from its first byte to its last, does not come in time.

    Uvicorn itself times only the pause after an answer: a connection that never asks, or asks half a question,
    would stay open for ever, and would keep the server from ending.
    """

    _expiry: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a request."""
        super().connection_made(transport)
        self._watch()

    def handle_events(self) -> None:
        """Take in what has come, and wait for the rest."""
        super().handle_events()
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

    def _incomplete(self) -> bool:
        return self.conn.their_state in {h11.IDLE, h11.SEND_BODY} and not self.transport.is_closing()

    def _watch(self) -> None:
        """One timer for each request: what comes in drops does not set it back."""
        if not self._incomplete():
            if self._expiry is not None:
                self._expiry.cancel()
            self._expiry = None
        elif self._expiry is None:
            self._expiry = self.loop.call_later(self.config.timeout_keep_alive, self.transport.close)
