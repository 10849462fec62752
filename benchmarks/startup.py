"""Measure the server as hosts feel it: ``python benchmarks/startup.py`` prints one JSON document.

``start`` is the time from spawning the process to the answer of its handshake, as new hosts do it (``discover``)
and old ones (``initialize``), with ``python -c pass`` for comparison. ``call`` is one ``fold`` that is undone each
time, and ``get_current_state``, over stdio and in memory, on a fresh SQLite file. All times are in milliseconds.
"""

import argparse
import asyncio
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

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
        "call": {
            "stdio": await calls_over(Client(process(folder / "stdio")), calls),
            "memory": await calls_in_memory(folder / "memory", calls),
        },
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


async def calls_in_memory(data: Path, count: int) -> dict[str, object]:
    """The same calls without a process between."""
    with AppContext(ServerSettings(data)) as app:
        return await calls_over(Client(FoldingServer(app)), count)


async def calls_over(connection: Client, count: int) -> dict[str, object]:
    """Folds, undone each time, and reads of the state."""
    fold, read = [], []
    async with connection as client:
        await client.call_tool("open_run", {})
        for _ in range(count):
            fold.append(await timed(client, "fold", {"edge": [1, 3], "direction": 1}))
            read.append(await timed(client, "get_current_state", {}))
            await client.call_tool("undo", {})
    return {"fold": spread(fold), "get_current_state": spread(read)}


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
        "min": round(1000 * min(seconds), 1),
        "median": round(1000 * statistics.median(seconds), 1),
        "max": round(1000 * max(seconds), 1),
    }


if __name__ == "__main__":
    main()
