"""Serving a site on this machine alone while runs go on, and building it again when they changed."""

import asyncio
import socket
from collections.abc import Callable

import anyio
import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.routing import Mount
from starlette.staticfiles import StaticFiles

from folding_client.interrupts import UsageError
from folding_client.report.site import SiteBuilder

LOOPBACK = "127.0.0.1"
_NAMES = [LOOPBACK, "localhost"]
"""The names under which requests are accepted: no web page may read the site under a name of its own."""
LOOK_SECONDS = 2.0
"""Between two looks at the run folders: a frame takes seconds, and looking costs a few calls to the system a run."""

_LAST_ANSWERS_SECONDS = 1
"""How long answers under way may take when the command is ended."""


async def watch_site(builder: SiteBuilder, port: int, say: Callable[[str], None]) -> None:
    """Serve and rebuild until cancelled. ``say`` is told the address and each page that changed. UsageError if the port is
    taken.
    """
    try:
        listener = socket.create_server((LOOPBACK, port))
    except OSError as error:
        message = (
            f"Port {port} cannot be used ({error.strerror}); choose another with --port, or leave it out."
        )
        raise UsageError(message) from error
    with listener:
        await builder.build()
        say(f"http://{LOOPBACK}:{listener.getsockname()[1]}/")
        server = uvicorn.Server(_config(builder))
        serving = asyncio.create_task(server._serve([listener]))  # noqa: SLF001 - serve() takes over Ctrl-C
        try:
            await _rebuild(builder, say)
        finally:
            server.should_exit = True
            with anyio.CancelScope(shield=True):
                await serving


async def _rebuild(builder: SiteBuilder, say: Callable[[str], None]) -> None:
    """Build again and again; nothing is done while nothing changed. What cannot be read is said, once, and tried again."""
    trouble = ""
    while True:
        await asyncio.sleep(LOOK_SECONDS)
        try:
            for name in await builder.build():
                say(f"changed: {name}")
            trouble = ""
        except (UsageError, OSError) as error:
            if str(error) != trouble:
                trouble = str(error)
                say(trouble)


def _config(builder: SiteBuilder) -> uvicorn.Config:
    return uvicorn.Config(
        _site_app(builder),
        log_level="warning",
        access_log=False,
        timeout_graceful_shutdown=_LAST_ANSWERS_SECONDS,
    )


def _site_app(builder: SiteBuilder) -> Starlette:
    return Starlette(
        routes=[Mount("/", StaticFiles(directory=builder.files.folder, html=True))],
        middleware=[Middleware(TrustedHostMiddleware, allowed_hosts=_NAMES)],
    )
