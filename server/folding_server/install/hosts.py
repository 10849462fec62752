"""The MCP hosts: where each keeps its list of servers, and how an entry of it is written."""

import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any, Literal

CODEX_STARTUP_SECONDS = 60
"""How long Codex may wait for the server: its own 10 s are short where a first start has to load everything from a slow disk."""


class HostId(StrEnum):
    """The hosts by the names of ``--host``."""

    CLAUDE_DESKTOP = "claude-desktop"
    CLAUDE_CODE = "claude-code"
    VSCODE = "vscode"
    CURSOR = "cursor"
    GEMINI_CLI = "gemini-cli"
    CODEX = "codex"


@dataclass(frozen=True)
class Machine:
    """What decides where a host's file is."""

    system: str = sys.platform
    home: Path = field(default_factory=Path.home)
    environment: Mapping[str, str] = field(default_factory=lambda: os.environ)

    def app_data(self) -> Path:
        """The folder in which desktop applications made with Electron keep their settings: its ``appData``."""
        if self.system == "win32":
            return Path(self.environment.get("APPDATA") or self.home / "AppData" / "Roaming")
        if self.system == "darwin":
            return self.home / "Library" / "Application Support"
        return Path(self.environment.get("XDG_CONFIG_HOME") or self.home / ".config")


@dataclass(frozen=True)
class Host:
    """A host.

    ``file`` is where it lists its servers, None where it wants to be told by a command of its own; ``section`` is the key of the
    list in that file; ``fields`` every entry has, ``defaults`` a new one has; ``afterwards`` says how the host notices the entry.
    """

    title: str
    file: Callable[[Machine], Path] | None
    section: str = "mcpServers"
    syntax: Literal["json", "toml"] = "json"
    fields: Mapping[str, Any] = field(default_factory=dict)
    defaults: Mapping[str, Any] = field(default_factory=dict)
    afterwards: str = ""


def _codex_file(machine: Machine) -> Path:
    return Path(machine.environment.get("CODEX_HOME") or machine.home / ".codex") / "config.toml"


HOSTS: Mapping[HostId, Host] = {
    HostId.CLAUDE_DESKTOP: Host(
        "Claude Desktop",
        lambda machine: machine.app_data() / "Claude" / "claude_desktop_config.json",
        afterwards="Quit Claude Desktop and start it again.",
    ),
    # Its file of a user's servers, .claude.json, also holds the login and what running sessions know, and they write it
    # anew at any time: whoever else writes it may lose their changes or his own.
    HostId.CLAUDE_CODE: Host(
        "Claude Code", None, fields={"type": "stdio"}, afterwards="Start claude again; /mcp lists the server."
    ),
    HostId.VSCODE: Host(
        "VS Code",
        lambda machine: machine.app_data() / "Code" / "User" / "mcp.json",
        section="servers",
        fields={"type": "stdio"},
        afterwards='VS Code starts the server with its command "MCP: List Servers".',
    ),
    HostId.CURSOR: Host(
        "Cursor",
        lambda machine: machine.home / ".cursor" / "mcp.json",
        afterwards="Cursor shows the server in its settings, under MCP.",
    ),
    HostId.GEMINI_CLI: Host(
        "Gemini CLI",
        lambda machine: machine.home / ".gemini" / "settings.json",
        afterwards="Start gemini again; /mcp lists the server.",
    ),
    HostId.CODEX: Host(
        "Codex",
        _codex_file,
        section="mcp_servers",
        syntax="toml",
        defaults={"startup_timeout_sec": CODEX_STARTUP_SECONDS},
        afterwards="Start codex again; /mcp lists the server.",
    ),
}
"""Places and keys as the hosts' own documentation gives them, November 2026."""
