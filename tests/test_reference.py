"""Tests without their reference data are skipped and counted in one line, or fail where it is required."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from paths import ROOT
from reference import REQUIRED
from reference_data import VARIABLE

GOLDEN = "tests/test_foldability_golden.py"
NO_SUCH_FOLDER = Path("no") / "such" / "folder"


def run(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Pytest on a file whose tests all need the reference data."""
    kept = {key: value for key, value in os.environ.items() if key not in {VARIABLE, REQUIRED}}
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", GOLDEN, *arguments],
        cwd=ROOT,
        env={**kept, VARIABLE: str(NO_SUCH_FOLDER), **environment},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [("-n", "0"), ("-n", "1")], ids=["alone", "in parallel"])
def test_without_the_reference_data_tests_are_skipped_and_one_line_says_how_many_and_why(
    arguments: tuple[str, ...],
) -> None:
    done = run(*arguments)
    assert done.returncode == 0
    assert done.stdout.count("tests skipped:") == 1
    assert f"tests skipped: 5; the reference data is not in {NO_SUCH_FOLDER}" in done.stdout
    assert VARIABLE in done.stdout


def test_where_the_reference_data_is_required_its_absence_is_an_error() -> None:
    done = run("-n", "0", **{REQUIRED: "1"})
    assert done.returncode == 1
    assert "5 errors" in done.stdout or done.stdout.count("ERROR ") == 5
    assert f"{REQUIRED} is set, but there is no flatfold/golden.jsonl" in done.stdout
    assert "Traceback" not in done.stdout
