"""Serving over Streamable HTTP until told to end."""

import gc
import logging
import os
import socket
import sys
import threading
from collections.abc import Sequence
from types import FrameType

import anyio
import uvicorn
from mcp.server import streamable_http
from mcp.server.auth.provider import TokenVerifier
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse
from starlette.types import ASGIApp

from folding_server.errors import AddressError
from folding_server.mcp.context import AppContext
from folding_server.mcp.http.address import Address, is_local, listen
from folding_server.mcp.http.connections import IDLE_SECONDS, ExpiringConnection
from folding_server.mcp.http.names import AcceptedNames, guarded
from folding_server.mcp.server import FoldingServer

PATH = "/mcp"
HEALTH = "/health"
GRACE_SECONDS = 2
"""Seconds that calls have to be answered once the server is told to end."""
NEW_OBJECTS = 20_000
"""New objects after which the garbage collector looks at the new ones: those of about ten calls. With Python's own 700, and with
what is loaded in its way, the collector took an eighth of the processor time of a call (``benchmarks/load.py``)."""
LAST_SECONDS = 4.0
"""Seconds after which the process ends whatever still runs in it: container runtimes kill after 10 s, service
managers are told to expect 5. Nothing is lost, since a run is stored before its caller is answered."""


def serve(
    app: AppContext, address: Address, known_as: Sequence[str] = (), tokens: TokenVerifier | None = None
) -> None:
    """Serve over HTTP until interrupted.

    Requests are accepted only under local names, the host's and ``known_as``, and with ``tokens`` only with one of
    those. Raises FoldingError if the address, the database or a folder of sequences cannot be used, or others
    could reach the server without a token.
    """
    with listen(address) as listener:
        if tokens is None and not is_local(listener):
            raise AddressError(
                f"Other machines can reach {address.in_url}:{address.port}, so the server does not start there "
                "without tokens; give --token-file FILE with a line OWNER TOKEN for each user, or serve on 127.0.0.1."
            )
        app.prepare()
        for logger in (streamable_http.logger, logging.getLogger("uvicorn.error")):
            logger.addFilter(is_no_disconnect)
        application = http_app(FoldingServer(app, tokens), AcceptedNames.of(address.in_url, known_as))
        port = listener.getsockname()[1]
        sys.stderr.write(f"Serving on http://{address.in_url}:{port}{PATH}\n")
        anyio.run(HttpServer(configuration(application)).serve, [listener])


def http_app(server: FoldingServer, accepted: AcceptedNames) -> ASGIApp:
    """The ASGI application: the protocol at ``/mcp``, and ``/health`` for whoever watches the process."""

    @server.custom_route(HEALTH, methods=["GET"])  # type: ignore[untyped-decorator]
    async def health(_request: Request) -> JSONResponse:
        """Say that the process answers."""
        return JSONResponse({"status": "ok"})

    application = server.streamable_http_app(
        streamable_http_path=PATH, transport_security=accepted.settings()
    )
    return guarded(application, accepted, exempt=(HEALTH,))


def is_no_disconnect(record: logging.LogRecord) -> bool:
    """False for the traceback that the SDK or uvicorn logs when a client hangs up within a request: no fault of the server."""
    return record.exc_info is None or not isinstance(record.exc_info[1], ClientDisconnect)


def configuration(application: ASGIApp, idle_seconds: int = IDLE_SECONDS) -> uvicorn.Config:
    """How uvicorn serves an application: without a log of requests, and with an end to every wait."""
    return uvicorn.Config(
        application,
        http=ExpiringConnection,
        ws="none",
        log_level="warning",
        access_log=False,
        server_header=False,
        timeout_keep_alive=idle_seconds,
        timeout_graceful_shutdown=GRACE_SECONDS,
    )


class HttpServer(uvicorn.Server):
    """A uvicorn server that ends in time even while a tool computes: threads cannot be cancelled."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Begin to serve. What is loaded by now stays, so the garbage collector need not look at it again and again."""
        await super().startup(sockets)
        gc.freeze()
        gc.set_threshold(NEW_OBJECTS)

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Begin to end, and make sure that it does."""
        super().handle_exit(sig, frame)
        last = threading.Timer(LAST_SECONDS, os._exit, (128 + sig,))
        last.daemon = True
        last.start()
