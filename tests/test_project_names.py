"""Each public name and each file name of the project means one thing."""

import ast
from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = (
    "schemas/folding_schemas",
    "prompts/folding_prompts",
    "server/folding_server",
    "client/folding_client",
)
ANY_PACKAGE_HAS = frozenset({"__init__.py", "__main__.py", "cli.py"})

SERVER, CLIENT = "server/folding_server", "client/folding_client"
Places = Mapping[str, frozenset[str]]
"""Name -> the files that define it."""

MIGRATIONS = frozenset(
    f"{SERVER}/store/migrations/versions/{step}.py" for step in ("events", "request_ids", "runs_and_owners")
)
TOOLS, SIMULATOR = f"{SERVER}/mcp/tools/folding.py", f"{SERVER}/simulator"
COMMANDS = frozenset({f"{SERVER}/cli.py", f"{CLIENT}/cli.py"})
NAMES_ALIKE: Places = {
    # A tool calls the action that it is named for.
    "add_vertex": frozenset({TOOLS, f"{SIMULATOR}/vertices.py"}),
    "fold": frozenset({TOOLS, f"{SIMULATOR}/fold.py"}),
    "unfold": frozenset({TOOLS, f"{SIMULATOR}/unfold.py"}),
    "rotate": frozenset({TOOLS, f"{SIMULATOR}/motions.py"}),
    "flip": frozenset({TOOLS, f"{SIMULATOR}/motions.py"}),
    # A subcommand calls the function that it is named for.
    "refold": frozenset({f"{SERVER}/wording/refold_command.py", f"{SERVER}/wording/refolding.py"}),
    "photograph": frozenset({f"{SERVER}/cli.py", f"{SERVER}/photographer/photographing.py"}),
    "serve": frozenset({f"{SERVER}/cli.py", f"{SERVER}/mcp/http/serving.py"}),
    "simulate": frozenset({f"{SERVER}/cli.py", f"{SERVER}/simulate.py"}),
    # Each of the two commands is one application with one entry.
    "app": COMMANDS,
    "main": COMMANDS,
    # What alembic looks for in each step from a version of the tables to the next.
    "down_revision": MIGRATIONS,
    "revision": MIGRATIONS,
    "upgrade": MIGRATIONS,
    # Called by the names of their modules: what they give the server.
    "register": frozenset({f"{SERVER}/mcp/prompts.py", f"{SERVER}/mcp/resources.py"}),
}
FILES_ALIKE: Places = {
    # The protocol's side of the errors and of the results.
    "errors.py": frozenset({f"{SERVER}/errors.py", f"{SERVER}/mcp/errors.py"}),
    "results.py": frozenset({"schemas/folding_schemas/results.py", f"{SERVER}/mcp/results.py"}),
    # The context of a call is MCP's word, the context of a language model is that field's.
    "context.py": frozenset({f"{SERVER}/mcp/context.py", f"{CLIENT}/agent/context.py"}),
}


def sources() -> Iterator[Path]:
    for package in PACKAGES:
        yield from sorted((ROOT / package).rglob("*.py"))


def names_in(target: ast.expr) -> Iterator[str]:
    """The names that an assignment to a target defines."""
    match target:
        case ast.Name(id=name):
            yield name
        case ast.Tuple(elts=parts) | ast.List(elts=parts):
            for part in parts:
                yield from names_in(part)
        case ast.Starred(value=value):
            yield from names_in(value)


def public_names(source: str) -> set[str]:
    """The public names that a module defines itself, outside of its functions and classes."""
    defined: set[str] = set()
    for statement in ast.parse(source).body:
        match statement:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                defined.add(name)
            case ast.Assign(targets=targets):
                defined.update(name for target in targets for name in names_in(target))
            case ast.AnnAssign(target=target):
                defined.update(names_in(target))
    return {name for name in defined if not name.startswith("_")}


def more_than_once(places: Mapping[str, set[str]]) -> Places:
    return {name: frozenset(paths) for name, paths in places.items() if len(paths) > 1}


@pytest.fixture(scope="module")
def names() -> Places:
    """The public names that more than one module defines."""
    places: dict[str, set[str]] = defaultdict(set)
    for path in sources():
        for name in public_names(path.read_text(encoding="utf-8")):
            places[name].add(path.relative_to(ROOT).as_posix())
    return more_than_once(places)


@pytest.fixture(scope="module")
def file_names() -> Places:
    """The file names that occur more than once."""
    places: dict[str, set[str]] = defaultdict(set)
    for path in sources():
        if path.name not in ANY_PACKAGE_HAS:
            places[path.name].add(path.relative_to(ROOT).as_posix())
    return more_than_once(places)


def undeclared(found: Places, declared: Places) -> list[str]:
    """What occurs more than once, or elsewhere than it was declared to, one line each."""
    return [
        f"{name}: {', '.join(sorted(paths))}"
        for name, paths in sorted(found.items())
        if paths != declared.get(name)
    ]


def test_a_public_name_is_defined_in_one_module(names: Places) -> None:
    assert undeclared(names, NAMES_ALIKE) == []


def test_a_file_name_occurs_once(file_names: Places) -> None:
    assert undeclared(file_names, FILES_ALIKE) == []


def test_no_exception_has_outlived_its_reason(names: Places, file_names: Places) -> None:
    assert sorted(NAMES_ALIKE.keys() - names.keys()) == []
    assert sorted(FILES_ALIKE.keys() - file_names.keys()) == []


@pytest.mark.parametrize(
    ("source", "defined"),
    [
        ("A = 1", {"A"}),
        ("A, (B, *C) = 1, (2, 3)", {"A", "B", "C"}),
        ("A: int = 1", {"A"}),
        ("def f(): g = 1", {"f"}),
        ("async def f(): ...", {"f"}),
        ("class C:\n    inner = 1", {"C"}),
        ("_A = 1\ndef _f(): ...", set()),
        ("from elsewhere import A", set()),
    ],
)
def test_every_way_of_defining_a_public_name_is_seen(source: str, defined: set[str]) -> None:
    assert public_names(source) == defined
