"""Connections of a server over HTTP: how fast they answer, how long they may be idle, how they end."""

import re
import signal
import socket
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import anyio
import httpx2
import pytest
import uvicorn
from folding_server.mcp.http.address import Address, AddressError, is_local, listen
from folding_server.mcp.http.connections import IDLE_SECONDS
from folding_server.mcp.http.serving import configuration
from hosts import Host, HttpProcess, http_process
from mcp import Client, MCPError
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.types import Receive, Scope, Send

HALF_A_POST = (
    b"POST /mcp HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
    b"Accept: application/json, text/event-stream\r\nContent-Length: 100\r\n\r\n{"
)
HALF_A_HEAD = HALF_A_POST[:40]
EVERYWHERE = "0.0.0.0"  # noqa: S104 - it is not served on
PROMISED_SECONDS = 5
"""Within which the server ends after SIGTERM."""


async def echo(scope: Scope, receive: Receive, send: Send) -> None:
    """Answer a request with its body."""
    body = await Request(scope, receive).body()
    await PlainTextResponse(body or b"nothing")(scope, receive, send)


@contextmanager
def echoing(idle_seconds: int) -> Iterator[tuple[str, int]]:
    """A server of echoes in a thread; yields where it listens."""
    with listen(Address("127.0.0.1", 0)) as listener:
        web = uvicorn.Server(configuration(echo, idle_seconds))
        thread = threading.Thread(target=anyio.run, args=(web.serve, [listener]))
        thread.start()
        try:
            yield listener.getsockname()[:2]
        finally:
            web.should_exit = True
            thread.join()


def closed_after(place: tuple[str, int], *parts: bytes, pause: float = 0.0) -> float:
    """The seconds from sending the last part of a request to the end of its connection."""
    with socket.create_connection(place, timeout=20) as connection:
        for part in parts:
            time.sleep(pause)
            connection.sendall(part)
        began = time.monotonic()
        while connection.recv(4096):
            pass
        return time.monotonic() - began


@pytest.mark.slow
@pytest.mark.parametrize(
    "parts",
    [
        (),
        (HALF_A_HEAD,),
        (HALF_A_POST,),
        (b"GET /x HTTP/1.1\r\nHost: x\r\n\r\n",),
        (b"GET /x HTTP/1.1\r\nHost: x\r\n\r\n" + HALF_A_HEAD,),
        (b"GET /x HTTP/1.1\r\nHost: x\r\n\r\n" + HALF_A_POST,),
    ],
    ids=[
        "silent",
        "half a head",
        "half a body",
        "answered",
        "answered, half a head",
        "answered, half a body",
    ],
)
def test_an_idle_connection_is_closed(parts: tuple[bytes, ...]) -> None:
    with echoing(idle_seconds=1) as place:
        assert 0.7 < closed_after(place, *parts) < 10


def test_drops_do_not_keep_a_connection_open() -> None:
    with echoing(idle_seconds=1) as place, socket.create_connection(place, timeout=20) as connection:
        connection.sendall(HALF_A_POST)
        began = time.monotonic()
        connection.settimeout(0.2)
        while time.monotonic() - began < 15:
            try:
                if not connection.recv(100):
                    break
            except TimeoutError:
                connection.sendall(b" ")
            except ConnectionError:
                break
        assert time.monotonic() - began < 10


def test_a_connection_in_use_stays_open() -> None:
    with echoing(idle_seconds=1) as place, httpx2.Client(base_url=f"http://{place[0]}:{place[1]}") as web:
        streams = set()
        for _ in range(6):
            answer = web.post("/x", content=b"again")
            assert answer.text == "again"
            streams.add(answer.extensions["network_stream"].get_extra_info("client_addr"))
            time.sleep(0.3)
        assert len(streams) == 1


def test_a_connection_outlasts_the_pause_after_which_clients_give_it_up() -> None:
    assert IDLE_SECONDS > 2 * 5


def said_to(place: tuple[str, int], *parts: bytes) -> bytes:
    """All that a server answers to what is sent in parts, until it closes the connection."""
    with socket.create_connection(place, timeout=20) as connection:
        for part in parts:
            connection.sendall(part)
        answer = b""
        with suppress(ConnectionError):
            while read := connection.recv(65_536):
                answer += read
    return answer


def test_a_head_without_end_is_refused() -> None:
    with echoing(20) as place:
        answer = said_to(place, b"GET / HTTP/1.1\r\n", *[b"X-More: " + b"x" * 1000 + b"\r\n"] * 70)
    assert answer.startswith(b"HTTP/1.1 431 ")


def test_long_bodies_and_many_requests_are_no_long_head() -> None:
    body = b"x" * 300_000
    post = b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: %d\r\n\r\n" % len(body)
    ask = b"GET / HTTP/1.1\r\nHost: a\r\nX-More: " + b"x" * 1000 + b"\r\n\r\n"
    end = b"GET / HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n"
    with echoing(20) as place:
        assert said_to(place, post + body, end).count(b"HTTP/1.1 200") == 2
        assert said_to(place, *[ask] * 100, end).count(b"HTTP/1.1 200") == 101


def test_an_answer_does_not_wait_for_an_acknowledgement() -> None:
    """Without TCP_NODELAY each answer after the first takes 40 ms and more, whatever the machine."""
    with echoing(idle_seconds=20) as place, httpx2.Client(base_url=f"http://{place[0]}:{place[1]}") as web:
        seconds = []
        for _ in range(40):
            began = time.perf_counter()
            web.get("/x")
            seconds.append(time.perf_counter() - began)
    assert statistics.quantiles(seconds, n=4)[0] < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("sent", [(), (HALF_A_HEAD,), (HALF_A_POST,), (HALF_A_HEAD, HALF_A_POST, b"")])
def test_sigterm_ends_the_server_whatever_is_half_sent(tmp_path: Path, sent: tuple[bytes, ...]) -> None:
    with http_process(tmp_path) as process:
        connections = [socket.create_connection(process.place, timeout=20) for _ in sent]
        for connection, part in zip(connections, sent, strict=True):
            connection.sendall(part)
        httpx2.get(process.url.replace("/mcp", "/health"))
        seconds, said = ended(process)
        for connection in connections:
            connection.close()
    assert seconds < PROMISED_SECONDS
    assert said == ""
    assert process.process.returncode == -signal.SIGTERM


def ended(process: HttpProcess) -> tuple[float, str]:
    """The seconds that a server needs to end after SIGTERM, and what it said on the way."""
    began = time.monotonic()
    said = process.end()
    return time.monotonic() - began, said


@pytest.mark.slow
@pytest.mark.anyio
async def test_sigterm_ends_the_server_while_hosts_are_connected(tmp_path: Path) -> None:
    with http_process(tmp_path) as process:
        try:
            async with Client(process.url) as new, Client(process.url, mode="legacy") as old:
                for client in (new, old):
                    await Host(client).call("open_run")
                seconds, said = await anyio.to_thread.run_sync(ended, process)
        except* httpx2.TransportError:
            pass
    assert seconds < PROMISED_SECONDS
    assert "Traceback" not in said


BUSY = """
import sys, time
from pathlib import Path
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.http.address import Address
from folding_server.mcp.http import serving
from folding_server.mcp.server import FoldingServer
from mcp.server.mcpserver.tools import Tool

def compute() -> str:
    sys.stderr.write("computing\\n")
    time.sleep(60)
    return "done"

class Busy(FoldingServer):
    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.add_tool(compute, structured_output=False)
        self.catalogue = {**self.catalogue, "compute": Tool.from_function(compute)}

serving.FoldingServer = Busy
with AppContext(ServerSettings(Path(sys.argv[1]), shared=True)) as app:
    serving.serve(app, Address("127.0.0.1", 0))
"""


@pytest.mark.slow
def test_sigterm_ends_the_server_while_a_tool_computes(tmp_path: Path) -> None:
    command = [sys.executable, "-c", BUSY, str(tmp_path)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        found = re.search(r"http://\S+", process.stderr.readline())
        assert found
        calling = threading.Thread(target=anyio.run, args=(call_compute, found.group()))
        calling.start()
        assert process.stderr.readline() == "computing\n"
        seconds, _ = ended(HttpProcess(process, found.group()))
        calling.join()
    assert seconds < PROMISED_SECONDS


async def call_compute(url: str) -> None:
    """Call the tool; the server does not live to answer."""
    with suppress(ExceptionGroup, MCPError):
        async with Client(url) as client:
            await client.call_tool("compute", {})


def test_only_loopback_addresses_are_local() -> None:
    for host, local in (("127.0.0.1", True), ("localhost", True), ("127.0.0.2", True), (EVERYWHERE, False)):
        with listen(Address(host, 0)) as listener:
            assert is_local(listener) is local


def test_an_address_in_use_is_refused_in_one_sentence() -> None:
    with (
        listen(Address("127.0.0.1", 0)) as taken,
        pytest.raises(AddressError, match="choose another address with --http"),
    ):
        listen(Address("127.0.0.1", taken.getsockname()[1]))
