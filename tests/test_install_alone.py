"""The wheel in an environment that holds only what it requires: no checkout, no extras, nothing of the system."""

import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterable
from importlib.metadata import Distribution, distribution
from pathlib import Path

import pytest
from mcp import Client, StdioServerParameters
from mcp.types import CallToolResult, ImageContent
from packaging.requirements import Requirement
from paths import ROOT

MOST_MEGABYTES = 450
"""What the wheel and all that it requires may take on disk, compiled files among it."""
LEFT_OUT = ("litellm", "ortools", "pandas", "av", "cairosvg", "cairocffi", "distributed")


def required(names: Iterable[str]) -> dict[str, Distribution]:
    """The installed distributions that some requirements ask for, and what those require in turn, by name."""
    found: dict[str, Distribution] = {}
    waiting = [Requirement(name) for name in names]
    while waiting:
        wanted = waiting.pop()
        key = "+".join([re.sub(r"[-_.]+", "-", wanted.name).lower(), *sorted(wanted.extras)])
        if key in found or (wanted.marker and not wanted.marker.evaluate({"extra": ""})):
            continue
        found[key] = distribution(wanted.name)
        inner = [Requirement(text) for text in found[key].requires or ()]
        extras = [{"extra": extra} for extra in ("", *wanted.extras)]
        waiting += [
            Requirement(str(other).partition(";")[0])
            for other in inner
            if not other.marker or any(other.marker.evaluate(extra) for extra in extras)
        ]
    return found


@pytest.fixture(scope="module")
def distributions() -> dict[str, Distribution]:
    """All that the project requires without extras."""
    return required(tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"])


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory, distributions: dict[str, Distribution]) -> Path:
    """The packages of a new environment: the unpacked wheel, and links to the distributions that it requires."""
    folder = tmp_path_factory.mktemp("alone")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder / "venv")], check=True)
    (packages,) = (folder / "venv").glob("lib/python*/site-packages")
    (wheel,) = folder.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(packages)
    for place in {top for one in distributions.values() for top in tops(one)}:
        (packages / place.name).symlink_to(place)
    return packages


def tops(installed: Distribution) -> set[Path]:
    """The files and folders of a distribution that lie in site-packages itself."""
    names = {file.parts[0] for file in installed.files or ()} - {"..", "__pycache__"}
    return {Path(str(installed.locate_file(name))).absolute() for name in names}


@pytest.fixture(scope="module")
def python(site: Path) -> str:
    """The interpreter of that environment."""
    return str(site.parents[2] / "bin" / "python")


def run(python: str, folder: Path, *words: str | Path) -> subprocess.CompletedProcess[str]:
    """A finished ``python -m`` command, started in a folder far from the checkout."""
    command = [python, "-m", *map(str, words)]
    environment = {"PATH": os.environ["PATH"], "HOME": str(folder)}
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=300
    )


def test_the_environment_holds_none_of_the_extras_and_nothing_of_the_checkout(
    python: str, tmp_path: Path
) -> None:
    script = f"import importlib.util as u; print([n for n in {LEFT_OUT!r} if u.find_spec(n)]); import folding_server as f; print(f.__file__)"
    done = subprocess.run([python, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    left, place = done.stdout.splitlines()
    assert left == "[]"
    assert not Path(place).is_relative_to(ROOT)


def test_the_wheel_and_what_it_requires_are_light(distributions: dict[str, Distribution], site: Path) -> None:
    files = {Path(str(one.locate_file(file))) for one in distributions.values() for file in one.files or ()}
    files |= {
        file
        for name in ("folding_*", "foldingagent*")
        for folder in site.glob(name)
        for file in folder.rglob("*")
    }
    megabytes = sum(file.stat().st_size for file in files if file.is_file()) / 2**20
    assert 100 < megabytes < MOST_MEGABYTES


@pytest.mark.slow
def test_a_program_is_folded_and_drawn(python: str, tmp_path: Path) -> None:
    program = ROOT / "examples/programs/cat.json"
    done = run(
        python, tmp_path, "folding_server", "simulate", program, "--png", "cat.png", "--fold", "cat.fold"
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "cat.png").read_bytes().startswith(b"\x89PNG")
    checked = run(python, tmp_path, "folding_server", "check", "cat.fold")
    assert checked.returncode == 0, checked.stderr


@pytest.mark.slow
@pytest.mark.anyio
async def test_a_host_folds_and_sees_the_paper(python: str, tmp_path: Path) -> None:
    words = ["-m", "folding_server", "--data", str(tmp_path), "--sequences", str(ROOT / "examples")]
    async with Client(StdioServerParameters(command=python, args=words, cwd=tmp_path)) as client:
        for tool, arguments in (
            ("open_run", {"sequence": "cat"}),
            ("save_checkpoint", {"frame": 1}),
            ("view_frame", {"frame": 2}),
            ("propose_actions", {"frame": 2}),
            ("rotate", {"angle": 45}),
            ("check_foldability", {}),
            ("render_current", {}),
        ):
            answer = await client.call_tool(tool, arguments)
            assert isinstance(answer, CallToolResult)
            assert not answer.is_error, answer.content
        assert any(isinstance(block, ImageContent) for block in answer.content)


@pytest.mark.slow
def test_the_geometric_client_reconstructs_a_sequence(python: str, tmp_path: Path) -> None:
    fold = {"action": "fold", "edge": [4, 2], "direction": 1}
    (tmp_path / "program.json").write_text(json.dumps({"name": "triangle", "steps": [[fold]]}))
    made = run(python, tmp_path, "folding_server", "photograph", "program.json", "-o", "triangle")
    assert made.returncode == 0, made.stderr
    done = run(python, tmp_path, "folding_client", "run", "triangle", "--out", "run", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["status"] == "complete"


def test_a_language_model_is_refused_before_anything_is_made(python: str, tmp_path: Path) -> None:
    words = (
        "folding_client",
        "run",
        ROOT / "examples/cup",
        "--out",
        "run",
        "--model",
        "litellm/openai/gpt-4o",
    )
    done = run(python, tmp_path, *words)
    assert done.returncode == 2
    assert "pip install 'foldingagent-mcp[agent]'" in done.stderr
    assert done.stderr.strip().count("\n") == 0
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
def test_a_video_is_refused_with_what_to_install(python: str, tmp_path: Path) -> None:
    (tmp_path / "film.mp4").write_bytes(b"film")
    for words in (
        ("folding_server", "keyframes", "film.mp4", "-o", "out"),
        ("folding_client", "run", "film.mp4"),
    ):
        done = run(python, tmp_path, *words)
        assert done.returncode != 0
        assert "pip install 'foldingagent-mcp[video]'" in done.stderr
        assert "Traceback" not in done.stderr
