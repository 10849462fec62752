"""How long a fold takes while the server sees: ``python benchmarks/responsiveness.py`` prints one JSON document.

A server process over HTTP is asked by two hosts, each with a run of its own, to propose actions for one photo after the other,
while a third folds and takes back ``--folds`` times in another run, with a pause between two calls. ``processes`` has its
figures with ``--vision-workers 2``, ``threads`` those with ``--vision-workers 0``, where the server sees in its own process, and
``nothing_else`` those of folds alone. Times are as the third host sees them, in milliseconds; ``first_proposal_ms`` is the
first call for a photo after the server has started, ``proposals`` how many were answered meanwhile, and ``megabytes`` the
memory of the server and of all its processes at the end (Linux). The first fold, for which the server loads what it needs, is
not counted. A fold waits for the disk that its run is stored on: with ``TMPDIR=/dev/shm`` that is left out. The hosts share the machine with the server, so that a figure
means something only beside the number of cores and what else the machine did.
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
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2
from mcp import Client
from mcp.client.streamable_http import streamable_http_client

ROOT = Path(__file__).resolve().parent.parent
SEQUENCES = ("cat", "heart")
"""Of the examples: what the two hosts ask about."""
PAUSE_SECONDS = 0.05
"""Between two calls of the host that folds."""
GOAL_MS = 30
"""Within which a fold is to be answered while two calls for photos are computed (the 95th percentile)."""


@dataclass
class Measured:
    """What was measured of one server, in milliseconds."""

    folds: list[float] = field(default_factory=list)
    proposals: list[float] = field(default_factory=list)
    megabytes: int = 0


def main() -> None:
    """Run the benchmark and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folds", type=int, default=100, help="how many folds are timed (default 100)")
    options = parser.parse_args()
    figures: dict[str, Any] = {"cores": os.cpu_count(), "load_before": round(os.getloadavg()[0], 2)}
    for name, workers, asking in (
        ("nothing_else", 2, ()),
        ("processes", 2, SEQUENCES),
        ("threads", 0, SEQUENCES),
    ):
        with tempfile.TemporaryDirectory() as folder, server_process(folder, workers) as (process, url):
            measured = asyncio.run(measure(process, url, options.folds, asking))
        figures[name] = summary(measured)
        sys.stderr.write(f"responsiveness: {name} {figures[name]}\n")
    figures["load_after"] = round(os.getloadavg()[0], 2)
    figures["goal_ms"], figures["goal_met"] = GOAL_MS, figures["processes"]["fold_p95_ms"] <= GOAL_MS
    json.dump(figures, sys.stdout, indent=2)
    sys.stdout.write("\n")


async def measure(process: int, url: str, folds: int, asking: tuple[str, ...]) -> Measured:
    """Fold while there are hosts that ask about each of the sequences."""
    measured, ready, over = Measured(), asyncio.Barrier(len(asking) + 1), asyncio.Event()

    async def reconstruct(sequence: str) -> None:
        begun = False
        async with host(url) as client:
            while not over.is_set():
                async for milliseconds in proposals(client, sequence):
                    measured.proposals.append(milliseconds)
                    if not begun:
                        begun = True
                        await ready.wait()
                    if over.is_set():
                        return

    async with asyncio.TaskGroup() as group:
        for sequence in asking:
            group.create_task(reconstruct(sequence))
        async with host(url) as client:
            run_id = await called(client, "open_run")
            await ready.wait()
            for number in range(folds + 1):
                took = await timed(client, "fold", run_id=run_id, edge=[1, 3], direction=1)
                measured.folds += [took] if number else []
                await called(client, "undo", run_id=run_id)
                await asyncio.sleep(PAUSE_SECONDS)
        measured.megabytes = sum(map(megabytes, (process, *children(process))))
        over.set()
    return measured


async def proposals(client: Client, sequence: str) -> AsyncIterator[float]:
    """The times of the proposals for each photo of a sequence, which is folded meanwhile as its program says."""
    program = json.loads((ROOT / "examples" / sequence / "program.json").read_text(encoding="utf-8"))
    run_id = await called(client, "open_run", sequence=sequence)
    await called(client, "save_checkpoint", run_id=run_id, frame=1)
    for frame, step in enumerate(program["steps"], start=2):
        yield await timed(client, "propose_actions", run_id=run_id, frame=frame)
        for action in step:
            arguments = {key: value for key, value in action.items() if key != "action"}
            await called(client, action["action"], run_id=run_id, **arguments)
        await called(client, "save_checkpoint", run_id=run_id, frame=frame)


@asynccontextmanager
async def host(url: str) -> AsyncIterator[Client]:
    """A host on a connection of its own."""
    async with (
        httpx2.AsyncClient(timeout=300) as web,
        Client(streamable_http_client(url, http_client=web)) as client,
    ):
        yield client


async def called(client: Client, tool: str, **arguments: Any) -> str:
    """The run that a call was for. SystemExit if it is refused."""
    answer = await client.call_tool(tool, arguments)
    if answer.is_error:
        raise SystemExit(f"responsiveness: {tool} was refused: {answer.content}")
    return str((answer.structured_content or {}).get("run_id"))


async def timed(client: Client, tool: str, **arguments: Any) -> float:
    """The milliseconds of a call."""
    begun = time.perf_counter()
    await called(client, tool, **arguments)
    return 1000 * (time.perf_counter() - begun)


def summary(measured: Measured) -> dict[str, Any]:
    """The figures of one server."""
    cuts = statistics.quantiles(measured.folds, n=20)
    folds = {
        "fold_p50_ms": round(cuts[9], 1),
        "fold_p95_ms": round(cuts[18], 1),
        "fold_worst_ms": round(max(measured.folds), 1),
        "megabytes": measured.megabytes,
    }
    if not measured.proposals:
        return folds
    first, later = measured.proposals[: len(SEQUENCES)], measured.proposals[len(SEQUENCES) :]
    return {
        **folds,
        "first_proposal_ms": round(max(first)),
        "proposals": len(later),
        "proposal_p50_ms": round(statistics.median(later)) if later else None,
    }


@contextmanager
def server_process(folder: str, workers: int) -> Iterator[tuple[int, str]]:
    """A server process with so many workers: its id and its URL."""
    options = ["--sequences", str(ROOT / "examples"), "--data", folder, "--vision-workers", str(workers)]
    command = [sys.executable, "-m", "folding_server", "--http", "127.0.0.1:0", *options]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr
            found = re.search(r"http://\S+", process.stderr.readline())
            assert found, "the server did not start"
            yield process.pid, found.group()
        finally:
            process.terminate()


def children(process: int) -> list[int]:
    """The processes that a process has started; none where the system does not tell."""
    try:
        told = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="ascii")
        threads = Path(f"/proc/{process}/task").iterdir()
        told = " ".join((each / "children").read_text(encoding="ascii") for each in threads)
    except OSError:
        return []
    return [int(each) for each in told.split()]


def megabytes(process: int) -> int:
    """The memory that a process has in use; 0 where the system does not tell."""
    try:
        status = Path(f"/proc/{process}/status").read_text(encoding="ascii")
    except OSError:
        return 0
    return int(re.search(r"VmRSS:\s+(\d+)", status).group(1)) // 1024  # type: ignore[union-attr]


if __name__ == "__main__":
    main()
