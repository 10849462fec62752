"""``foldingagent-server``: serve the protocol, or use a room of the server from the command line.

What a command needs is imported inside it, so that serving starts quickly.
"""

import json
import logging
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, NoReturn, Optional

import typer

from folding_server.errors import FoldingError

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")]
ProgramFile = Annotated[Path, typer.Argument(metavar="PROGRAM", help="A folding program (JSON).")]

app = typer.Typer(
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="Fold paper, see photos of it and compare the two: an MCP server. Without a command it serves over stdio.",
)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line. Mistakes end in one line on stderr and a non-zero exit."""
    try:
        code = app(args=arguments, standalone_mode=False)
    except typer.TyperException as error:
        code = _complain(error.format_message(), error.exit_code)
    except FoldingError as error:
        code = _complain(str(error), 1)
    except (KeyboardInterrupt, typer.Abort):
        code = 130
    sys.exit(code if isinstance(code, int) else 0)


def _complain(message: str, code: int) -> int:
    """One line on stderr; the exit code that goes with it."""
    sys.stderr.write(f"foldingagent-server: {' '.join(message.split())}\n")
    return code


@app.callback(invoke_without_command=True)
def serve(
    context: typer.Context,
    http: Annotated[
        Optional[str], typer.Option(metavar="HOST:PORT", help="Serve over Streamable HTTP instead of stdio.")
    ] = None,
    sequences: Annotated[
        Optional[list[Path]], typer.Option(metavar="DIR", help="A folder of photo sequences; may be repeated.")
    ] = None,
    data: Annotated[
        Optional[Path], typer.Option(metavar="DIR", help="Where runs are kept; made when missing.")
    ] = None,
    database: Annotated[
        Optional[str],
        typer.Option(metavar="URL", envvar="FOLDINGAGENT_DATABASE", help="A SQLAlchemy URL to keep runs in instead."),
    ] = None,
    known_as: Annotated[
        Optional[list[str]],
        typer.Option(metavar="NAME", help="A host name under which HTTP clients reach the server; may be repeated."),
    ] = None,
) -> None:
    """Serve the protocol over stdio, or over HTTP with --http."""
    if context.invoked_subcommand is not None:
        return
    from folding_server.tools.desk import Desk, Settings

    for folder in sequences or ():
        if not folder.is_dir():
            raise typer.BadParameter(f"there is no folder {folder} to serve sequences from")
    logging.basicConfig(level="WARNING", format="%(levelname)s %(name)s: %(message)s")
    settings = Settings(data or _data_folder(), database, tuple(sequences or ()), shared=http is not None)
    with Desk(settings) as desk:
        if http is not None:
            from folding_server.http import parse_address, serve

            serve(desk, parse_address(http), known_as or ())
        else:
            from folding_server.app import FoldingServer

            FoldingServer(desk).run("stdio")


def _data_folder() -> Path:
    """Where runs are kept if nothing else is said: the user's own data folder."""
    from platformdirs import user_data_path

    return user_data_path("foldingagent", appauthor=False)
