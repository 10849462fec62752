"""Serving the page on this machine alone, with an endpoint that answers its tool calls."""

import socket
from collections.abc import Callable
from typing import Any

import anyio
import uvicorn
from pydantic import BaseModel, ValidationError
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, Response
from starlette.routing import Route

from folding_server.errors import FoldingError
from folding_server.view.local_model import LocalModel
from folding_server.view.page import page_html

HOST = "127.0.0.1"
ENDPOINT = "call"
ACCEPTED_NAMES = ["127.0.0.1", "localhost"]
"""The names under which requests are accepted: no web page may reach the model under a name of its own."""


class Call(BaseModel):
    """A call of a tool as the page sends it."""

    name: str
    arguments: dict[str, Any] = {}


def serve_page(model: LocalModel, port: int, tell: Callable[[str], None]) -> None:
    """Serve the page until interrupted; ``tell`` is told the address. FoldingError if the port is taken."""
    application = page_app(model)
    try:
        listener = socket.create_server((HOST, port))
    except OSError as error:
        raise FoldingError(
            f"Port {port} cannot be used ({error.strerror}); choose another with --port, or leave it out."
        ) from error
    with listener:
        tell(f"http://{HOST}:{listener.getsockname()[1]}/")
        config = uvicorn.Config(application, log_level="warning", access_log=False)
        anyio.run(uvicorn.Server(config).serve, [listener])


def page_app(model: LocalModel) -> Starlette:
    """The page at ``/`` and its tool calls at ``/call``: ``{"name", "arguments"}`` as JSON, answered as MCP does."""

    async def page(_request: Request) -> HTMLResponse:
        return HTMLResponse(page_html(model.view(), ENDPOINT))

    async def call(request: Request) -> Response:
        """Other sites cannot send JSON without asking first, and are not answered when they ask."""
        if request.headers.get("content-type", "").partition(";")[0].strip() != "application/json":
            return Response("Calls are JSON.", status_code=415)
        try:
            asked = Call.model_validate_json(await request.body())
        except ValidationError:
            return Response("A call is an object with a name and arguments.", status_code=400)
        return JSONResponse(model.call(asked.name, asked.arguments))

    return Starlette(
        routes=[Route("/", page), Route(f"/{ENDPOINT}", call, methods=["POST"])],
        middleware=[Middleware(TrustedHostMiddleware, allowed_hosts=ACCEPTED_NAMES)],
    )
