"""Serving over Streamable HTTP: where to listen, and under which names requests are accepted."""

import os
import socket
import sys
from collections.abc import Sequence
from typing import NamedTuple

import anyio
import uvicorn
from mcp.server.transport_security import TransportSecuritySettings
from starlette.requests import Request
from starlette.responses import JSONResponse
from starlette.types import ASGIApp

from folding_server.errors import AddressError
from folding_server.mcp.context import AppContext
from folding_server.mcp.server import FoldingServer

LOCAL_NAMES = ("127.0.0.1", "localhost", "[::1]")
PATH = "/mcp"


class Address(NamedTuple):
    """Where to listen; port 0 lets the system choose one."""

    host: str
    port: int


def parse_address(text: str) -> Address:
    """``HOST:PORT`` as an address, ``[HOST]:PORT`` for IPv6. AddressError if it is neither."""
    host, colon, port = text.rpartition(":")
    if not colon or not host or not port.isascii() or not port.isdigit() or int(port) > 65535:
        raise AddressError(f"{text!r} is no address to serve on; give HOST:PORT such as 127.0.0.1:8000.")
    return Address(host.strip("[]"), int(port))


def serve(app: AppContext, address: Address, known_as: Sequence[str] = ()) -> None:
    """Serve over HTTP until interrupted.

    Requests are accepted only under local names, the host's and ``known_as``. Raises FoldingError if
    the address, the database or a folder of sequences cannot be used.
    """
    app.prepare()
    with _listening(address) as listener:
        port = listener.getsockname()[1]
        application = http_app(FoldingServer(app), address.host, known_as)
        config = uvicorn.Config(application, log_level="warning", access_log=False)
        shown = f"[{address.host}]" if ":" in address.host else address.host
        sys.stderr.write(f"Serving on http://{shown}:{port}{PATH}\n")
        anyio.run(uvicorn.Server(config).serve, [listener])


def http_app(server: FoldingServer, host: str, known_as: Sequence[str] = ()) -> ASGIApp:
    """The ASGI application: the protocol at ``/mcp``, and ``/health`` for whoever watches the process."""

    @server.custom_route("/health", methods=["GET"])  # type: ignore[untyped-decorator]
    async def health(_request: Request) -> JSONResponse:
        """Say that the process answers."""
        return JSONResponse({"status": "ok"})

    return server.streamable_http_app(
        streamable_http_path=PATH, host=host, transport_security=allowed_names(host, known_as)
    )


def allowed_names(host: str, known_as: Sequence[str] = ()) -> TransportSecuritySettings:
    """Which Host and Origin headers are accepted: no web page may reach it under a name of its own."""
    names = dict.fromkeys([*LOCAL_NAMES, f"[{host}]" if ":" in host else host, *known_as])
    hosts = [form for name in names for form in (name, f"{name}:*")]
    return TransportSecuritySettings(
        allowed_hosts=hosts,
        allowed_origins=[f"{scheme}://{form}" for scheme in ("http", "https") for form in hosts],
    )


def _listening(address: Address) -> socket.socket:
    """A socket bound to the address. AddressError with the system's reason if that cannot be."""
    family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
    try:
        return socket.create_server(tuple(address), family=family)
    except OSError as error:
        reason = error.strerror or os.strerror(error.errno) if error.errno else str(error)
        raise AddressError(
            f"Cannot serve on {address.host}:{address.port} ({reason}); choose another address with --http."
        ) from error
