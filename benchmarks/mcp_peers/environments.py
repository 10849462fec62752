"""The environments of the peers: a virtual environment or a folder of npm packages each, made once and kept."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from mcp_peers.versions import NODE

INSTALL_SECONDS = 900
"""How long an installation may take: the largest peer brings 100 MB."""
MADE = "made.json"
"""In the folder of an environment: what was installed. It is written last."""


class PeerBroken(Exception):
    """A peer that could not be installed or run; the message says why."""


def cache_folder() -> Path:
    """Where environments are kept if nothing else is said."""
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "foldingagent-peers"


def python_environment(cache: Path, name: str, *requirements: str) -> Path:
    """The interpreter of a virtual environment with these packages. PeerBroken if they cannot be installed."""
    folder = cache / name
    python = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    if _is_made(folder, requirements):
        return python
    shutil.rmtree(folder, ignore_errors=True)
    _install([sys.executable, "-m", "venv", str(folder)])
    pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    _install([*pip, *requirements])
    _note(folder, requirements)
    return python


def node_environment(cache: Path, name: str, packages: Mapping[str, str]) -> Path:
    """The folder of the commands of these npm packages and of their Node.js. PeerBroken if they cannot be installed."""
    folder = cache / name
    wanted = {"node": NODE, **packages}
    commands = folder / "node_modules" / ".bin"
    if _is_made(folder, wanted):
        return commands
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    manifest = {"private": True, "type": "module", "dependencies": wanted}
    (folder / "package.json").write_text(json.dumps(manifest), encoding="utf-8")
    _install(["npm", "install", "--silent", "--no-audit", "--no-fund", "--prefix", str(folder)])
    _note(folder, wanted)
    return commands


def node_path(commands: Path) -> str:
    """A search path on which a package's commands and its Node.js come first."""
    return f"{commands}{os.pathsep}{os.environ['PATH']}"


def _is_made(folder: Path, wanted: Sequence[str] | Mapping[str, str]) -> bool:
    """Whether an environment holds what is wanted."""
    file = folder / MADE
    return file.exists() and file.read_text(encoding="utf-8") == json.dumps(wanted)


def _note(folder: Path, installed: Sequence[str] | Mapping[str, str]) -> None:
    """Write down what an environment holds."""
    (folder / MADE).write_text(json.dumps(installed), encoding="utf-8")


def _install(command: Sequence[str]) -> None:
    """Run an installation."""
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=INSTALL_SECONDS,
            check=False,
            stdin=subprocess.DEVNULL,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise PeerBroken(f"{command[0]}: {error}") from error
    if done.returncode != 0:
        raise PeerBroken(f"{' '.join(command[:4])}: {(done.stderr or done.stdout)[-LONGEST_TAIL:]}")


LONGEST_TAIL = 400
"""Characters of an installer's last words that are told."""
