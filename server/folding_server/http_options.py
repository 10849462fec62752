"""Options of the command that mean something over HTTP alone."""

from collections.abc import Sequence
from pathlib import Path

import typer

from folding_server.mcp.http.address import is_host_name


def check_tokens_are_meant(http: str | None, token_file: Path | None, limit: list[str] | None) -> None:
    """Raise BadParameter where options speak of tokens that nobody would send."""
    if token_file is not None and http is None:
        raise typer.BadParameter(
            "--token-file is for clients over HTTP; add --http HOST:PORT, or leave it out"
        )
    if limit and token_file is None:
        raise typer.BadParameter("--limit is for owners of tokens; add --token-file FILE, or leave it out")


def check_names(http: str | None, known_as: Sequence[str]) -> None:
    """Raise BadParameter for a host name that no request could carry, and where there are no requests."""
    if known_as and http is None:
        raise typer.BadParameter("--known-as is for clients over HTTP; add --http HOST:PORT, or leave it out")
    for name in known_as:
        if not is_host_name(name):
            raise typer.BadParameter(
                f"--known-as {name!r:.80} is no host name; give one without scheme, port and path, such as folding.example"
            )
