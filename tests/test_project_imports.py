"""Who may import whom: the server holds the geometry, the client the language models, and they only talk."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from paths import ROOT

OURS = {"folding_schemas", "folding_prompts", "folding_server", "folding_client"}
GEOMETRY = {"cv2", "shapely", "ortools", "networkx", "av", "cairosvg", "numpy", "scipy", "PIL"}
FORBIDDEN = {
    "folding_schemas": OURS | GEOMETRY | {"mcp", "litellm"},
    "folding_prompts": OURS | GEOMETRY | {"mcp", "litellm", "pydantic"},
    "folding_server": {"folding_client", "litellm", "openai", "anthropic"},
    "folding_client": {"folding_server"}
    | (GEOMETRY - {"PIL"}),  # which makes pictures smaller and joins them
}
ARITHMETIC = {"numpy", "scipy"}
COMPUTES = ROOT / "client" / "folding_client" / "evaluation"
"""The one package of the client that computes: scores of states that the server has measured."""


def imported(source: str) -> Iterator[str]:
    """The top packages that a module imports, wherever in it, by statement or by name."""
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Import(names=names):
                yield from (name.name.partition(".")[0] for name in names)
            case ast.ImportFrom(module=str(module), level=0):
                yield module.partition(".")[0]
            case ast.Call(
                func=ast.Name(id="import_module" | "__import__") | ast.Attribute(attr="import_module"),
                args=[ast.Constant(value=str(module)), *_],
            ):
                yield module.partition(".")[0]


def modules(package: str) -> list[Path]:
    """The modules of a package."""
    return sorted((ROOT / package.removeprefix("folding_") / package).rglob("*.py"))


@pytest.mark.parametrize("package", sorted(OURS))
def test_a_package_imports_only_what_it_may(package: str) -> None:
    assert modules(package)
    wrong = [
        f"{file.relative_to(ROOT)} imports {name}"
        for file in modules(package)
        for name in imported(file.read_text())
        if name in FORBIDDEN[package] - {package} - (ARITHMETIC if COMPUTES in file.parents else set())
    ]
    assert wrong == []


def test_no_test_and_no_benchmark_changes_where_modules_are_found() -> None:
    changed = "sys." + "path"
    files = [file for folder in ("tests", "benchmarks", "scripts") for file in (ROOT / folder).rglob("*.py")]
    assert files
    assert [file.name for file in files if changed in file.read_text(encoding="utf-8")] == []


@pytest.mark.parametrize(
    "source",
    [
        "import folding_server",
        "import folding_server.simulator.paper as paper",
        "from folding_server import app",
        "def late():\n    from folding_server.mcp.server import FoldingServer",
        "import importlib\nimportlib.import_module('folding_server.mcp.server')",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import folding_server",
    ],
)
def test_no_way_to_import_is_overlooked(source: str) -> None:
    assert "folding_server" in set(imported(source))
