"""What a host is told: the command that starts this server, with absolute paths."""

import shutil
import sys
import sysconfig
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from folding_server.install.hosts import Host

ENTRY_NAME = "folding"
"""What hosts call this server."""

SCRIPT = "foldingagent-server"

REMOTE = frozenset({"type", "url", "httpUrl", "serverUrl", "headers", "http_headers", "bearer_token_env_var"})
"""What entries of servers that are reached over HTTP have, beside or instead of a command."""

Entry = Mapping[str, Any]


def server_command(
    sequences: Sequence[Path] = (), data: Path | None = None, allowed: Sequence[Path] = ()
) -> list[str]:
    """The words that start this very installation over stdio, wherever they are said."""
    script = shutil.which(SCRIPT, path=sysconfig.get_path("scripts"))
    start = [str(Path(script).absolute())] if script else [sys.executable, "-m", "folding_server"]
    folders = [word for folder in sequences for word in ("--sequences", str(folder.resolve()))]
    files = [word for folder in allowed for word in ("--allow", str(folder.resolve()))]
    return [*start, *folders, *files, *(["--data", str(data.resolve())] if data else [])]


def entry_for(host: Host, command: Sequence[str], existing: Entry | None = None) -> Entry:
    """A host's entry of a command. What else an ``existing`` entry says, such as environment variables, stays."""
    start = {**host.fields, "command": command[0], "args": list(command[1:])}
    kept = {key: value for key, value in (existing or {}).items() if key not in REMOTE | start.keys()}
    return {**start, **host.defaults, **kept}
