"""``foldingagent evaluate``."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from folding_client import options
from folding_client.exits import finish


def evaluate_command(
    runs: Annotated[
        list[Path], typer.Argument(parser=options.path, help="Run folders, or folders that hold some.")
    ],
    truth: Annotated[
        Path,
        typer.Option(
            parser=options.path, metavar="DIR", help="Sequences with their program or states, or programs."
        ),
    ],
    sequence: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Only this sequence of the truth was planned; may be repeated."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            parser=options.path,
            metavar="DIR",
            help="Write evaluation.json, summary.csv, steps.csv and curves.svg into this folder.",
        ),
    ] = None,
    quiet: options.Quiet = False,
    as_json: options.AsJson = False,
) -> None:
    """Score recorded runs against the truth with the paper's metrics."""
    from rich.console import Console

    from folding_client.evaluation.evaluating_runs import evaluation
    from folding_client.evaluation.evaluation_files import report_json, write_evaluation
    from folding_client.evaluation.evaluation_tables import evaluation_tables

    say = (lambda _line: None) if quiet else partial(typer.echo, err=True)
    report = finish(evaluation(runs, truth, sequence or (), say), "nothing was written")
    written = [] if out is None else write_evaluation(report, out)
    if as_json:
        typer.echo(report_json(report), nl=False)
        return
    console = Console()
    for table in evaluation_tables(report):
        console.print(table)
    for file in written:
        typer.echo(f"wrote {file}")
