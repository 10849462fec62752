"""The command ``foldingagent`` as one uses it: what it prints, how it fails, how it is interrupted."""

import io
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
from client_runs import events, program, sequence, server_url
from folding_client.cli import main
from videos import SQUARE, TRIANGLE, Rest, Work, write_clip

TURN = {"tool": "rotate", "arguments": {"angle": 45}}


def save(frame: int) -> dict[str, Any]:
    """A scripted call that saves a frame."""
    return {"tool": "save_checkpoint", "arguments": {"frame": frame}}


def script(folder: Path, *replies: list[dict[str, Any]]) -> str:
    """A script of replies that call tools, as a model id."""
    (folder / "script.json").write_text(json.dumps([{"calls": reply} for reply in replies]))
    return f"scripted:{folder / 'script.json'}"


@dataclass(frozen=True)
class Done:
    """What a command printed and returned."""

    returncode: int
    stdout: str
    stderr: str


def command(*words: object) -> Done:
    """What ``foldingagent`` with these words prints and returns, in this process."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    return Done(int(end.value.code or 0), out.getvalue(), err.getvalue())


def test_a_run_prints_its_program_and_where_it_is(tmp_path: Path) -> None:
    model = script(tmp_path, [save(1)], [TURN, save(2)])
    done = command(
        "run", sequence(2), "--model", model, "--out", tmp_path / "run", "--server-url", server_url()
    )
    assert done.returncode == 0, done.stderr
    assert "1 -> 2  rotate(45.0)" in done.stdout
    assert str(tmp_path / "run") in done.stdout
    assert "1 of 2 frames done, working on frame 2" in done.stderr


def test_json_is_one_document_and_nothing_else_on_stdout(tmp_path: Path) -> None:
    model = script(tmp_path, [save(1)], [TURN, save(2)])
    done = command(
        "run",
        sequence(2),
        "--model",
        model,
        "--out",
        tmp_path / "run",
        "--server-url",
        server_url(),
        "--json",
    )
    document = json.loads(done.stdout)
    assert document["status"] == "complete"
    assert document["program"]["steps"] == [[{"action": "rotate", "angle": 45.0}]]
    about = json.loads((tmp_path / "run" / "run.json").read_text())
    assert about["settings"]["given"].keys() == {"model", "server_url"}
    assert about["settings"]["defaulted"]["max_queries"] == 300
    assert about["models"]["critic"] == model


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["run"], "Name a sequence folder or a video"),
        (["run", "no/such/folder"], "There is no sequence folder no/such/folder"),
        (["run", "."], "holds no keyframes.json"),
        (["run", "SEQUENCE", "--model", "gpt"], "There is no model 'gpt'"),
        (["run", "SEQUENCE", "--model", "scripted:nothing.json"], "Cannot read the script nothing.json"),
        (["run", "SEQUENCE", "--model", "scripted:~nobody-here/a.json"], "a user who has no folder here"),
        (["run", "SEQUENCE", "--variant", "vlm-x"], "--variant cannot be 'vlm-x'"),
        (["run", "SEQUENCE", "--max-queries", "0"], "--max-queries cannot be 0"),
        (["run", "SEQUENCE", "--thinking-budget", "500"], "give 0, or 1024 and more"),
        (["run", "SEQUENCE", "--thinking-budget", "40000"], "leaves nothing of the 32768"),
        (["run", "SEQUENCE", "--tools", "some"], "--tools cannot be 'some'"),
        (["run", "--resume", "no/such/run"], "No recorded run at"),
        (["replay", "no/such/run"], "No recorded run at"),
        (["batch", "no/such/list"], "Cannot read no/such/list"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_a_mistake_is_one_line_and_exit_code_2(tmp_path: Path, words: list[str], says: str) -> None:
    given = [str(sequence(2)) if word == "SEQUENCE" else word for word in words]
    if "SEQUENCE" in words:
        given += ["--out", str(tmp_path / "run")]
    failed = command(*given)
    assert failed.returncode == 2
    assert says in failed.stderr
    assert len(failed.stderr.strip().splitlines()) == 1
    assert failed.stdout == ""
    assert not (tmp_path / "run").exists()


def test_a_run_that_cannot_begin_leaves_what_was_in_its_folder_alone(tmp_path: Path) -> None:
    picture = tmp_path / "images" / "holiday.jpg"
    picture.parent.mkdir()
    picture.write_bytes(b"mine")
    failed = command("run", sequence(2), "--model", "foo:bar", "--out", tmp_path)
    assert failed.returncode == 2
    assert picture.read_bytes() == b"mine"
    assert not (tmp_path / "store").exists()


@pytest.mark.slow
def test_a_video_is_made_a_sequence_in_the_run_folder_and_reconstructed(tmp_path: Path) -> None:
    shots = [Rest(SQUARE), Work(SQUARE, TRIANGLE), Rest(TRIANGLE)]
    video = write_clip(tmp_path / "clip.mp4", shots).path
    model = script(tmp_path, [save(1)], [TURN, save(2)])
    done = command("run", video, "--model", model, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    assert "Program of clip" in done.stdout
    about = json.loads((tmp_path / "run" / "run.json").read_text())
    assert about["sequence"]["folder"] == str(tmp_path / "run" / "sequence")
    assert (tmp_path / "run" / "sequence" / "contact_sheet.png").is_file()


@pytest.mark.slow
@pytest.mark.usefixtures("interruptible")
def test_a_video_whose_search_is_interrupted_leaves_no_run(tmp_path: Path) -> None:
    video = write_clip(tmp_path / "clip.mp4", [Rest(SQUARE), Work(SQUARE, TRIANGLE), Rest(TRIANGLE)]).path
    run = tmp_path / "runs" / "run"
    process = subprocess.Popen(
        [sys.executable, "-m", "folding_client", "run", str(video), "--out", str(run)],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while not run.exists():
        assert process.poll() is None
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=30)
    assert (process.returncode, said) == (130, "Interrupted; no run has begun.\n")
    assert [path.name for path in tmp_path.iterdir()] == ["clip.mp4"]


def test_a_video_that_cannot_be_used_leaves_no_run(tmp_path: Path) -> None:
    (tmp_path / "letter.mp4").write_text("a letter, not a film\n" * 40)
    failed = command("run", tmp_path / "letter.mp4", "--out", tmp_path / "run")
    assert failed.returncode == 2
    assert failed.stderr == (
        "letter.mp4 cannot be read as a video: it is cut off or not a video; copy it again, or name another file\n"
    )
    served = command(
        "run", tmp_path / "letter.mp4", "--out", tmp_path / "run", "--server-url", "http://x/mcp"
    )
    assert served.returncode == 2
    assert "A running server cannot be handed the video letter.mp4" in served.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["letter.mp4"]


def test_a_sequence_the_server_cannot_use_is_refused_in_its_words(tmp_path: Path) -> None:
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "keyframes.json").write_text("not JSON")
    failed = command("run", tmp_path / "broken", "--out", tmp_path / "runs" / "run")
    assert failed.returncode == 2
    assert "keyframes.json" in failed.stderr
    assert len(failed.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "runs").exists()


@pytest.mark.slow
def test_a_sequence_goes_by_the_name_in_its_manifest(tmp_path: Path) -> None:
    shutil.copytree(sequence(2), tmp_path / "renamed")
    model = script(tmp_path, [save(1)], [TURN, save(2)])
    done = command("run", tmp_path / "renamed", "--model", model, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    assert f"Program of {sequence(2).name}" in done.stdout


def test_a_resumed_run_keeps_its_model_and_its_sequence(tmp_path: Path) -> None:
    model = script(tmp_path, [save(1)])
    run = tmp_path / "run"
    stopped = command("run", sequence(2), "--model", model, "--out", run, "--server-url", server_url())
    assert stopped.returncode == 3
    assert "extend it, then resume" in stopped.stderr
    other_model = command("run", "--resume", run, "--model", "geometric")
    assert other_model.returncode == 2
    assert "was made with model" in other_model.stderr
    other_folder = command("run", "--resume", run, "--out", tmp_path / "other")
    assert other_folder.returncode == 2
    assert "leave out --out" in other_folder.stderr
    other_sequence = command("run", sequence(3), "--resume", run)
    assert other_sequence.returncode == 2
    assert "is a run of" in other_sequence.stderr
    script(tmp_path, [save(1)], [TURN, save(2)])
    assert command("run", "--resume", run).returncode == 0
    again = command("run", "--resume", run)
    assert again.returncode == 2
    assert "complete already" in again.stderr
    taken = command("run", sequence(2), "--model", model, "--out", run)
    assert "holds a run already" in taken.stderr


def test_settings_of_another_version_are_refused_in_one_sentence(tmp_path: Path) -> None:
    run = tmp_path / "run"
    command(
        "run", sequence(2), "--model", script(tmp_path, [save(1)]), "--out", run, "--server-url", server_url()
    )
    about = json.loads((run / "run.json").read_text())
    about["settings"]["given"]["no_such_setting"] = True
    (run / "run.json").write_text(json.dumps(about))
    refused = command("run", "--resume", run)
    assert refused.returncode == 2
    assert "no_such_setting" in refused.stderr
    assert len(refused.stderr.strip().splitlines()) == 1


def test_a_file_that_cannot_be_written_is_one_sentence_and_ends_one_sequence_of_a_batch(
    tmp_path: Path,
) -> None:
    model = script(tmp_path, [save(1)], [TURN, save(2)])
    for run in ("run", f"runs/{sequence(2).name}"):
        (tmp_path / run / "program.json").mkdir(parents=True)
    options = ("--model", model, "--server-url", server_url())
    stopped = command("run", sequence(2), "--out", tmp_path / "run", *options)
    assert stopped.returncode == 3
    (said,) = [line for line in stopped.stderr.splitlines() if "frames done" not in line]
    assert said.startswith("A file cannot be read or written: Is a directory")
    assert said.endswith("; mend that, then go on with --resume or the same command.")
    (tmp_path / "list.json").write_text(json.dumps([str(sequence(2)), str(sequence(3))]))
    script(tmp_path, [save(1)], [TURN, save(2)], [TURN, save(3)])
    batch = command("batch", tmp_path / "list.json", "--out", tmp_path / "runs", "--json", *options)
    assert [line["status"] for line in json.loads(batch.stdout)] == ["failed", "complete"]
    assert "Traceback" not in batch.stderr


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Processes started meanwhile can be interrupted, though a shell that runs the tests in the background ignores that."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.slow
@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_an_interrupted_run_is_complete_to_the_last_event_and_resumes(
    tmp_path: Path, kind: signal.Signals
) -> None:
    look = [{"tool": "render_current", "arguments": {}}]
    model = script(tmp_path, [save(1)], [TURN], *[look] * 2000)
    run = tmp_path / "run"
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "folding_client",
            "run",
            str(sequence(2)),
            "--model",
            model,
            "--out",
            str(run),
        ],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while not (run / "events.jsonl").exists() or "rotate" not in (run / "events.jsonl").read_text():
        assert process.poll() is None
        time.sleep(0.02)
    if kind == signal.SIGINT:
        os.killpg(process.pid, kind)
    else:
        process.send_signal(kind)
    _, said = process.communicate(timeout=30)
    assert process.returncode == (-kind if kind == signal.SIGKILL else 130)
    assert "Traceback" not in said
    assert ("Interrupted; the run folder is complete so far" in said) is (kind != signal.SIGKILL)
    recorded = events(run)
    assert [event["seq"] for event in recorded] == list(range(1, len(recorded) + 1))
    about = json.loads((run / "run.json").read_text())
    assert about["outcome"]["status"] == ("running" if kind == signal.SIGKILL else "interrupted")
    script(tmp_path, [save(1)], [TURN, save(2)])
    assert command("run", "--resume", run).returncode == 0
    assert program(run) == [[{"action": "rotate", "angle": 45.0}]]


@pytest.mark.slow
def test_a_recorded_run_replays_without_a_model_and_a_changed_answer_is_found(tmp_path: Path) -> None:
    model = script(
        tmp_path,
        [save(1)],
        [
            TURN,
            {"tool": "render_current", "arguments": {}},
            {"tool": "fold", "arguments": {"edge": [1, 99], "direction": 1}},
        ],
        [save(2)],
    )
    run = tmp_path / "run"
    assert (
        command("run", sequence(2), "--model", model, "--out", run, "--server-url", server_url()).returncode
        == 0
    )
    moved = command("replay", run, "--sequence", tmp_path)
    assert moved.returncode == 2
    assert "where the run's sequence is now with --sequence" in moved.stderr
    same = command("replay", run)
    assert same.returncode == 0, same.stdout
    assert "0 answered differently" in same.stdout
    log = (run / "events.jsonl").read_text()
    (run / "events.jsonl").write_text(log.replace('"angle": 45', '"angle": 46'))
    changed = command("replay", run, "--json")
    assert changed.returncode == 1
    first = json.loads(changed.stdout)["differences"][0]
    assert first["tool"] == "rotate"
    assert "vertices" in first["what"]


def test_a_recorded_run_can_be_the_script_of_another(tmp_path: Path) -> None:
    model = script(tmp_path, [save(1)], [TURN, save(2)])
    first, second = tmp_path / "first", tmp_path / "second"
    assert (
        command("run", sequence(2), "--model", model, "--out", first, "--server-url", server_url()).returncode
        == 0
    )
    assert (
        command(
            "run", sequence(2), "--model", f"scripted:{first}", "--out", second, "--server-url", server_url()
        ).returncode
        == 0
    )
    assert program(first) == program(second)


def test_a_batch_skips_what_is_finished_and_continues_the_rest(tmp_path: Path) -> None:
    (tmp_path / "list.json").write_text(json.dumps([str(sequence(2)), str(sequence(3))]))
    model = script(tmp_path, [save(1)], [TURN, save(2)])
    words = [
        "batch",
        tmp_path / "list.json",
        "--model",
        model,
        "--out",
        tmp_path / "runs",
        "--server-url",
        server_url(),
        "--jobs",
        "2",
        "--json",
    ]
    first = command(*words)
    assert first.returncode == 3
    assert [line["status"] for line in json.loads(first.stdout)] == ["complete", "stopped"]
    script(tmp_path, [save(1)], [TURN, save(2)], [TURN, save(3)])
    second = command(*words)
    assert second.returncode == 0
    assert [line["status"] for line in json.loads(second.stdout)] == ["skipped", "complete"]


def test_a_tilde_is_the_users_folder_although_no_shell_has_seen_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    shutil.copytree(sequence(2), tmp_path / "plain2")
    script(tmp_path, [save(1)])
    words = ("~/plain2", "--model", "scripted:~/script.json", "--out=~/run", "--server-url", server_url())
    command("run", *words)
    assert program(tmp_path / "run") == []
    assert (tmp_path / "run" / "run.json").exists()


def test_the_version_is_that_of_the_package() -> None:
    done = command("--version")
    assert done.returncode == 0
    assert done.stdout == f"foldingagent {version('foldingagent-mcp')}\n"
