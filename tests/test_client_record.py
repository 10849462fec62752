"""The record of a run is whole: one process at a time, what was in flight is settled, gaps are named, files that cannot grow."""

import asyncio
import json
import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from client_kills import KillPlan, kill_often
from client_runs import MISMATCH, act, ask, events, program, restore, resume, run, save, sequence, server_url
from contract.record_contract import FOLDER, published
from folding_client.interrupts import UsageError
from folding_client.protocol.connection import ServerAddress
from folding_client.protocol.server_client import ServerClient
from folding_client.record.event_log import EventLog, gaps, read_events
from folding_client.record.folder import RunFolder
from folding_client.record.recorder import Recorder
from folding_client.record.redaction import redact
from folding_client.record.replay import replay_run
from mcp import StdioServerParameters
from providers.base import Fails, Says
from providers.openai import OpenAI
from test_client_commands import TURN, command, script
from test_client_commands import save as saves

MODEL = "litellm/openai/gpt-4o"
ACTION = {"action": "rotate", "angle": 45.0}


def test_of_many_that_begin_a_run_in_one_folder_at_once_one_does(tmp_path: Path) -> None:
    for number in range(20):
        path = tmp_path / f"run{number}"
        together = threading.Barrier(6)

        def begins(path: Path = path, together: threading.Barrier = together) -> RunFolder | None:
            folder = RunFolder(path)
            together.wait()
            try:
                folder.create()
            except UsageError:
                return None
            with closing(EventLog(folder.events)) as log:
                log.append("opened")
            return folder

        with ThreadPoolExecutor(6) as pool:
            began = [folder for folder in pool.map(lambda _: begins(), range(6)) if folder]
        assert len(began) == 1
        assert [event["kind"] for event in read_events(path / "events.jsonl")] == ["opened"]
        began[0].release()


@pytest.mark.slow
def test_of_two_commands_on_one_folder_one_wins_and_the_other_is_refused(tmp_path: Path) -> None:
    look = [{"tool": "get_current_state", "arguments": {}}]
    model = script(tmp_path, [saves(1)], *[look] * 30, [TURN, saves(2)])
    words = [
        sys.executable,
        "-m",
        "folding_client",
        "run",
        sequence(2),
        "--model",
        model,
        "--out",
        tmp_path / "run",
    ]
    both = [subprocess.Popen(list(map(str, words)), stderr=subprocess.PIPE, text=True) for _ in range(2)]
    said = [process.communicate(timeout=120)[1] for process in both]
    assert sorted(process.returncode for process in both) == [0, 2], said
    refusal = said[0 if both[0].returncode else 1]
    assert "Another process works on the run" in refusal or "holds a run already" in refusal
    recorded = events(tmp_path / "run")
    assert [event["seq"] for event in recorded] == list(range(1, len(recorded) + 1))
    assert len(events(tmp_path / "run", "reply")) == 32


@pytest.mark.slow
@pytest.mark.parametrize("cut_after", ["call", "result"])
def test_who_decided_a_frame_is_on_record_although_the_client_was_killed_at_its_save(
    tmp_path: Path, cut_after: str
) -> None:
    model = script(tmp_path, [saves(1)], [TURN, saves(2)])
    out = tmp_path / "run"
    assert run(3, out, model=model).status == "stopped"
    lines = (out / "events.jsonl").read_text().splitlines(keepends=True)
    places = [
        number
        for number, line in enumerate(lines)
        if (event := json.loads(line))["kind"] == cut_after and event["name"] == "save_checkpoint"
    ]
    (out / "events.jsonl").write_text("".join(lines[: places[1] + 1]))
    script(tmp_path, [saves(1)], [TURN, saves(2)], [TURN, saves(3)])
    outcome = resume(out)
    assert outcome.status == "complete", outcome.reason
    assert outcome.run["decided"] == {"1": model, "2": model, "3": model}
    assert program(out) == [[ACTION], [ACTION]]
    assert [event["frame"] for event in events(out, "step_over")] == [1, 2, 3]
    assert asyncio.run(replay_run(out)).differences == ()


@pytest.mark.slow
def test_a_client_that_is_killed_at_random_and_at_its_calls_leaves_nothing_out(tmp_path: Path) -> None:
    fold = {"tool": "fold", "arguments": {"edge": [1, 3], "direction": 1}}
    look = {"tool": "get_current_state", "arguments": {}}
    model = script(tmp_path, [saves(1)], [TURN], [look, saves(2)], [fold, saves(3)])
    report = kill_often(KillPlan(sequence(3), model, kills=2, seed=1, calls=5), tmp_path / "runs")
    assert report.faults == []
    assert report.kills == 2
    assert report.runs >= 1


def test_a_script_goes_on_where_the_step_began_however_often_the_step_was_cut_short(tmp_path: Path) -> None:
    model = script(tmp_path, [saves(1)], [TURN], [saves(2)])
    out = tmp_path / "run"
    for times in range(3):  # the script lacks its third reply, thrice
        (tmp_path / "script.json").write_text(json.dumps([{"calls": [saves(1)]}, {"calls": [TURN]}]))
        stopped = run(2, out, model=model) if times == 0 else resume(out)
        assert stopped.status == "stopped"
    script(tmp_path, [saves(1)], [TURN], [saves(2)])
    assert resume(out).status == "complete"
    assert program(out) == [[ACTION]]
    assert len(events(out, "reply")) == 6


STILLBORN = """
import os, signal, sys
from pathlib import Path
mark = Path(sys.argv.pop(1))
if len(left := sorted(mark.iterdir())):
    left[0].unlink()
    os.kill(os.getpid(), signal.SIGKILL)
from folding_server.cli import main
main()
"""


class StillbornAddress(ServerAddress):
    """A server that dies while it starts, once for every file in ``<data>/deaths``."""

    def command(self) -> StdioServerParameters:
        usual = super().command()
        words = ["-c", STILLBORN, str(self.data / "deaths"), *usual.args[2:]]
        return StdioServerParameters(command=usual.command, args=words)


@pytest.mark.slow
@pytest.mark.parametrize(("deaths", "starts"), [(1, True), (2, False)])
def test_a_server_killed_while_it_starts_is_started_once_more(
    tmp_path: Path, deaths: int, *, starts: bool
) -> None:
    folder = RunFolder(tmp_path / "run")
    folder.create()
    (folder.store / "deaths").mkdir()
    for number in range(deaths):
        (folder.store / "deaths" / str(number)).touch()
    recorder = Recorder(folder, {})

    async def begin() -> str:
        server = ServerClient(StillbornAddress(sequence(2), folder.store), recorder, sys.stderr)
        try:
            await server.start()
            return (await server.open_run(sequence(2).name)).run_id
        finally:
            await server.close()

    try:
        if starts:
            assert asyncio.run(begin())
        else:
            with pytest.raises(Exception, match="does not start"):
                asyncio.run(begin())
    finally:
        recorder.close()
        folder.release()
    assert [event["call"] for event in events(tmp_path / "run", "server_lost")] == [None] * deaths


@pytest.mark.slow
def test_a_replay_names_the_lines_that_are_missing(tmp_path: Path) -> None:
    model = script(tmp_path, [saves(1)], [TURN, saves(2)])
    out = tmp_path / "run"
    assert run(2, out, model=model).status == "complete"
    lines = (out / "events.jsonl").read_text().splitlines(keepends=True)
    place = next(n for n, line in enumerate(lines) if json.loads(line)["kind"] == "step_started")
    (out / "events.jsonl").write_text("".join([*lines[:place], *lines[place + 1 :]]))
    replayed = command("replay", out)
    assert replayed.returncode == 1
    seq = place + 1
    assert (
        f"event {seq}, events.jsonl: event {seq} is missing between {seq - 1} and {seq + 1}"
        in replayed.stdout
    )


def test_a_log_with_a_gap_goes_on_with_numbers_of_its_own(tmp_path: Path) -> None:
    file = tmp_path / "events.jsonl"
    file.write_text('{"seq": 1, "kind": "opened"}\n{"seq": 5, "kind": "ended"}\n')
    log = EventLog(file)
    log.append("resumed")
    log.close()
    assert [event["seq"] for event in read_events(file)] == [1, 5, 6]
    assert list(gaps(read_events(file))) == [(2, 4)]


LIMITED = """
import resource, sys
limit = int(sys.argv.pop(1))
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
from folding_client.cli import main
main()
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="limits of processes are POSIX's")
def test_a_file_that_cannot_grow_is_one_sentence_and_the_run_resumes(tmp_path: Path) -> None:
    look = [{"tool": "get_current_state", "arguments": {}}]
    model = script(tmp_path, [saves(1)], *[look] * 30, [TURN, saves(2)])
    out = tmp_path / "run"
    words = ["run", sequence(2), "--model", model, "--out", out, "--server-url", server_url(), "-q"]
    process = [sys.executable, "-c", LIMITED, "20000", *map(str, words)]
    stopped = subprocess.run(process, capture_output=True, text=True, check=False)
    assert stopped.returncode == 3, stopped.stderr
    assert stopped.stderr.startswith("A file cannot be read or written: File too large")
    assert len(stopped.stderr.strip().splitlines()) == 1
    about = json.loads((out / "run.json").read_text())
    assert about["outcome"]["status"] == "stopped"
    assert "File too large" in about["outcome"]["reason"]
    assert resume(out).status == "complete"
    recorded = events(out)
    assert [event["seq"] for event in recorded] == list(range(1, len(recorded) + 1))


@pytest.mark.parametrize(
    ("text", "clean"),
    [
        ("https://me:pass@host/mcp", "https://[redacted]@host/mcp"),
        ("http://token@host", "http://[redacted]@host"),
        ('"url": "https://h/v1?api_key=abc&x=1"', '"url": "https://h/v1?api_key=[redacted]&x=1"'),
        ("https://h/?x=1;access-token=abc#part", "https://h/?x=1;access-token=[redacted]#part"),
        ("see http://host/a and mail me@host", "see http://host/a and mail me@host"),
        ("https://h/?monkey=1 and ?keyboard=2", "https://h/?monkey=[redacted] and ?keyboard=2"),
    ],
)
def test_addresses_lose_their_passwords_and_keys(text: str, clean: str) -> None:
    assert redact(text, {}) == clean


def eventful(out: Path) -> dict[str, Any]:
    """A run with as much going wrong as fits into three frames."""
    bad = Says(calls=[("rotat", {"angle": 45})])
    failing = Says(calls=[("fold", {"edge": [1, 99], "direction": 1}), ("rotate", {"angle": 5})])
    overview = Says(
        json.dumps(
            {
                "last_correct_frame": 1,
                "first_suspicious_frame": None,
                "per_frame_notes": [],
                "recommendation": "Go on.",
            }
        )
    )
    attempts = [
        turn for angle in (10, 20, 30, 40) for turn in (act({"action": "rotate", "angle": angle}), restore(2))
    ]
    with OpenAI(
        save(1),
        bad,
        failing,
        Fails(500),
        Says(silent=True),
        Says("Hm."),
        Says("Well."),
        Says("So."),
        act(ACTION),
        ask(2, "rotate"),
        MISMATCH,
        Says(calls=[("generate_checkpoint_overview", {})]),
        overview,
        save(2),
        act(ACTION),
        restore(2),
        *attempts,
        Says("B2"),
    ) as provider:
        return run(3, out, model=MODEL, api_base=provider.url).run


@pytest.mark.slow
def test_real_records_fit_their_published_schemas(tmp_path: Path) -> None:
    schemas = {name: json.loads((FOLDER / name).read_text()) for name in published()}
    about = eventful(tmp_path / "run")
    jsonschema.validate(json.loads((tmp_path / "run" / "run.json").read_text()), schemas["run.schema.json"])
    assert about["outcome"]["status"] == "complete"
    validator = jsonschema.Draft202012Validator(schemas["event.schema.json"])
    recorded = events(tmp_path / "run")
    for event in recorded:
        validator.validate(event)
        for name in event.keys() - {
            "id",
            "request_id",
            "images",
            "calls",
            "call_id",
            "tool",
            "state",
            "rewrites",
            "technical",
        }:
            with pytest.raises(jsonschema.ValidationError):
                validator.validate({key: value for key, value in event.items() if key != name})
    kinds = (
        "opened step_started request reply call result refused skipped retry unreadable rolled_back rewound"
    )
    assert {event["kind"] for event in recorded} >= {
        *kinds.split(),
        *("verdict", "overview", "step_over", "selected", "ended"),
    }
    assert about["fits"] == {
        "2": {"verdict": "MISMATCH", "agreement": None, "by": "critic"},
        "3": {"verdict": None, "agreement": None, "by": "selector"},
    }


def test_the_published_schemas_are_those_of_the_models() -> None:
    """Write them anew: PYTHONPATH=tests .venv/bin/python tests/contract/record_contract.py."""
    assert {name: (FOLDER / name).read_text(encoding="utf-8") for name in published()} == published()
