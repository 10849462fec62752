"""Every command that README and pages give is run, or its programs, options and paths are looked up."""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import urllib.request
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import yaml
from documented_commands import NOT_RUN, PROGRAMS, Command, documented
from folding_client.cli import app as client
from folding_client.cli import main as client_main
from folding_server.cli import app as server
from folding_server.cli import main as server_main
from folding_server.interchange.fold_format import fold_document, fold_text
from folding_server.interchange.obj import obj_text
from folding_server.simulator import new_paper
from paths import ROOT
from PIL import Image
from typer.main import get_command
from videos import SQUARE, Rest, write_clip

COMMANDS: dict[str, Any] = {"foldingagent": get_command(client), "foldingagent-server": get_command(server)}
MODULES = {"foldingagent": "folding_client", "foldingagent-server": "folding_server"}
MAINS: dict[str, Callable[[Sequence[str]], None]] = {
    "foldingagent": client_main,
    "foldingagent-server": server_main,
}
KEPT_FRAMES = {"examples/cat": 2, "SEQUENCE": 1, "sequences/cat": 1}
"""Photos of the example that a sequence has: one step says whether all of them work, and the flat sheet whether a command does."""
PHOTO_SIDE = 240
"""Pixels: enough for one action."""
MAKES_RUN = "foldingagent run SEQUENCE --out RUN"
"""It is run once for all commands that need its run."""
RUN = {command.shape: command for command in documented() if command.why_not_run is None}
"""Commands that differ only in the names of files are run once."""
LOOKED_UP = [command for command in documented() if command.why_not_run is not None]


def environment(home: Path) -> dict[str, str]:
    """A user without settings, whose folders are below the checkout."""
    return {"PATH": os.environ["PATH"], "HOME": str(home), "XDG_DATA_HOME": str(home / ".data")}


def finished(words: Sequence[str], place: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """How a command of ours ends, in this process."""
    monkeypatch.chdir(place)
    for name, value in environment(place).items():
        monkeypatch.setenv(name, value)
    try:
        MAINS[words[0]](words[1:])
    except SystemExit as ended:
        return int(ended.code or 0)
    return 0


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A checkout in which the files exist that the commands name: VIDEO is a film, RUN a run, and so on."""
    place = tmp_path_factory.mktemp("checkout")
    shutil.copytree(ROOT / "examples" / "programs", place / "examples" / "programs")
    whole = json.loads((place / "examples" / "programs" / "cat.json").read_text())
    (place / "PROGRAM").write_text(json.dumps({**whole, "steps": whole["steps"][:1]}))
    (place / "WORDS.txt").write_text("1. Rotate the paper 45° clockwise.\n", encoding="utf-8")
    for folder, frames in KEPT_FRAMES.items():
        shorten(ROOT / "examples" / "cat", place / folder, frames)
    shutil.copytree(place / "sequences", place / "FOLDER")
    (place / "Movies").mkdir()
    shutil.copy(write_clip(place / "clip.mp4", [Rest(SQUARE)]).path, place / "VIDEO")
    with pytest.MonkeyPatch.context() as patch:
        for pattern in ("PATTERN.fold", "PATTERN.cp"):
            written = ["foldingagent-server", "simulate", "PROGRAM", "--cp", pattern]
            assert finished(written, place, patch) == 0
        assert finished(["foldingagent", "run", "SEQUENCE", "--out", "RUN"], place, patch) == 0
    (place / "STATES").mkdir()
    (place / "STATES" / "1.fold").write_text(fold_text(fold_document(new_paper())))
    (place / "MESH.obj").write_text(obj_text(new_paper()))
    shutil.copytree(place / "RUN", place / "runs" / "cat-20260101-120000")
    return place


def shorten(source: Path, target: Path, frames: int) -> None:
    """A sequence's first photos, made small."""
    manifest = json.loads((source / "keyframes.json").read_text())
    kept = manifest["keyframes"][:frames]
    (target / "frames").mkdir(parents=True)
    for frame in kept:
        with Image.open(source / "frames" / f"{frame:06}.jpg") as photo:
            photo.resize((PHOTO_SIDE, PHOTO_SIDE)).save(target / "frames" / f"{frame:06}.jpg")
    (target / "keyframes.json").write_text(json.dumps({**manifest, "keyframes": kept}))


@pytest.fixture
def checkout(template: Path, tmp_path: Path) -> Path:
    """A copy of it for one command."""
    return Path(shutil.copytree(template, tmp_path / "checkout"))


@pytest.mark.slow
@pytest.mark.parametrize("command", RUN.values(), ids=lambda command: command.text)
def test_the_command_works(command: Command, checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if command.text == MAKES_RUN:
        assert (checkout / "RUN" / "program.json").exists()
        return
    words = [word.replace(":8000", ":0") for word in command.words]
    prepare(words, checkout)
    if "--http" in words:
        with answering(words, checkout, r"http://127\.0\.0\.1:\d+") as address:
            assert json.loads(read(f"{address}/health")) == {"status": "ok"}
    elif "view" in words and "-o" not in words:
        with answering(words, checkout, r"http://127\.0\.0\.1:\d+/") as address:
            assert b"<html" in read(address)
    elif COMMANDS[words[0]].commands.keys().isdisjoint(words):
        done = subprocess.run(
            program(words),
            check=True,
            cwd=checkout,
            env=environment(checkout),
            input=PING,
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert json.loads(done.stdout)["result"] == {}
    else:
        assert finished(words, checkout, monkeypatch) == 0


def prepare(words: Sequence[str], place: Path) -> None:
    """A run that is to be gone on with has not ended."""
    if "--resume" in words:
        file = place / words[words.index("--resume") + 1] / "run.json"
        told = json.loads(file.read_text())
        file.write_text(json.dumps({**told, "outcome": {**told["outcome"], "status": "stopped"}}))


PING = json.dumps({"jsonrpc": "2.0", "id": 1, "method": "ping"}) + "\n"


def program(words: Sequence[str]) -> list[str]:
    """A command of ours as a process of this interpreter."""
    return [sys.executable, "-m", MODULES[words[0]], *words[1:]]


@contextmanager
def answering(words: list[str], place: Path, address: str) -> Iterator[str]:
    """A command that goes on until it is ended; yields the address that it tells."""
    with subprocess.Popen(
        program(words),
        cwd=place,
        env=environment(place),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            found = next(filter(None, (re.search(address, line) for line in process.stdout)))
            yield found.group()
        finally:
            process.terminate()
            process.communicate(timeout=20)


def read(address: str) -> bytes:
    """What a local address answers."""
    with urllib.request.urlopen(address, timeout=20) as answer:  # noqa: S310 - an address of our own
        body: bytes = answer.read()
    return body


@pytest.mark.parametrize("command", LOOKED_UP, ids=lambda command: command.text)
def test_the_command_that_is_not_run_names_what_exists(command: Command) -> None:
    words = list(command.words)
    check = {
        "scripts": check_script,
        "docker": check_services,
        "pip": check_package,
        "uvx": check_package,
        "uv": check_package,
    }
    check.get(words[0].split("/")[0], check_ours)(words)


def check_script(words: list[str]) -> None:
    """Whether a script of the project exists; with Python's, whether it knows the options."""
    if words[0].endswith(".py"):
        check_ours(words)
    else:
        assert os.access(ROOT / words[0], os.X_OK), words[0]


def check_services(words: list[str]) -> None:
    services = yaml.safe_load((ROOT / "docker-compose.yml").read_text())["services"]
    assert words[1] == "compose"
    named = [word for word in words[2:] if not word.startswith("-") and word not in {"up", "run"}]
    assert named[0] in services


def check_package(words: list[str]) -> None:
    """Whether the extras and the command that are asked for exist."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for extras in re.findall(r"\[([\w,]+)\]", " ".join(words)):
        assert set(extras.split(",")) <= set(project["optional-dependencies"])
    if words[0] == "uvx":
        assert words[-1] in project["scripts"]


def check_ours(words: list[str]) -> None:
    """Whether our command within other words, or a script that Python runs, has these subcommands and options."""
    if words[0] == "npx":
        words = words[: words.index("--method")] if "--method" in words else words
        if words[-1].startswith("http"):
            return
    names = [Path(word).name for word in words]
    start = next((at for at, name in enumerate(names) if name in COMMANDS), None)
    if start is None:
        script = next(word for word in words if word.endswith(".py") or word == "pytest")
        assert script == "pytest" or (ROOT / script).exists(), script
        source = "" if script == "pytest" else (ROOT / script).read_text()
        assert [word for word in words if word.startswith("--") and word not in source] == []
        return
    command, arguments = COMMANDS[names[start]], words[start + 1 :]
    if arguments and arguments[0] in getattr(command, "commands", {}):
        command, arguments = command.commands[arguments[0]], arguments[1:]
    known = {name for option in command.params for name in (*option.opts, *option.secondary_opts)}
    assert {word for word in arguments if re.match(r"--?[a-z]", word)} <= known


def test_no_block_is_passed_over() -> None:
    """Every line of every block that is not known to be something else begins with a program that is known."""
    unknown = [
        (command.page, command.text)
        for command in documented()
        if command.words[0] not in PROGRAMS
        and not command.in_text
        and not command.words[0].endswith("oldest/bin/python")
    ]
    assert unknown == []


def test_no_reason_has_outlived_its_command() -> None:
    texts = [command.text for command in documented()]
    assert [
        why for pattern, why in NOT_RUN.items() if not any(re.match(pattern, text) for text in texts)
    ] == []


def test_most_commands_are_run() -> None:
    assert len(RUN) >= 15
    assert len(documented()) >= 50
