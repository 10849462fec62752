"""The page that shows the architecture names only what is there."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest
from paths import ROOT

PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
FUNCTIONS = ast.FunctionDef | ast.AsyncFunctionDef
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)?")


def quoted(line: str) -> list[str]:
    return re.findall(r"`([^`]+)`", line)


def paths_in(line: str) -> list[Path]:
    return [
        ROOT / text
        for text in quoted(line)
        if text.split("/", 1)[0] in {"server", "client", "schemas", "prompts"}
    ]


@cache
def defined_in(path: Path) -> frozenset[str]:
    """Functions, classes, methods and assigned names of a module, methods as ``Class.method``."""
    found: set[str] = set()
    for statement in ast.parse(path.read_text(encoding="utf-8")).body:
        match statement:
            case ast.ClassDef(name=name, body=body):
                found |= {name, *(f"{name}.{each.name}" for each in body if isinstance(each, FUNCTIONS))}
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                found.add(name)
            case ast.Assign(targets=[ast.Name(id=name)]) | ast.AnnAssign(target=ast.Name(id=name)):
                found.add(name)
    return frozenset(found)


STEPS = [line for line in PAGE.splitlines() if re.match(r"\d+\. ", line)]


def test_every_file_and_folder_on_the_page_exists() -> None:
    named = [path for line in PAGE.splitlines() for path in paths_in(line)]
    assert len(named) > 50
    assert [path for path in named if not path.exists()] == []


@pytest.mark.parametrize("step", STEPS, ids=lambda step: " ".join(step.split()[:4]))
def test_every_name_of_a_step_is_defined_in_a_file_that_the_step_names(step: str) -> None:
    names = [text for text in quoted(step) if NAME.fullmatch(text)]
    defined = frozenset[str]().union(*(defined_in(path) for path in paths_in(step) if path.suffix == ".py"))
    assert names
    assert [name for name in names if name not in defined] == []


def test_every_package_of_the_code_is_on_the_page() -> None:
    packages = [
        folder
        for root in ("server/folding_server", "client/folding_client")
        for folder in (ROOT / root).iterdir()
        if (folder / "__init__.py").is_file()
    ]
    assert [
        folder.name
        for folder in packages
        if folder not in {p for line in PAGE.splitlines() for p in paths_in(line)}
    ] == []
