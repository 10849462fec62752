"""``foldingagent-server derive``."""

import json
from pathlib import Path
from typing import Annotated, Literal

import typer

from folding_server.command_options import Json
from folding_server.typed_path import typed_path


def derive(
    states: Annotated[
        Path,
        typer.Argument(
            metavar="STATES",
            parser=typed_path,
            help="A folder with a FOLD file for each state of a sequence, or a FOLD file with a frame for each.",
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            "--out",
            "-o",
            metavar="DIR",
            parser=typed_path,
            help="The folder for states, derivation.json and program.json.",
        ),
    ],
    face_orders: Annotated[
        Literal["spec", "viewer", "reversed", "first"],
        typer.Option(
            help="What the signs of faceOrders say: as FOLD has it, or s = 1 if the first face is above as it is seen."
        ),
    ] = "spec",
    name: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of the sequence; the folder's if left out.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Derive the actions between the states of a sequence, and say where that is not possible."""
    from folding_schemas.actions import Program, action_text

    from folding_server.derivation.derived_files import derive_files
    from folding_server.interchange.fold_reading import FaceOrders

    told = derive_files(states, out, FaceOrders(face_orders), name or out.resolve().name)
    if as_json:
        typer.echo(json.dumps(told, ensure_ascii=False))
        return
    for step in told["steps"]:
        actions = None if step["actions"] is None else Program(steps=(step["actions"],)).steps[0]
        done = "not derived" if actions is None else "; ".join(map(action_text, actions)) or "nothing"
        remark = f" ({step['reason']})" if step["reason"] else ""
        typer.echo(f"{step['frame'] - 1} -> {step['frame']}  {done}{remark}")
    typer.echo(f"{told['derived']} of {len(told['steps'])} steps derived; wrote {out}")
