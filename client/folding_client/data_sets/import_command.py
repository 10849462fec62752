"""``foldingagent import-purelandfold``."""

import json
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from folding_client import options
from folding_client.exits import finish

EXIT_PARTLY = 1
"""A sequence has no truth."""


def import_purelandfold_command(
    file: Annotated[
        Path, typer.Argument(parser=options.path, metavar="FILE.parquet", help="A file of the data set.")
    ],
    out: Annotated[
        Path, typer.Option("--out", "-o", parser=options.path, metavar="DIR", help="Where the sequences go.")
    ],
    face_orders: Annotated[
        Literal["viewer", "spec"],
        typer.Option(
            help="What the signs of faceOrders say: s = 1 if the first face is above as it is seen, or as FOLD has it."
        ),
    ] = "viewer",
    as_json: options.AsJson = False,
) -> None:
    """Write the sequences of PurelandFold as folders with truth, and derive the actions between their states."""
    from folding_client.data_sets.importing import import_sequences
    from folding_client.data_sets.purelandfold import purelandfold_sequences

    sequences = purelandfold_sequences(file)
    say = partial(typer.echo, err=True)
    work = import_sequences(sequences, out, face_orders, say)
    found = finish(work, f"what was written is in {out}")
    if as_json:
        typer.echo(json.dumps([asdict(each) for each in found], indent=1))
    else:
        steps, derived = sum(each.frames - 1 for each in found), sum(each.derived for each in found)
        whole = sum(each.program for each in found)
        typer.echo(
            f"{len(found)} sequences, {derived} of {steps} steps derived, {whole} whole programs: {out}"
        )
    if any(each.problem for each in found):
        raise typer.Exit(EXIT_PARTLY)
