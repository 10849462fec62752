"""Under which names a server over HTTP answers, and which web pages may call it."""

import logging
from pathlib import Path

import httpx2
import pytest
from folding_server.mcp.http.names import LONGEST_LOGGED, MOST_LOGGED, AcceptedNames, guarded
from hosts import http_process
from mcp import Client, MCPError
from mcp.client.streamable_http import streamable_http_client
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse
from starlette.routing import Route

pytestmark = pytest.mark.anyio

PING = {"jsonrpc": "2.0", "id": 1, "method": "ping"}
ASKS = {"Access-Control-Request-Method": "POST", "Access-Control-Request-Headers": "authorization,mcp-method"}
ACCEPT = {"Accept": "application/json, text/event-stream"}


def local(*known_as: str) -> httpx2.AsyncClient:
    """A web client of an application that is guarded, without a network."""

    async def answer(_request: object) -> PlainTextResponse:
        return PlainTextResponse("answered", headers={"Mcp-Session-Id": "1"})

    routes = [Route(path, answer, methods=["GET", "POST"]) for path in ("/mcp", "/health")]
    app = guarded(Starlette(routes=routes), AcceptedNames.of("127.0.0.1", known_as), exempt=("/health",))
    return httpx2.AsyncClient(transport=httpx2.ASGITransport(app=app), base_url="http://127.0.0.1:8000")


async def test_a_page_of_an_accepted_origin_may_ask_and_read_its_session(tmp_path: Path) -> None:
    page = {"Origin": "http://localhost:6274"}
    with http_process(tmp_path) as process:
        async with httpx2.AsyncClient() as web:
            preflight = await web.options(process.url, headers={**page, **ASKS})
            opening = {
                "jsonrpc": "2.0",
                "id": 1,
                "method": "initialize",
                "params": {
                    "protocolVersion": "2025-11-25",
                    "capabilities": {},
                    "clientInfo": {"name": "page", "version": "1"},
                },
            }
            opened = await web.post(process.url, json=opening, headers={**page, **ACCEPT})
            foreign = await web.options(process.url, headers={"Origin": "https://evil.example", **ASKS})
    assert preflight.status_code == 200
    assert preflight.headers["Access-Control-Allow-Origin"] == page["Origin"]
    assert "POST" in preflight.headers["Access-Control-Allow-Methods"]
    assert "mcp-method" in preflight.headers["Access-Control-Allow-Headers"]
    assert opened.status_code == 200
    assert opened.headers["Mcp-Session-Id"]
    assert "Mcp-Session-Id" in opened.headers["Access-Control-Expose-Headers"]
    assert opened.headers["Access-Control-Allow-Origin"] == page["Origin"]
    assert foreign.status_code == 403
    assert "Access-Control-Allow-Origin" not in foreign.headers


async def test_a_preflight_needs_no_token(tmp_path: Path) -> None:
    tokens = tmp_path / "tokens"
    tokens.write_text("alice alice-0123456789abcdef\n")
    tokens.chmod(0o600)
    page = {"Origin": "http://127.0.0.1:6274"}
    with http_process(tmp_path, "--token-file", str(tokens)) as process:
        async with httpx2.AsyncClient() as web:
            preflight = await web.options(process.url, headers={**page, **ASKS})
            refused = await web.post(process.url, json=PING, headers=page)
    assert preflight.status_code == 200
    assert refused.status_code == 401
    assert refused.headers["Access-Control-Allow-Origin"] == page["Origin"]
    assert "WWW-Authenticate" in refused.headers["Access-Control-Expose-Headers"]


@pytest.mark.slow
async def test_a_refused_host_is_logged_once_with_the_option_that_accepts_it(tmp_path: Path) -> None:
    with http_process(tmp_path) as process:
        async with httpx2.AsyncClient() as web:
            refused = [
                await web.post(process.url, json=PING, headers={"Host": f"paper.example:{port}"})
                for port in (80, 80, 8000)
            ]
            elsewhere = httpx2.AsyncClient(headers={"Host": "paper.example"})
            async with elsewhere:
                with pytest.raises((MCPError, ExceptionGroup)) as seen:
                    async with Client(streamable_http_client(process.url, http_client=elsewhere)):
                        pass
        said = process.end()
    assert {answer.status_code for answer in refused} == {421}
    assert said.count("paper.example") == 2, "the header and the option, in one line"
    assert said.count("\n") == 1
    assert "--known-as paper.example" in said
    assert "not known by the name" in str(leaf(seen.value))


def leaf(error: BaseException) -> BaseException:
    """What a group of errors is about."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return error


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Host": "localhost"}, 200),
        ({"Host": "[::1]:8000"}, 200),
        ({"Host": "paper.example:443"}, 200),
        ({"Host": "paperxexample"}, 421),
        ({"Host": "localhost.evil.example"}, 421),
        ({"Host": "localhost:80.evil.example"}, 421),
        ({"Host": "evil.example"}, 421),
        ({"Host": ""}, 421),
        ({"Origin": "https://paper.example"}, 200),
        ({"Origin": "http://localhost:5173"}, 200),
        ({"Origin": "https://localhost.evil.example"}, 403),
        ({"Origin": "https://evil.example/http://localhost"}, 403),
        ({"Origin": "file://localhost"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": ""}, 403),
    ],
    ids=str,
)
async def test_only_whole_names_are_accepted(headers: dict[str, str], status: int) -> None:
    async with local("paper.example") as web:
        assert (await web.post("/mcp", headers=headers)).status_code == status
        assert (await web.get("/health", headers=headers)).status_code in (200, 400)


async def test_names_that_are_made_up_do_not_fill_the_log(caplog: pytest.LogCaptureFixture) -> None:
    async with local() as web:
        for number in range(3 * MOST_LOGGED):
            host = f"{'x' * 500}{number}" if number == 0 else f"host{number}.example"
            await web.get("/mcp", headers={"Host": host})
    assert len(caplog.messages) == MOST_LOGGED
    assert max(map(len, caplog.messages)) < 3 * LONGEST_LOGGED + 100
    assert all(record.levelno == logging.WARNING for record in caplog.records)
