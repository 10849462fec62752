"""Changes whose answers got lost: the server is killed after the commit, or the client while it waits."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from client_runs import events, program, resume, sequence
from folding_client.messages import ToolResult
from folding_client.protocol.connection import ServerAddress
from folding_client.protocol.requests import Request, unanswered
from folding_client.protocol.server_client import ServerClient
from folding_client.record.folder import RunFolder
from folding_client.record.recorder import Recorder
from folding_client.record.replay import replay_run
from folding_server.store.run_store import RunStore
from mcp import StdioServerParameters
from paths import ROOT

HELPERS = os.pathsep.join(
    str(ROOT / folder) for folder in ("tests", "benchmarks", "benchmarks/reconstruction")
)
"""Where the tests find their helpers, for a process of its own."""

DEADLY_SERVER = """
import os, signal, sys, time
from dataclasses import replace
from pathlib import Path
from folding_server.mcp import catalogue

# Once for each tool that a file in this folder is named for: what the tool says is lost, and what it did is not.
fate, act = Path(sys.argv.pop(1)), sys.argv.pop(1)

def deadly(function):
    from functools import wraps

    @wraps(function)
    def called(*arguments, **named):
        answer = function(*arguments, **named)
        mark = fate / function.__name__
        if mark.exists():
            mark.unlink()
            if act == "sleep":
                time.sleep(60)
            os.kill(os.getpid(), signal.SIGKILL)
        return answer
    return called

catalogue.RECORDS = tuple(replace(record, function=deadly(record.function)) for record in catalogue.RECORDS)
from folding_server.cli import main
main()
"""
CALLS: list[tuple[str, dict[str, Any]]] = [
    ("save_checkpoint", {"frame": 1}),
    ("add_vertex", {"edge": [1, 2], "position": 0.5}),
    ("fold", {"edge": [5, 4], "direction": 1}),
    ("undo", {}),
    ("fold", {"edge": [1, 3], "direction": 1}),
    ("save_checkpoint", {"frame": 2, "notes": "a triangle"}),
    ("restore_checkpoint", {"frame": 1}),
    ("commit_attempt", {"frame": 2, "attempt": 1}),
    ("get_run", {}),
]
KILLED_AT = ("open_run", "fold", "save_checkpoint")


class DeadlyAddress(ServerAddress):
    """A server that dies, or falls silent, on the tools named by the files in ``<data>/fate``."""

    act = "die"

    def command(self) -> StdioServerParameters:
        usual = super().command()
        script = ["-c", DEADLY_SERVER, str(self.data / "fate"), self.act]
        return StdioServerParameters(command=usual.command, args=script + usual.args[2:])


def recorded_calls(folder: Path, killed_at: tuple[str, ...]) -> list[ToolResult]:
    """The answers to the calls, from a server that is killed when it has first carried out each of these tools."""
    run = RunFolder(folder)
    run.create()
    (run.store / "fate").mkdir()
    for tool in killed_at:
        (run.store / "fate" / tool).touch()
    recorder = Recorder(run, {"sequence": {"folder": str(sequence(3))}, "format": 1})

    async def work() -> list[ToolResult]:
        server = ServerClient(DeadlyAddress(sequence(3), run.store), recorder, sys.stderr)
        try:
            await server.start()
            opened = await server.open_run(sequence(3).name)
            recorder.about["run_id"] = opened.run_id
            return [await server.call(tool, arguments) for tool, arguments in CALLS]
        finally:
            await server.close()

    try:
        answers = asyncio.run(work())
        recorder.outcome("stopped", "", 2, 3)
    finally:
        recorder.close()
        run.release()
    return answers


def told(answer: ToolResult) -> dict[str, Any]:
    """What an answer says, whichever run it is of."""
    return {key: value for key, value in (answer.data or {}).items() if key != "run_id"}


@pytest.mark.slow
def test_a_server_killed_between_commit_and_answer_is_asked_again_and_tells_the_truth(tmp_path: Path) -> None:
    undisturbed = recorded_calls(tmp_path / "undisturbed", ())
    disturbed = recorded_calls(tmp_path / "disturbed", KILLED_AT)
    assert len(events(tmp_path / "disturbed", "server_restarted")) == len(KILLED_AT)
    assert list((tmp_path / "disturbed" / "store" / "fate").iterdir()) == []
    assert [told(answer) for answer in disturbed] == [told(answer) for answer in undisturbed]
    assert told(disturbed[2])["moved_faces"]
    assert told(disturbed[2])["new_faces"]
    with RunStore.in_folder(tmp_path / "disturbed" / "store") as store:
        (run,) = store.list_runs()
        kinds = [event.kind for event in store.history(run.run_id)]
    assert kinds == [
        *("opened", "saved", "acted", "acted", "undone", "acted", "saved", "restored", "committed"),
    ]
    again = asyncio.run(replay_run(tmp_path / "disturbed"))
    assert (again.calls, again.differences) == (1 + len(CALLS), ())


RUN_AND_WAIT = """
import asyncio, sys
from pathlib import Path
from test_client_requests import DeadlyAddress
from folding_client import reconstruct
from folding_client.cli import main

class Silent(DeadlyAddress):
    act = "sleep"

reconstruct.ServerAddress = Silent
main()
"""


@pytest.mark.slow
def test_a_client_killed_while_it_waits_asks_again_when_resumed(tmp_path: Path) -> None:
    """The fold is in the store and its answer is not on record; after the resume it is, and the record replays."""
    script = tmp_path / "script.json"
    script.write_text(
        json.dumps(
            [
                {"calls": [{"tool": "save_checkpoint", "arguments": {"frame": 1}}]},
                {"calls": [{"tool": "fold", "arguments": {"edge": [1, 3], "direction": 1}}]},
                {"calls": [{"tool": "rotate", "arguments": {"angle": 45}}]},
                {"calls": [{"tool": "save_checkpoint", "arguments": {"frame": 2}}]},
            ]
        )
    )
    run = tmp_path / "run"
    fate = run / "store" / "fate"
    fate.mkdir(parents=True)
    (fate / "fold").touch()
    words = ["run", str(sequence(2)), "--model", f"scripted:{script}", "--out", str(run)]
    client = subprocess.Popen(
        [sys.executable, "-c", RUN_AND_WAIT, *words],
        env={**os.environ, "PYTHONPATH": HELPERS},
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )
    while (fate / "fold").exists():
        assert client.poll() is None
        time.sleep(0.02)
    client.send_signal(signal.SIGKILL)
    client.wait()
    (call,) = [event for event in events(run, "call") if event["name"] == "fold"]
    assert events(run)[-1] == call
    outcome = resume(run, server_url=None)
    assert outcome.status == "complete"
    assert program(run) == [
        [{"action": "fold", "edge": [1, 3], "direction": 1}, {"action": "rotate", "angle": 45.0}]
    ]
    answered = next(event for event in events(run, "result") if event["name"] == "fold")
    assert answered["by"] == "agent"
    assert answered["structured"]["moved_faces"]
    assert answered["seq"] == call["seq"] + 1
    with RunStore.in_folder(run / "store") as store:
        kinds = [event.kind for event in store.history(outcome.run["run_id"])]
    assert kinds == ["opened", "saved", "acted", "restored", "acted", "acted", "saved"]
    assert asyncio.run(replay_run(run)).differences == ()


def recorded(kind: str, **data: Any) -> dict[str, Any]:
    return {"kind": kind, **data}


CALL = recorded("call", by="agent", name="fold", arguments={"direction": 1}, request_id="an id")


@pytest.mark.parametrize(
    ("log", "open_"),
    [
        ([], None),
        ([CALL], Request("agent", "fold", {"direction": 1}, "an id")),
        ([CALL, recorded("server_lost")], Request("agent", "fold", {"direction": 1}, "an id")),
        ([CALL, recorded("result")], None),
        ([CALL, recorded("result"), {**CALL, "request_id": None}], None),
        ([{key: value for key, value in CALL.items() if key != "request_id"}], None),
    ],
    ids=["nothing", "in flight", "server lost", "answered", "only reads", "earlier version"],
)
def test_the_call_to_ask_again_is_the_last_change_without_an_answer(
    log: list[dict[str, Any]], open_: Request | None
) -> None:
    assert unanswered(log) == open_
