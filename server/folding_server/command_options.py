"""The options of the command ``foldingagent-server``, each described once."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from folding_schemas.attempt_limits import MOST_ATTEMPTS
from folding_schemas.version_option import version_option

from folding_server.typed_path import typed_path

Http = Annotated[
    str | None, typer.Option(metavar="HOST:PORT", help="Serve over Streamable HTTP instead of stdio.")
]
Sequences = Annotated[
    list[Path] | None,
    typer.Option(metavar="DIR", parser=typed_path, help="A folder of photo sequences; may be repeated."),
]
Allowed = Annotated[
    list[Path] | None,
    typer.Option(
        "--allow",
        metavar="DIR",
        parser=typed_path,
        help="A folder of films and photos that hosts may name by path, to make sequences of them; may be repeated.",
    ),
]
Data = Annotated[
    Path | None,
    typer.Option(metavar="DIR", parser=typed_path, help="Where runs are kept; made when missing."),
]
Database = Annotated[
    str | None,
    typer.Option(
        metavar="URL", envvar="FOLDINGAGENT_DATABASE", help="A SQLAlchemy URL to keep runs in instead."
    ),
]
KnownAs = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME", help="A host name that HTTP clients may use; may be repeated."),
]
TokenFile = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        parser=typed_path,
        help="Answer HTTP clients only with a bearer token of this file, which has lines OWNER TOKEN.",
    ),
]
ToolsOffered = Annotated[
    Literal["paper", "standard", "all"],
    typer.Option(
        "--tools", help="The tools to offer: the paper's own, those with undo and measuring, or all."
    ),
]
Attempts = Annotated[
    int,
    typer.Option(
        min=1,
        max=MOST_ATTEMPTS,
        metavar="N",
        help="How many attempts each frame has, in runs opened without a number of their own.",
    ),
]
ReadOnly = Annotated[bool, typer.Option("--read-only", help="Offer only tools that change nothing.")]
ForEvaluation = Annotated[
    bool, typer.Option("--for-evaluation", help="Offer also the tool that measures states to score them.")
]

Limit = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME=N",
        help="The most that each owner of tokens may have: runs, megabytes, vision-seconds a day, vision-at-once "
        "and vision-waiting calls; may be repeated.",
    ),
]
VisionWorkers = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        min=0,
        max=64,
        show_default=False,
        help="Processes that compute long calls, of up to 400 MB each; 0 computes in the server itself. Left out, one for each "
        "core, at most 2.",
    ),
]
VisionQueue = Annotated[
    int, typer.Option(metavar="N", min=0, max=10_000, help="Long calls that may wait for a worker.")
]

ShowVersion = Annotated[bool, version_option("foldingagent-server")]
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON document on stdout and nothing else there.")
]
ProgramFile = Annotated[
    Path, typer.Argument(metavar="PROGRAM", parser=typed_path, help="A folding program (JSON).")
]
ModelSource = Annotated[
    str,
    typer.Argument(
        metavar="PROGRAM|RUN", help="A program (JSON), the folder of a run, or the id of a stored run."
    ),
]
EveryStep = Annotated[
    Path | None,
    typer.Option(metavar="DIR", parser=typed_path, help="Write state, SVG and PNG of every step."),
]
StepFiles = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        parser=typed_path,
        help="Write FOLD, .cp, OBJ and new creases of every step, and all states as one FOLD file.",
    ),
]
OutFolder = Annotated[
    Path, typer.Option("--out", "-o", metavar="DIR", parser=typed_path, help="The sequence folder to write.")
]


def file_to_write(what: str) -> Any:  # noqa: ANN401 - typer's own type of an option
    """An option that names a file to write."""
    return typer.Option(metavar="FILE", parser=typed_path, help=f"Write {what}.")
