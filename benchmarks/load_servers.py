"""The servers of ``benchmarks/load.py``: ours, and a plain one of the SDK with a tool that does nothing."""

import asyncio
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import uvicorn
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.http.address import Address, listen
from folding_server.mcp.http.names import AcceptedNames
from folding_server.mcp.http.serving import HttpServer, configuration, http_app
from folding_server.mcp.server import FoldingServer
from mcp.server.mcpserver import MCPServer
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp

LOCAL = "127.0.0.1"


@contextmanager
def server_process(command: list[str]) -> Iterator[str]:
    """A process that says on stderr where it serves; its URL."""
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr
            line = process.stderr.readline()
            found = re.search(r"http://\S+", line)
            assert found, f"the server did not start: {line}"
            yield found.group()
        finally:
            process.terminate()


def our_server(folder: Path, database: str | None) -> None:
    """Be our server until told to end."""
    with AppContext(ServerSettings(folder, database, shared=True)) as app:
        app.prepare()
        server = FoldingServer(app)
        with_cpu_time(server)
        application = http_app(server, AcceptedNames.of(LOCAL))
        serve_until_told(HttpServer(configuration(application)))


def empty_server() -> None:
    """Be a server as the SDK's documentation has it, until told to end."""

    def nothing() -> None:
        """Do nothing."""

    server = MCPServer("empty", log_level="WARNING")
    server.add_tool(nothing, structured_output=False)
    with_cpu_time(server)
    application: ASGIApp = server.streamable_http_app()
    serve_until_told(uvicorn.Server(uvicorn.Config(application, log_level="warning", access_log=False)))


def with_cpu_time(server: MCPServer[Any]) -> None:
    """Have the server tell at ``/cpu`` how many seconds of the processor its process has used."""

    @server.custom_route("/cpu", methods=["GET"])  # type: ignore[untyped-decorator]
    async def cpu(_request: Request) -> PlainTextResponse:
        """Tell."""
        return PlainTextResponse(str(time.process_time()))


def serve_until_told(web: uvicorn.Server) -> None:
    """Serve on a free port, and say on stderr where."""
    with listen(Address(LOCAL, 0)) as listener:
        sys.stderr.write(f"http://{LOCAL}:{listener.getsockname()[1]}/mcp\n")
        sys.stderr.flush()
        asyncio.run(web.serve([listener]))
