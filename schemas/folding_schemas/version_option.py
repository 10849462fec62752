"""The option ``--version`` that the commands have in common."""

from importlib.metadata import version
from typing import Any

import typer


def version_option(command: str) -> Any:  # noqa: ANN401 - typer's own type of an option
    """An option that prints a command's name with the version of the package, and ends."""

    def show(wanted: bool) -> None:
        """Print the version and end, if that is wanted."""
        if wanted:
            typer.echo(f"{command} {version('foldingagent-mcp')}")
            raise typer.Exit

    return typer.Option("--version", is_eager=True, callback=show, help="Print the version and end.")
