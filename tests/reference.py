"""Tests that compare with the reference data: they run where it is and are skipped where it is not.

A test that needs it says what part, ``@pytest.mark.reference("photos/sailboat")``. One that goes through files of it
takes them from ``reference_files`` or ``golden_rows``, which bring the mark along.
"""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from reference_data import REFERENCE, VARIABLE

REQUIRED = "FOLDING_REQUIRE_REFERENCE"
"""The environment variable that makes it an error if the reference data is missing."""
MARK = "reference"
GOLDEN = "flatfold/golden.jsonl"
REASON = f"the reference data is not in {REFERENCE} ({VARIABLE} names another folder)"


def required() -> bool:
    """Whether tests without their reference data fail instead of being skipped."""
    return os.environ.get(REQUIRED, "0") not in {"", "0"}


def missing(item: pytest.Item) -> str | None:
    """The first part of the reference data that a test needs and that is not there."""
    parts = [part for mark in item.iter_markers(MARK) for part in mark.args]
    return next((part for part in parts if not (REFERENCE / part).exists()), None)


def reference_files(folder: str, names: str) -> list[Any]:
    """Parameters for a test: the files of a folder by pattern, or one that is skipped where there is no such folder."""
    return _parameters(folder, [(path.stem, path) for path in sorted((REFERENCE / folder).glob(names))])


def golden_rows(chosen: Callable[[dict[str, Any]], bool]) -> list[Any]:
    """Parameters for a test: what is known of the chosen crease patterns, or one that is skipped without them."""
    path = REFERENCE / GOLDEN
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    rows = [row for row in map(json.loads, lines) if chosen(row)]
    return _parameters(GOLDEN, [(row["name"], row) for row in rows])


def golden_file(row: dict[str, Any]) -> Path:
    """The FOLD file of a crease pattern of the reference data."""
    return REFERENCE / "flatfold" / "patterns" / f"{row['name']}.fold"


def _parameters(part: str, named: list[tuple[str, Any]]) -> list[Any]:
    """``named`` values as parameters that need a part of the reference data; without any, one for the report."""
    mark = pytest.mark.reference(part)
    return [pytest.param(value, id=name, marks=mark) for name, value in named or [("missing", None)]]
