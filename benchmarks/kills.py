"""Kill the server in the middle of its work, again and again: ``python benchmarks/kills.py --kills 200`` prints JSON.

A server process is asked over stdio to open a run and change it, call after call, and killed with SIGKILL after a random
time; the next one works on the same database. Each time the store is opened and compared with what was answered:
everything is there, in order, at most the one call that was on its way besides, and the run's row in the list says the same
as its events. Exits with 1 where that is not so. The moments depend on the machine, the calls on ``--seed``.
"""

import argparse
import json
import random
import sys
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from folding_server.store.database import database_url
from folding_server.store.run_events import IN_COLUMNS
from folding_server.store.run_store import RunStore
from forked_servers import ForkedServer, ServerStem

LONGEST_SECONDS = 0.5
"""The latest moment of a kill, after the run was opened: a few dozen calls."""

TOLD_EVERY = 10
"""Kills after which a line on stderr says how far it is."""

PROTOCOL = "2025-06-18"
"""A version of the protocol with sessions, in which a call is one line."""

Call = tuple[str, dict[str, Any]]


@dataclass
class Answered:
    """What a server answered before it was killed: the run it opened, and the calls that it carried out in order.

    ``sent`` is the call that was on its way, if there was one.
    """

    run_id: str
    calls: list[Call] = field(default_factory=list)
    sent: Call | None = None


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=200, help="how often (default 200)")
    parser.add_argument("--seed", type=int, default=0, help="of the calls and the moments (default 0)")
    parser.add_argument(
        "--database", help="the URL of an empty database (default: SQLite in a temporary folder)"
    )
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        url = options.database or database_url(Path(folder))
        report = kill_often(url, options.kills, options.seed)
    json.dump(report, sys.stdout, indent=2)
    sys.stdout.write("\n")
    sys.exit(1 if report["faults"] else 0)


def kill_often(url: str, kills: int, seed: int) -> dict[str, Any]:
    """How many kills, calls answered, calls carried out and not answered, and a sentence for each fault.

    Tells on stderr how far it is.
    """
    answered: list[Answered] = []
    faults: list[str] = []
    with ServerStem() as stem:
        for number in range(kills):
            answered.append(work_until_killed(stem, url, random.Random(f"{seed}/{number}")))
            with RunStore(url) as store:
                faults += faults_in(store, answered[-1])
            if (number + 1) % TOLD_EVERY == 0:
                sys.stderr.write(f"kills: {number + 1} of {kills}, {len(faults)} faults\n")
    with RunStore(url) as store:
        found = {run.run_id: run.events - 1 for run in store.list_runs()}
        faults += [fault for each in answered for fault in faults_in(store, each)]
    calls = sum(len(each.calls) for each in answered)
    carried_out = sum(found.get(each.run_id, 0) for each in answered)
    return {"kills": kills, "answered": calls, "not answered": carried_out - calls, "faults": faults}


def work_until_killed(stem: ServerStem, url: str, rng: random.Random) -> Answered:
    """Have a server open a run and change it until it is killed."""
    with stem.server(url) as process:
        timer = threading.Timer(rng.uniform(0, LONGEST_SECONDS), process.kill)
        try:
            session = Session(process)
            opened = session.ask("tools/call", name="open_run", arguments={})
            answered = Answered(opened["structuredContent"]["run_id"])
            timer.start()
            _change_until_the_end(session, answered, rng)
        finally:
            timer.cancel()
    return answered


class Session:
    """A host's side of one session with a server process, line by line."""

    def __init__(self, process: ForkedServer) -> None:
        self._input, self._output, self._sent = process.stdin, process.stdout, 0
        client = {"name": "kills", "version": "1"}
        self.ask("initialize", protocolVersion=PROTOCOL, capabilities={}, clientInfo=client)
        self._send(method="notifications/initialized")

    def ask(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The result of a request. EOFError or BrokenPipeError if the server has ended."""
        self._sent += 1
        self._send(id=self._sent, method=method, params=parameters)
        while line := self._output.readline():
            answer = json.loads(line)
            if answer.get("id") == self._sent:
                return dict(answer["result"])
        raise EOFError

    def _send(self, **message: Any) -> None:
        self._input.write(json.dumps({"jsonrpc": "2.0", **message}) + "\n")
        self._input.flush()


def _change_until_the_end(session: Session, answered: Answered, rng: random.Random) -> None:
    """Ask for one change after the other, and write down what is answered."""
    saved = 1
    while True:
        changes: list[tuple[str, dict[str, Any]]] = [
            ("rotate", {"angle": rng.randrange(360)}),
            ("flip", {"axis": rng.choice(["x", "y"])}),
            ("save_checkpoint", {"frame": saved + 1, "notes": "n" * rng.randrange(1, 5000)}),
        ]
        name, arguments = answered.sent = rng.choice(changes)
        try:
            result = session.ask("tools/call", name=name, arguments={**arguments, "run_id": answered.run_id})
        except (EOFError, BrokenPipeError, json.JSONDecodeError):
            return
        assert not result.get("isError"), result
        answered.calls.append((name, arguments))
        answered.sent = None
        saved += name == "save_checkpoint"


def faults_in(store: RunStore, answered: Answered) -> list[str]:
    """What is not as it was answered, one sentence each."""
    run_id, events = answered.run_id, store.history(answered.run_id)
    done = [
        _call_of(event.model_dump(mode="json", exclude=set(IN_COLUMNS) - {"kind"})) for event in events[1:]
    ]
    may_be = [answered.calls] if answered.sent is None else [answered.calls, [*answered.calls, answered.sent]]
    faults = [] if done in may_be else [f"run {run_id}: answered {answered.calls}, found {done}"]
    view = store.load(run_id)
    (listed,) = [run for run in store.list_runs() if run.run_id == run_id]
    if (listed.events, listed.saved, listed.changed) != (view.seq, len(view.checkpoints), view.changed):
        faults.append(f"run {run_id}: its row says {listed}, its events {view}")
    return faults


def _call_of(event: dict[str, Any]) -> Call:
    """The call that an event was recorded for."""
    if event["kind"] == "saved":
        return "save_checkpoint", {"frame": event["frame"], "notes": event["notes"]}
    action = dict(event["action"])
    return action.pop("action"), action


if __name__ == "__main__":
    main()
