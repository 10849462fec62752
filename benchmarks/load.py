"""Measure one server process under load: ``python benchmarks/load.py`` prints one JSON document.

``--clients`` hosts fold ``--runs`` runs over HTTP, each its own, call after call without a pause: the program of PROGRAM, of
which every state that is answered is compared with the one that the simulator gives here. ``replay`` is calls a second and
the times of a call as its host sees them, in milliseconds; ``nothing`` the same for as many calls of a tool that does nothing,
which is what protocol, HTTP and the hosts themselves cost. The hosts share the machine with the server, so that a
figure means something only beside the number of cores and what else the machine did.
"""

import argparse
import asyncio
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx2
from folding_schemas.actions import Action, AddVertex, Flip, Fold, Rotate, Unfold
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.http.address import Address, listen
from folding_server.mcp.http.names import AcceptedNames
from folding_server.mcp.http.serving import HttpServer, configuration, http_app
from folding_server.mcp.server import FoldingServer
from folding_server.mcp.services.replay_cache import ReplayCache
from folding_server.simulator import folded_state
from mcp import Client
from mcp.client.streamable_http import streamable_http_client
from mcp.server.mcpserver.tools import Tool

PROGRAM: tuple[Action, ...] = (
    AddVertex(edge=(1, 2), position=0.5),
    AddVertex(edge=(4, 3), position=0.5),
    Fold(edge=(5, 6), direction=1),
    Rotate(angle=45),
    Flip(axis="x"),
    Unfold(),
    Rotate(angle=45),
    Fold(edge=(1, 3), direction=1),
    Flip(axis="y"),
    Rotate(angle=-90),
)
"""What each run folds: every kind of action, in half of the calls on more than one layer."""

Caller = Callable[[str, dict[str, Any]], Awaitable[dict[str, Any]]]
"""Calls a tool and gives its structured answer."""


def main() -> None:
    """Run the benchmark and print its figures, or be the server that it measures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clients", type=int, default=20, help="hosts at once (default 20)")
    parser.add_argument("--runs", type=int, default=100, help="runs that they fold together (default 100)")
    parser.add_argument("--database", help="keep the runs there (default: SQLite in a temporary folder)")
    parser.add_argument("--serve", type=Path, metavar="DIR", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        serve_with_nothing(options.serve, options.database)
        return
    with tempfile.TemporaryDirectory() as folder, server_process(folder, options.database) as url:
        figures = asyncio.run(measure(url, options.clients, options.runs))
    json.dump(figures, sys.stdout, indent=2)
    sys.stdout.write("\n")


async def measure(url: str, clients: int, runs: int) -> dict[str, Any]:
    """All figures, and the load of the machine while they were taken."""
    expected = states()
    shares = [runs // clients + (number < runs % clients) for number in range(clients)]
    figures: dict[str, Any] = {"cores": os.cpu_count(), "load_before": round(os.getloadavg()[0], 2)}

    async def replay(call: Caller, share: int) -> None:
        for _ in range(share):
            await folded(call, expected)

    async def nothing(call: Caller, share: int) -> None:
        for _ in range(share * (len(PROGRAM) + 1)):
            await call("nothing", {})

    for work in (nothing, replay):
        figures[work.__name__] = await under_load(url, shares, work)
    figures["times_of_nothing"] = round(figures["nothing"]["per_second"] / figures["replay"]["per_second"], 2)
    return {**figures, "load_after": round(os.getloadavg()[0], 2)}


def states() -> list[Any]:
    """The state after each action of the program, as it travels."""
    replays = ReplayCache()
    return [
        json.loads(folded_state(replays.after((1.0, 1.0), PROGRAM[:count])).model_dump_json())
        for count in range(1, len(PROGRAM) + 1)
    ]


async def folded(call: Caller, expected: list[Any]) -> None:
    """Fold the program in a run of its own."""
    run_id = (await call("open_run", {}))["run_id"]
    for action, state in zip(PROGRAM, expected, strict=True):
        arguments = action.model_dump(mode="json", exclude_none=True)
        answer = await call(arguments.pop("action"), {**arguments, "run_id": run_id})
        if answer["state"] != state:
            raise SystemExit(
                f"load: after {action} in run {run_id} the server answers another state than the simulator"
            )


async def under_load(
    url: str, shares: list[int], work: Callable[[Caller, int], Awaitable[None]]
) -> dict[str, Any]:
    """Calls a second and the times of a call while all hosts do their share of the work."""
    times: list[float] = []
    ready = asyncio.Barrier(len(shares))

    async def host(share: int) -> float:
        async with (
            httpx2.AsyncClient(timeout=60) as web,
            Client(streamable_http_client(url, http_client=web)) as client,
        ):
            await ready.wait()
            began = time.perf_counter()
            await work(timed(client, times), share)
            return began

    began = min(await asyncio.gather(*map(host, shares)))
    seconds = time.perf_counter() - began
    cuts = statistics.quantiles(times, n=100)
    return {
        "calls": len(times),
        "per_second": round(len(times) / seconds, 1),
        "p50": round(1000 * cuts[49], 1),
        "p99": round(1000 * cuts[98], 1),
    }


def timed(client: Client, times: list[float]) -> Caller:
    """Calls of one host, each of which adds its time in seconds."""

    async def call(tool: str, arguments: dict[str, Any]) -> dict[str, Any]:
        began = time.perf_counter()
        answer = await client.call_tool(tool, arguments)
        times.append(time.perf_counter() - began)
        if answer.is_error:
            raise SystemExit(f"load: {tool} was refused: {answer.content}")
        return dict(answer.structured_content or {})

    return call


@contextmanager
def server_process(folder: str, database: str | None) -> Iterator[str]:
    """A server process with the tool ``nothing`` beside its own; its URL."""
    command = [sys.executable, __file__, "--serve", folder, *(["--database", database] if database else [])]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr
            found = re.search(r"http://\S+", process.stderr.readline())
            assert found, "the server did not start"
            yield found.group()
        finally:
            process.terminate()


def serve_with_nothing(folder: Path, database: str | None) -> None:
    """Be the server, until told to end."""

    def nothing() -> None:
        """Do nothing."""

    with (
        AppContext(ServerSettings(folder, database, shared=True)) as app,
        listen(Address("127.0.0.1", 0)) as listener,
    ):
        app.prepare()
        server = FoldingServer(app)
        server.add_tool(nothing, structured_output=False)
        server.catalogue = {**server.catalogue, "nothing": Tool.from_function(nothing)}
        web = HttpServer(configuration(http_app(server, AcceptedNames.of("127.0.0.1"))))
        sys.stderr.write(f"http://127.0.0.1:{listener.getsockname()[1]}/mcp\n")
        sys.stderr.flush()
        asyncio.run(web.serve([listener]))


if __name__ == "__main__":
    main()
