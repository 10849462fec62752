"""Nothing that macOS, Linux or Windows lacks is needed to import our packages."""

import ast
from collections.abc import Iterator

import pytest
from paths import ROOT

POSIX_MODULES = {"fcntl", "grp", "posix", "pty", "pwd", "readline", "resource", "syslog", "termios", "tty"}
WINDOWS_MODULES = {"_winapi", "msvcrt", "nt", "winreg", "winsound"}
GONE = {"crypt", "nis", "spwd", "imp", "distutils"}  # removed by Python 3.13
MISSING = {
    "signal": {
        "SIGHUP",
        "SIGKILL",
        "SIGALRM",
        "SIGUSR1",
        "SIGUSR2",
        "SIGPIPE",
        "SIGCHLD",
        "SIGQUIT",
        "alarm",
        "pause",
    },
    "os": {
        "fork",
        "getuid",
        "geteuid",
        "getgid",
        "getpgid",
        "setsid",
        "killpg",
        "nice",
        "uname",
        "mkfifo",
        "sched_getaffinity",
    },
    "socket": {"AF_UNIX", "SO_REUSEPORT"},
    "asyncio": {"start_unix_server", "open_unix_connection"},
    "time": {"tzset"},
}
"""What one of the three lacks, by the module it is asked of (the "Availability" notes of Python's library reference)."""

GUARDS = {"platform", "name", "hasattr", "TYPE_CHECKING"}
"""A condition that speaks of one of these asks where it runs."""


def lacking(source: str) -> Iterator[str]:
    """What a module asks for when it is imported, without asking where it runs, that a system lacks."""
    for node in _at_import(ast.parse(source).body):
        match node:
            case ast.Import(names=names):
                asked = {name.name.partition(".")[0] for name in names}
                yield from asked & (POSIX_MODULES | WINDOWS_MODULES | GONE)
            case ast.ImportFrom(module=str(module), names=names, level=0):
                yield from {module} & (POSIX_MODULES | WINDOWS_MODULES | GONE)
                yield from {name.name for name in names} & MISSING.get(module, set())
            case ast.Attribute(value=ast.Name(id=module), attr=name) if name in MISSING.get(module, ()):
                yield f"{module}.{name}"


def _at_import(body: list[ast.stmt]) -> Iterator[ast.AST]:
    """Every node that is run when a module is imported, but for those behind a guard."""
    for statement in body:
        match statement:
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                arguments = statement.args
                for part in (
                    *statement.decorator_list,
                    *arguments.defaults,
                    *filter(None, arguments.kw_defaults),
                ):
                    yield from ast.walk(part)
            case ast.ClassDef():
                yield from _at_import(statement.body)
            case ast.If() if not _asks_where(statement.test):
                yield from _at_import([*statement.body, *statement.orelse])
            case ast.With() | ast.For() | ast.While():
                yield from _at_import(statement.body)
            case ast.Try() if not _forgives(statement):
                yield from _at_import([*statement.body, *statement.finalbody])
            case ast.If() | ast.Try():
                continue
            case _:
                yield from ast.walk(statement)


def _asks_where(test: ast.expr) -> bool:
    words = {node.id for node in ast.walk(test) if isinstance(node, ast.Name)}
    words |= {node.attr for node in ast.walk(test) if isinstance(node, ast.Attribute)}
    return bool(words & GUARDS)


def _forgives(attempt: ast.Try) -> bool:
    caught = {
        node.id for handler in attempt.handlers for node in ast.walk(handler) if isinstance(node, ast.Name)
    }
    return bool(caught & {"ImportError", "ModuleNotFoundError", "AttributeError"})


def test_no_module_needs_at_import_what_a_system_lacks() -> None:
    files = [
        file
        for folder in ("schemas", "prompts", "server", "client")
        for file in (ROOT / folder).rglob("*.py")
    ]
    assert len(files) > 100
    wrong = {str(file.relative_to(ROOT)): list(lacking(file.read_text(encoding="utf-8"))) for file in files}
    assert {name: found for name, found in wrong.items() if found} == {}


@pytest.mark.parametrize(
    "source",
    [
        "import fcntl",
        "import os, resource",
        "from termios import tcgetattr",
        "from signal import SIGHUP",
        "import signal\nENDINGS = (signal.SIGTERM, signal.SIGHUP)",
        "import os\nclass A:\n    user = os.getuid()",
        "import os\ndef f(user=os.getuid()):\n    pass",
        "try:\n    import msvcrt\nexcept ValueError:\n    pass",
        "if True:\n    import pwd",
    ],
)
def test_what_a_system_lacks_is_found(source: str) -> None:
    assert list(lacking(source))


@pytest.mark.parametrize(
    "source",
    [
        "import sys\nif sys.platform == 'win32':\n    import msvcrt\nelse:\n    import fcntl",
        "try:\n    import resource\nexcept ImportError:\n    resource = None",
        "def late():\n    import fcntl",
        "import signal\nENDINGS = [signal.SIGTERM]\nif hasattr(signal, 'SIGHUP'):\n    ENDINGS.append(signal.SIGHUP)",
    ],
)
def test_what_is_guarded_or_late_is_left_alone(source: str) -> None:
    assert list(lacking(source)) == []
