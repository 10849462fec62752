"""Measure one server process under load: ``python benchmarks/load.py`` prints one JSON document.

``--clients`` hosts fold ``--runs`` runs over HTTP, each its own, call after call without a pause: open a run, the program of
PROGRAM, read the state, save it. Every state that is answered is compared with the one that the simulator gives here.
Figures are calls a second, the times of a call as its host sees them in milliseconds, and the processor time that the
server spends on a call, in all its threads. ``empty`` is the same number of calls of a tool that does nothing on a plain
server of the SDK, with nothing of ours; ``alike`` folds the same program in every run, ``own`` turns every run's paper by
another angle, so that nothing computed for one run serves another. The three take turns, so that whatever else the
machine does weighs on all alike, and ``times_of_empty`` is how much more of the processor a call of ours takes.

The hosts share the machine with the server. They send requests made of bytes and look at the answers when the clock
stands, which takes little; ``--sdk-clients`` has the SDK's client instead, which takes about as much as the server. A
figure in seconds means something only beside the number of cores and what else the machine did: ``load`` is the load
average before and after.
"""

import argparse
import asyncio
import json
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from folding_schemas.actions import Action, AddVertex, Flip, Fold, Rotate, Unfold
from folding_server.mcp.services.replay_cache import ReplayCache
from folding_server.simulator import folded_state
from load_hosts import Answer, LoadHost, PlainHost, SdkHost, cpu_seconds, result_of
from load_servers import empty_server, our_server, server_process
from pydantic import TypeAdapter

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
CALLS = len(PROGRAM) + 3
"""The calls of a run: besides the program it is opened, read and saved."""
TURNS = 4
"""How often the kinds of work take turns."""
DEGREES_APART = 0.01
"""By how much the first turn of a run of its own differs from that of the run before."""

ACTION: TypeAdapter[Action] = TypeAdapter(Action)
ACTION_NAMES = frozenset(action.action for action in PROGRAM)
Call = tuple[str, dict[str, Any]]


def main() -> None:
    """Run the benchmark and print its figures, or be a server that it measures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clients", type=int, default=20, help="hosts at once (default 20)")
    parser.add_argument("--runs", type=int, default=100, help="runs that they fold together (default 100)")
    parser.add_argument("--database", help="keep the runs there (default: SQLite in a temporary folder)")
    parser.add_argument("--sdk-clients", action="store_true", help="hosts with the SDK's client")
    parser.add_argument("--serve", type=Path, metavar="DIR", help=argparse.SUPPRESS)
    parser.add_argument("--serve-empty", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve_empty:
        empty_server()
    elif options.serve:
        our_server(options.serve, options.database)
    else:
        with servers(options.database) as (empty, ours):
            kind: type[LoadHost] = SdkHost if options.sdk_clients else PlainHost
            figures = asyncio.run(measure(empty, ours, kind, options.clients, options.runs))
        json.dump(figures, sys.stdout, indent=2)
        sys.stdout.write("\n")


@contextmanager
def servers(database: str | None) -> Iterator[tuple[str, str]]:
    """The URLs of a plain server of the SDK and of ours, each a process."""
    command = [sys.executable, __file__]
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        empty = stack.enter_context(server_process([*command, "--serve-empty"]))
        kept = ["--database", database] if database else []
        yield empty, stack.enter_context(server_process([*command, "--serve", folder, *kept]))


@dataclass
class Work:
    """One kind of work, and what was measured of it: each call's seconds, the seconds in all and the server's."""

    url: str
    runs: Iterator[list[Call]]
    times: list[float] = field(default_factory=list)
    seconds: float = 0.0
    cpu: float = 0.0

    def figures(self) -> dict[str, Any]:
        """Calls a second, milliseconds of a call, milliseconds of the processor for a call."""
        cuts = statistics.quantiles(self.times, n=100)
        return {
            "calls": len(self.times),
            "per_second": round(len(self.times) / self.seconds, 1),
            "p50": round(1000 * cuts[49], 1),
            "p99": round(1000 * cuts[98], 1),
            "cpu": round(1000 * self.cpu / len(self.times), 2),
        }


async def measure(empty: str, ours: str, kind: type[LoadHost], clients: int, runs: int) -> dict[str, Any]:
    """All figures, and the load of the machine before and after."""
    before = round(os.getloadavg()[0], 2)
    await warm_up(empty, ours, kind)
    works = {
        "empty": Work(empty, iter([[("nothing", {})] * CALLS] * runs)),
        "alike": Work(ours, (calls_of(PROGRAM) for _ in range(runs))),
        "own": Work(ours, (calls_of(own_program(number)) for number in range(runs))),
    }
    for turn in range(TURNS):
        for work in works.values():
            share = runs * (turn + 1) // TURNS - runs * turn // TURNS
            await under_load(work, kind, clients, [next(work.runs) for _ in range(share)])
    figures: dict[str, Any] = {"cores": os.cpu_count(), "load": [before, round(os.getloadavg()[0], 2)]}
    figures |= {name: work.figures() for name, work in works.items()}
    cpu = {name: work.cpu for name, work in works.items()}
    figures["times_of_empty"] = {name: round(cpu[name] / cpu["empty"], 2) for name in ("alike", "own")}
    return figures


async def warm_up(empty: str, ours: str, kind: type[LoadHost]) -> None:
    """Have both servers load what they load with their first calls."""
    nothing: list[Call] = [("nothing", {})]
    for url, calls in ((empty, nothing), (ours, calls_of(PROGRAM))):
        await under_load(Work(url, iter(())), kind, 1, [calls])


def own_program(number: int) -> tuple[Action, ...]:
    """The program of a run of its own: the first turn is another one."""
    angle = 45 + DEGREES_APART * (number + 1)
    return tuple(
        Rotate(angle=angle) if at == PROGRAM.index(Rotate(angle=45)) else each
        for at, each in enumerate(PROGRAM)
    )


def calls_of(program: tuple[Action, ...]) -> list[Call]:
    """The calls that fold a program in a run, once it is open."""
    calls: list[Call] = [("open_run", {})]
    for action in program:
        arguments = action.model_dump(mode="json", exclude_none=True)
        calls.append((arguments.pop("action"), arguments))
    return [*calls, ("get_current_state", {}), ("save_checkpoint", {"frame": 2})]


async def under_load(work: Work, kind: type[LoadHost], clients: int, runs: list[list[Call]]) -> None:
    """Have all hosts take one run after the other until none is left; then look at what they were answered."""
    hosts = [await kind.connected(work.url) for _ in range(min(clients, len(runs)))]
    left = iter(runs)
    answered: list[tuple[list[Call], list[Answer]]] = []

    async def take_runs(host: LoadHost) -> None:
        answered.extend([(calls, await called(host, calls, work.times)) for calls in left])

    cpu, began = await cpu_seconds(work.url), time.perf_counter()
    await asyncio.gather(*map(take_runs, hosts))
    work.seconds += time.perf_counter() - began
    work.cpu += await cpu_seconds(work.url) - cpu
    for host in reversed(hosts):  # the SDK's clients end in the order in which they nest
        await host.close()
    for calls, answers in answered:
        check(calls, answers)


async def called(host: LoadHost, calls: list[Call], times: list[float]) -> list[Answer]:
    """What the calls are answered, one after the other; a run that is opened by one is meant by those that follow."""
    answers: list[Answer] = []
    run_id: dict[str, str] = {}
    for tool, arguments in calls:
        began = time.perf_counter()
        answers.append(await host.call(tool, {**arguments, **run_id}))
        times.append(time.perf_counter() - began)
        if tool == "open_run":
            run_id["run_id"] = result_of(answers[0])["structuredContent"]["run_id"]
    return answers


def check(calls: list[Call], answers: list[Answer]) -> None:
    """Exit with a sentence if a call was refused or answered another state than the simulator's."""
    replays, done = ReplayCache(), list[Action]()
    for (tool, arguments), answer in zip(calls, answers, strict=True):
        result = result_of(answer)
        if result["isError"]:
            raise SystemExit(f"load: {tool} was refused: {result['content']}")
        if tool in ACTION_NAMES:
            done.append(ACTION.validate_python({"action": tool, **arguments}))
        if tool in ACTION_NAMES or tool == "get_current_state":
            state = folded_state(replays.after((1.0, 1.0), tuple(done))).model_dump_json()
            if result["structuredContent"]["state"] != json.loads(state):
                raise SystemExit(f"load: after {done} the server answers another state than the simulator")


if __name__ == "__main__":
    main()
