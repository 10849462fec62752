"""A server over HTTP in a thread of this process, and hosts that show it the tokens of owners."""

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path

import httpx2
from folding_server.mcp.auth import read_tokens
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.http.address import Address, listen
from folding_server.mcp.http.names import AcceptedNames
from folding_server.mcp.http.serving import configuration, http_app
from folding_server.mcp.server import FoldingServer
from hosts import Host
from mcp import Client
from mcp.client.streamable_http import streamable_http_client
from web_threads import serving_in_a_thread


@contextmanager
def served_to(settings: ServerSettings, folder: Path, *owners: str) -> Iterator[str]:
    """A server with a token for each owner, whose token file lies in a folder; yields its URL."""
    tokens = folder / "tokens"
    tokens.write_text("".join(f"{owner} {_token(owner)}\n" for owner in owners))
    tokens.chmod(0o600)
    with AppContext(settings) as app, listen(Address("127.0.0.1", 0)) as listener:
        server = http_app(FoldingServer(app, read_tokens(tokens)), AcceptedNames.of("127.0.0.1"))
        with serving_in_a_thread(configuration(server), listener) as url:
            yield url


@asynccontextmanager
async def called_by(owner: str, url: str, mode: str = "auto") -> AsyncIterator[Host]:
    """A host that shows the token of an owner."""
    headers = {"Authorization": f"Bearer {_token(owner)}"}
    async with (
        httpx2.AsyncClient(headers=headers, timeout=60) as web,
        Client(streamable_http_client(url, http_client=web), mode=mode) as client,
    ):
        yield Host(client)


def _token(owner: str) -> str:
    return f"{owner}-0123456789abcdef"
