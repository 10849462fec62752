"""``foldingagent-server install``: enter this server into a host's configuration."""

import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from folding_server.install.hosts import HOSTS, Host, HostId, Machine
from folding_server.typed_path import require_folders, typed_path

_HostName = Annotated[HostId, typer.Option("--host", help="The program that is to use this server.")]
_DryRun = Annotated[bool, typer.Option("--dry-run", help="Print the entry and write nothing.")]
_Sequences = Annotated[
    list[Path] | None,
    typer.Option(
        metavar="DIR",
        parser=typed_path,
        help="A folder of photo sequences that it is to serve; may be repeated.",
    ),
]
_Allowed = Annotated[
    list[Path] | None,
    typer.Option(
        "--allow",
        metavar="DIR",
        parser=typed_path,
        help="A folder of films and photos that it may make sequences of; may be repeated.",
    ),
]
_Data = Annotated[
    Path | None, typer.Option(metavar="DIR", parser=typed_path, help="Where it is to keep runs.")
]
_File = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        parser=typed_path,
        help="Another configuration file than the user's own, such as a project's.",
    ),
]


def install(
    host: _HostName,
    sequences: _Sequences = None,
    allow: _Allowed = None,
    data: _Data = None,
    file: _File = None,
    dry_run: _DryRun = False,
) -> None:
    """Enter this server into the configuration of a host, which then starts it by itself."""
    from folding_server.install.entry import server_command

    require_folders(sequences or ())
    require_folders(allow or (), "allow")
    command = server_command(sequences or (), data, allow or ())
    known = HOSTS[host]
    place = file or (known.file(Machine()) if known.file else None)
    if place is None:
        _tell(known, command)
    elif dry_run:
        _show(known, command, place)
    else:
        _write(known, command, place)


def _tell(host: Host, command: Sequence[str]) -> None:
    """Print the command that makes a host write its file itself."""
    from folding_server.install.entry import ENTRY_NAME

    words = ["claude", "mcp", "add", "--scope", "user", ENTRY_NAME, "--", *command]
    typer.echo(f"{host.title} keeps its own file; run this to add the server:", err=True)
    typer.echo(subprocess.list2cmdline(words) if sys.platform == "win32" else shlex.join(words))


def _show(host: Host, command: list[str], place: Path) -> None:
    """Print the entry."""
    from folding_server.install.settings_text import snippet

    typer.echo(f"{host.title} reads this from {place}:", err=True)
    typer.echo(snippet(host, command), nl=False)


def _write(host: Host, command: list[str], place: Path) -> None:
    """Write the entry, or print it where that would break the file. FoldingError in either case of failure."""
    from folding_server.errors import FoldingError
    from folding_server.install.settings_file import read_settings, replace_settings
    from folding_server.install.settings_text import SettingsRefused, snippet, with_entry

    before = read_settings(place)
    try:
        after = with_entry(before, host, command)
    except SettingsRefused as refusal:
        typer.echo(snippet(host, command), nl=False)
        raise FoldingError(
            f"{place} is left as it was, since {refusal}; add the entry above to it yourself."
        ) from refusal
    if after == before:
        typer.echo(f"{place} has this entry already")
        return
    backup = replace_settings(place, after)
    kept = f"; what was there is in {backup}" if backup else ""
    typer.echo(f"wrote the entry to {place}{kept}")
    typer.echo(host.afterwards, err=True)
