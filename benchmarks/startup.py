"""Measure the server as hosts feel it: ``python benchmarks/startup.py`` prints one JSON document.

``start`` is the time from spawning the process to the answer of its handshake, as new hosts do it (``discover``)
and old ones (``initialize``), with ``python -c pass`` for comparison. ``call`` is one ``fold`` and one ``rotate`` that are
undone each time, and ``get_current_state``, over stdio, over HTTP and in memory, each on a fresh SQLite file. The three
servers are asked in turn, so that whatever else the machine does weighs on all alike. ``health`` is ``GET /health`` on one
kept connection. All times are in milliseconds. ``--calls 200 --starts 1`` compares the transports alone.
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
from collections import defaultdict
from collections.abc import AsyncIterator, Iterator
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.server import FoldingServer
from mcp import Client, StdioServerParameters


def main() -> None:
    """Run the benchmark and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--starts", type=int, default=10, help="processes started of each kind (default 10)")
    parser.add_argument("--calls", type=int, default=100, help="calls measured of each kind (default 100)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        figures = asyncio.run(measure(Path(folder), options.starts, options.calls))
    json.dump(figures, sys.stdout, indent=2)
    sys.stdout.write("\n")


async def measure(folder: Path, starts: int, calls: int) -> dict[str, object]:
    """All figures, and the load of the machine while they were taken."""
    return {
        "cores": os.cpu_count(),
        "load_before": round(os.getloadavg()[0], 2),
        "start": {
            "python": spread([bare_python() for _ in range(starts)]),
            "discover": spread([await started(folder, "auto") for _ in range(starts)]),
            "initialize": spread([await started(folder, "legacy") for _ in range(starts)]),
        },
        **await transports(folder, calls),
        "load_after": round(os.getloadavg()[0], 2),
    }


def process(data: Path) -> StdioServerParameters:
    """The server process that a desktop host would start."""
    return StdioServerParameters(
        command=sys.executable,
        args=["-m", "folding_server", "--data", str(data)],
        env={"PATH": os.environ["PATH"]},
    )


def bare_python() -> float:
    """The time that Python itself takes to start and end."""
    began = time.perf_counter()
    subprocess.run([sys.executable, "-c", "pass"], check=True)
    return time.perf_counter() - began


async def started(folder: Path, mode: str) -> float:
    """The time from spawning a server to its answered handshake."""
    began = time.perf_counter()
    async with Client(process(folder), mode=mode):
        return time.perf_counter() - began


@contextmanager
def http_process(data: Path) -> Iterator[str]:
    """A server process that listens on a free local port; its URL."""
    command = [sys.executable, "-m", "folding_server", "--http", "127.0.0.1:0", "--data", str(data)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None, "it is piped"
        found = re.search(r"http://\S+", process.stderr.readline())
        assert found is not None, "the server says where it listens"
        try:
            yield found.group()
        finally:
            process.terminate()


@dataclass
class Caller:
    """A client with a run of its own, and the seconds that its calls took, by tool."""

    client: Client
    run_id: str
    seconds: defaultdict[str, list[float]] = field(default_factory=lambda: defaultdict(list))

    async def once(self) -> None:
        """A fold, a turn and a read of the state, and the paper as it was."""
        for tool, arguments in CALLS:
            self.seconds[tool].append(await timed(self.client, tool, {**arguments, "run_id": self.run_id}))
        for _ in range(2):
            await timed(self.client, "undo", {"run_id": self.run_id})


CALLS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("fold", {"edge": [1, 3], "direction": 1}),
    ("rotate", {"angle": 45}),
    ("get_current_state", {}),
)


@asynccontextmanager
async def callers(folder: Path, url: str) -> AsyncIterator[dict[str, Caller]]:
    """One caller over each transport."""
    async with AsyncExitStack() as stack:
        app = stack.enter_context(AppContext(ServerSettings(folder / "memory")))
        (folder / "memory").mkdir()
        connections = {
            "stdio": Client(process(folder / "stdio")),
            "http": Client(url),
            "memory": Client(FoldingServer(app)),
        }
        opened = {}
        for name, connection in connections.items():
            client = await stack.enter_async_context(connection)
            result = await client.call_tool("open_run", {})
            opened[name] = Caller(client, (result.structured_content or {})["run_id"])
        yield opened


async def transports(folder: Path, count: int) -> dict[str, object]:
    """The latency of calls over each transport, and of ``/health``."""
    with http_process(folder / "http") as url:
        async with callers(folder, url) as all_callers:
            for _ in range(count):
                for caller in all_callers.values():
                    await caller.once()
            spreads = {
                name: {tool: spread(seconds) for tool, seconds in caller.seconds.items()}
                for name, caller in all_callers.items()
            }
        return {"call": spreads, "health": spread(await health(url, count))}


async def health(url: str, count: int) -> list[float]:
    """The times of looks at ``/health``."""
    seconds = []
    async with httpx2.AsyncClient() as web:
        for _ in range(count):
            began = time.perf_counter()
            (await web.get(url.replace("/mcp", "/health"))).raise_for_status()
            seconds.append(time.perf_counter() - began)
    return seconds


async def timed(client: Client, tool: str, arguments: dict[str, object]) -> float:
    """The time of one call that must succeed."""
    began = time.perf_counter()
    result = await client.call_tool(tool, arguments)
    took = time.perf_counter() - began
    if result.is_error:
        message = f"{tool} was refused: {result.content}"
        raise RuntimeError(message)
    return took


def spread(seconds: list[float]) -> dict[str, float]:
    """Least, median and largest, in milliseconds."""
    return {
        "min": round(1000 * min(seconds), 2),
        "median": round(1000 * statistics.median(seconds), 2),
        "max": round(1000 * max(seconds), 2),
    }


if __name__ == "__main__":
    main()
