"""Servers around one store: two processes behind a balancer that knows no sessions, and owners through the protocol."""

import itertools
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import httpx2
import pytest
import uvicorn
from folding_server.mcp.http.address import Address, listen
from hosts import Host, http_process, http_server
from mcp import Client, MCPError
from mcp.client.streamable_http import streamable_http_client
from photographed import photos
from postgresql import empty_database
from sqlalchemy import create_engine
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route
from web_threads import serving_in_a_thread

ADA, BOB = "ada-0123456789abcdef", "bob-0123456789abcdef"
HELD_BACK = {"content-length", "transfer-encoding", "connection"}
"""Headers of one connection, which a proxy does not hand on."""


class Alternating:
    """A reverse proxy that hands each request to the next server in turn, and counts what each has answered."""

    def __init__(self, servers: list[str]) -> None:
        self.answered = dict.fromkeys(servers, 0)
        self._turns = itertools.cycle(servers)

    async def answer(self, request: Request) -> Response:
        """The next server's answer."""
        server = next(self._turns)
        headers = {name: value for name, value in request.headers.items() if name not in HELD_BACK}
        async with httpx2.AsyncClient(timeout=60) as web:
            answer = await web.request(request.method, server, content=await request.body(), headers=headers)
        self.answered[server] += answer.status_code == 200
        kept = {name: value for name, value in answer.headers.items() if name not in HELD_BACK}
        return Response(answer.content, answer.status_code, kept)


@contextmanager
def behind_a_proxy(proxy: Alternating) -> Iterator[str]:
    """The proxy's URL, while it serves in a thread."""
    application = Starlette(routes=[Route("/mcp", proxy.answer, methods=["GET", "POST", "DELETE"])])
    with listen(Address("127.0.0.1", 0)) as listener:
        config = uvicorn.Config(application, log_level="warning", ws="none")
        with serving_in_a_thread(config, listener) as url:
            yield url


@pytest.mark.slow
@pytest.mark.anyio
@pytest.mark.parametrize("kind", ["postgresql", "sqlite"])
async def test_calls_of_one_run_alternate_between_two_servers(kind: str, tmp_path: Path) -> None:
    with ExitStack() as running:
        url = running.enter_context(empty_database(kind, tmp_path))
        options = ("--database", url, "--sequences", str(photos()))
        servers = [running.enter_context(http_server(tmp_path, *options)) for _ in range(2)]
        proxy = Alternating(servers)
        address = running.enter_context(behind_a_proxy(proxy))
        async with Client(address) as client:
            host = Host(client)
            run_id = (await host.call("open_run", sequence="sailboat"))["run_id"]
            await host.call("save_checkpoint", frame=1, run_id=run_id)
            for angle in range(1, 9):
                turned = await host.call("rotate", angle=angle, run_id=run_id)
                assert turned["state"] == (await host.call("get_current_state", run_id=run_id))["state"]
            await host.call("undo", run_id=run_id)
            await host.call("save_checkpoint", frame=2, run_id=run_id)
            found = await host.call("get_run", run_id=run_id)
        assert min(proxy.answered.values()) >= 10
        seen = []
        for server in servers:
            async with Client(server) as client:
                seen.append(await Host(client).call("get_run", run_id=run_id))
    assert seen == [found, found]
    assert found["saved"] == [1, 2]


@pytest.mark.slow
@pytest.mark.anyio
async def test_a_server_goes_on_when_its_database_has_ended_all_connections(tmp_path: Path) -> None:
    """As after the database was started again: what was answered is there, and no call fails for it."""
    with empty_database("postgresql", tmp_path) as url, http_server(tmp_path, "--database", url) as address:
        async with Client(address) as client:
            host = Host(client)
            run_id = (await host.call("open_run"))["run_id"]
            engine = create_engine(url)
            with engine.connect() as connection:
                connection.exec_driver_sql(
                    "SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
                    "WHERE datname = current_database() AND pid <> pg_backend_pid()"
                )
            engine.dispose()
            await host.call("rotate", angle=30, run_id=run_id)


def bearing(token: str) -> httpx2.AsyncClient:
    """A web client that shows a token."""
    return httpx2.AsyncClient(headers={"Authorization": f"Bearer {token}"}, timeout=60)


@pytest.mark.anyio
async def test_owners_of_tokens_reach_their_own_runs_and_keep_to_their_limits(tmp_path: Path) -> None:
    (tmp_path / "tokens").write_text(f"ada {ADA}\nbob {BOB}\n")
    (tmp_path / "tokens").chmod(0o600)
    options = ("--token-file", str(tmp_path / "tokens"), "--limit", "runs=2", "--limit", "vision-seconds=0")
    with http_process(tmp_path, *options, "--sequences", str(photos())) as process:
        async with (
            bearing(ADA) as hers,
            bearing(BOB) as his,
            Client(streamable_http_client(process.url, http_client=hers)) as ada_client,
            Client(streamable_http_client(process.url, http_client=his)) as bob_client,
        ):
            ada, bob = Host(ada_client), Host(bob_client)
            run_id = (await ada.call("open_run", sequence="sailboat"))["run_id"]
            await ada.call("save_checkpoint", frame=1, run_id=run_id)
            for tool, arguments in (
                ("get_run", {}),
                ("open_run", {}),
                ("undo", {}),
                ("export_state", {"format": "fold"}),
                ("compare_to_frame", {"frame": 1}),
            ):
                assert f"There is no run '{run_id}'" in await bob.refusal(tool, run_id=run_id, **arguments)
            for resource in ("", "/state", "/program", "/diagram.svg"):
                assert await ada.client.read_resource(f"folding://runs/{run_id}{resource}")
                with pytest.raises(MCPError, match="There is no run"):
                    await bob.client.read_resource(f"folding://runs/{run_id}{resource}")
            assert "0 a day" in await ada.refusal("compare_to_frame", frame=1, run_id=run_id)
            await ada.call("open_run")
            assert "ada has 2 runs" in await ada.refusal("open_run")
            await bob.call("open_run")
