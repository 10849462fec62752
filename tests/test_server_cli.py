"""The commands of ``foldingagent-server``: what they write, print and refuse."""

import json
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from folding_schemas.foldability_results import Foldability
from folding_schemas.state import FoldedState
from folding_server.cli import main
from folding_server.frames.sequences import load_sequence
from hosts import json_of, server
from known_patterns import fold_file, miura, moved
from papers import CAT
from videos import SQUARE, TRIANGLE, Rest, Work, write_clip

INITIALIZE = (
    b'{"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {"protocolVersion": "2025-06-18", '
    b'"capabilities": {}, "clientInfo": {"name": "test", "version": "1"}}}\n'
)


class Finished(NamedTuple):
    """How a command ended."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """The one JSON document on stdout."""
        return json.loads(self.out)


Run = Callable[..., Finished]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs a command in this process."""

    def finished(*arguments: str | Path) -> Finished:
        with pytest.raises(SystemExit) as ended:
            main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        assert isinstance(ended.value.code, int)
        return Finished(ended.value.code, captured.out, captured.err)

    return finished


def test_simulate_writes_every_format_and_says_where(run: Run, tmp_path: Path) -> None:
    names = {"state": "s.json", "fold": "f.fold", "cp": "c.fold", "svg": "d.svg", "png": "d.png"}
    options = [part for option, name in names.items() for part in (f"--{option}", tmp_path / name)]
    finished = run("simulate", CAT, *options, "--every-step", tmp_path / "steps")
    assert finished.code == 0
    assert all(str(tmp_path / name) in finished.out for name in names.values())
    state = FoldedState.model_validate_json((tmp_path / "s.json").read_text())
    assert len(state.faces) == 12
    assert json.loads((tmp_path / "f.fold").read_text())["file_spec"] == 1.2
    assert (tmp_path / "d.png").read_bytes().startswith(b"\x89PNG")
    assert len(list((tmp_path / "steps").iterdir())) == 9 * 3


def test_simulate_draws_the_crease_pattern_for_an_svg(run: Run, tmp_path: Path) -> None:
    run("simulate", CAT, "--cp", tmp_path / "pattern.svg")
    assert (tmp_path / "pattern.svg").read_text().startswith("<svg")


def test_simulate_prints_one_json_document(run: Run, tmp_path: Path) -> None:
    finished = run("simulate", CAT, "--json", "--fold", tmp_path / "f.fold")
    assert finished.json["written"] == {"fold": str(tmp_path / "f.fold")}
    assert finished.json["steps"] == 8
    FoldedState.model_validate(finished.json["state"])


def test_a_foldable_pattern_passes_the_check(run: Run, tmp_path: Path) -> None:
    run("simulate", CAT, "--cp", tmp_path / "c.fold")
    finished = run("check", tmp_path / "c.fold")
    assert finished.code == 0
    assert "folds flat" in finished.out


def test_a_pattern_that_does_not_fold_flat_exits_with_1_and_says_where(run: Run, tmp_path: Path) -> None:
    pattern = tmp_path / "moved.fold"
    pattern.write_text(fold_file(moved(miura(4, 3, 0.05), 0.03 + 0.02j)))
    finished = run("check", pattern, "--json")
    assert finished.code == 1
    assert finished.err == ""
    found = Foldability.model_validate(finished.json)
    assert not found.foldable
    assert {violation.condition for violation in found.violations} == {"Kawasaki"}


def test_photograph_writes_a_sequence_and_tells_its_progress(run: Run, tmp_path: Path) -> None:
    program = tmp_path / "half.json"
    program.write_text('{"name": "half", "steps": [[{"action": "fold", "edge": [1, 3], "direction": 1}]]}')
    finished = run("photograph", program, "-o", tmp_path / "half", "--seed", "2", "--json")
    assert finished.code == 0
    assert finished.json == {"folder": str(tmp_path / "half"), "name": "half", "frames": 2}
    assert "photographing: 100%" in finished.err
    assert load_sequence(tmp_path / "half").frame_count == 2


def test_keyframes_writes_a_sequence_of_a_video(run: Run, tmp_path: Path) -> None:
    clip = write_clip(tmp_path / "clip.mp4", [Rest(SQUARE), Work(SQUARE, TRIANGLE), Rest(TRIANGLE)])
    finished = run("keyframes", clip.path, "-o", tmp_path / "clip", "--front-color", "white", "--json")
    assert finished.code == 0
    written = load_sequence(tmp_path / "clip")
    assert finished.json["keyframes"] == list(written.keyframes)
    assert written.frame_count == 2
    assert written.front_color == "white"
    assert Path(finished.json["contact_sheet"]).is_file()


@pytest.mark.parametrize(
    ("arguments", "code", "named"),
    [
        (["--sequences", "nowhere"], 2, "nowhere"),
        (["--sequences", "a" * 300], 2, "cannot be looked at"),
        (["--http", "8000"], 1, "HOST:PORT"),
        (["--http", "127.0.0.1:99999"], 1, "HOST:PORT"),
        (["--http", "203.0.113.9:8000"], 1, "203.0.113.9:8000"),
        (["--http", "127.0.0.1:0", "--database", "nonsense"], 1, "nonsense"),
        (["--data", "bad.json/data"], 1, "bad.json/data"),
        (["--colour", "red"], 2, "--colour"),
        (["crumple"], 2, "crumple"),
        (["simulate"], 2, "PROGRAM"),
        (["simulate", "nowhere.json"], 1, "nowhere.json"),
        (["simulate", "bad.json"], 1, "JSON"),
        (["simulate", "impossible.json"], 1, "Step 1, action 1"),
        (["simulate", CAT, "--svg", "nowhere/d.svg"], 1, "nowhere/d.svg"),
        (["check", "nowhere.fold"], 1, "nowhere.fold"),
        (["check", "bad.json"], 1, "JSON"),
        (["check", "."], 1, "directory"),
        (["check", "picture.fold"], 1, "text"),
        (["photograph", CAT], 2, "--out"),
        (["photograph", CAT, "-o", "x", "--level", "9"], 1, "level 9"),
        (["photograph", CAT, "-o", "x", "--between", "99"], 1, "99 images between two keyframes"),
        (["keyframes", "nowhere.mp4", "-o", "x"], 1, "nowhere.mp4"),
    ],
)
def test_a_mistake_is_one_line_on_stderr_and_an_exit_code(
    run: Run,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str | Path],
    code: int,
    named: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bad.json").write_text("this is no JSON")
    Path("impossible.json").write_text('{"steps": [[{"action": "fold", "edge": [1, 9], "direction": 1}]]}')
    Path("picture.fold").write_bytes(b"\xff\xd8\xff\xe0")
    finished = run(*arguments)
    assert finished.code == code
    assert finished.err.count("\n") == 1
    assert named in finished.err
    assert "Traceback" not in finished.err


def test_the_installed_module_runs_as_a_process(tmp_path: Path) -> None:
    assert json_of(server("simulate", CAT, "--json", cwd=tmp_path))["name"] == "figure_d_cat_9_frames"
    refused = server("check", "nowhere.fold", cwd=tmp_path)
    assert refused.returncode == 1
    assert refused.stderr.count("\n") == 1


def test_an_address_in_use_is_refused(run: Run, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        finished = run("--http", f"127.0.0.1:{port}", "--data", tmp_path)
    assert finished.code == 1
    assert f"127.0.0.1:{port}" in finished.err
    assert finished.err.count("\n") == 1


@pytest.mark.skipif(sys.platform == "win32", reason="sends an interrupt as a terminal does on Unix")
def test_an_interrupt_ends_a_server_that_waits_for_input(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "folding_server", "--data", str(tmp_path / "data")]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(INITIALIZE)
        process.stdin.flush()
        assert b"foldingagent" in process.stdout.readline()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=20)
    assert process.returncode == -signal.SIGINT
    assert b"Traceback" not in errors


def test_a_host_that_hangs_up_ends_the_server(tmp_path: Path) -> None:
    finished = server("--data", tmp_path)
    assert finished.returncode == 0
    assert finished.stdout == ""


def test_a_tilde_is_the_users_folder_although_no_shell_has_seen_it(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    (tmp_path / "turn.json").write_text(
        json.dumps({"name": "turn", "steps": [[{"action": "rotate", "angle": 45}]]})
    )
    done = run("simulate", "~/turn.json", "--fold=~/turn.fold", "--every-step", "~/steps")
    assert done.code == 0, done.err
    assert (tmp_path / "turn.fold").exists()
    assert (tmp_path / "steps").is_dir()
    nobody = run("check", "~nobody-of-that-name/x.fold")
    assert nobody.code == 2
    assert "~nobody-of-that-name" in nobody.err


def test_a_file_that_is_no_text_or_not_there_is_one_sentence_that_says_what_to_give(
    run: Run, tmp_path: Path
) -> None:
    (tmp_path / "picture.cp").write_bytes(b"\xff\xd8\xff")
    for command, file, named in (
        ("check", "picture.cp", "is not a text file; give the path of a FOLD or .cp file."),
        (
            "check",
            "gone.cp",
            "cannot be read (No such file or directory); give the path of a FOLD or .cp file.",
        ),
        ("simulate", "picture.cp", "is not a text file; give the path of a JSON file."),
        ("view", "picture.cp", "is not a text file; give a program's JSON file or the folder of a run."),
    ):
        refused = run(command, tmp_path / file)
        assert (refused.code, refused.out) == (1, "")
        assert refused.err == f"foldingagent-server: {tmp_path / file} {named}\n"


def test_the_version_is_that_of_the_package(run: Run) -> None:
    done = run("--version")
    assert done.code == 0
    assert done.out == f"foldingagent-server {version('foldingagent-mcp')}\n"
