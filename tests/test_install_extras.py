"""What is said where a package of an extra is missing, and that nothing else needs it."""

import subprocess
import sys
from pathlib import Path

import pytest
from client_runs import run
from folding_client.interrupts import UsageError
from folding_client.reconstruct import versions
from folding_server.errors import FoldingError
from folding_server.simulator.foldability import check_pattern
from test_foldability import grid


@pytest.fixture
def no_litellm(monkeypatch: pytest.MonkeyPatch) -> None:
    """An environment without litellm."""
    monkeypatch.setitem(sys.modules, "litellm", None)


@pytest.fixture
def no_ortools(monkeypatch: pytest.MonkeyPatch) -> None:
    """An environment without OR-Tools."""
    monkeypatch.setitem(sys.modules, "ortools.sat.python", None)


@pytest.mark.usefixtures("no_litellm")
def test_a_language_model_without_litellm_is_refused_with_what_to_install(tmp_path: Path) -> None:
    with pytest.raises(UsageError) as refusal:
        run(2, tmp_path / "run", model="litellm/openai/gpt-4o")
    said = str(refusal.value)
    assert "'litellm/openai/gpt-4o'" in said
    assert "pip install 'foldingagent-mcp[agent]'" in said
    assert "\n" not in said
    assert not (tmp_path / "run").exists()


@pytest.mark.usefixtures("no_litellm")
def test_a_run_without_litellm_records_no_version_of_it() -> None:
    assert "litellm" not in versions()


def test_the_version_of_litellm_is_recorded_where_it_is_installed() -> None:
    assert versions()["litellm"]


@pytest.mark.usefixtures("no_ortools")
def test_a_pattern_that_the_search_settles_needs_no_ortools() -> None:
    assert check_pattern(grid(3, 3)).foldable


@pytest.mark.usefixtures("no_ortools")
def test_a_pattern_that_needs_ortools_is_refused_with_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("folding_server.simulator.foldability.search.EFFORT", 0)
    with pytest.raises(FoldingError) as refusal:
        check_pattern(grid(5, 5))
    said = str(refusal.value)
    assert "pip install 'foldingagent-mcp[foldability]'" in said
    assert "\n" not in said


def test_a_video_without_pyav_is_refused_with_what_to_install(tmp_path: Path) -> None:
    """In a process of its own, since modules that are loaded stay loaded."""
    script = (
        "import sys; sys.modules['av'] = None; from folding_server.cli import main; "
        f"main(['keyframes', 'film.mp4', '-o', {str(tmp_path / 'out')!r}])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "pip install 'foldingagent-mcp[video]'" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()
