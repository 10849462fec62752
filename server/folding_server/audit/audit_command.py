"""``foldingagent-server audit``."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from folding_server.command_options import Json
from folding_server.typed_path import typed_path


def audit(
    mesh: Annotated[
        Path, typer.Argument(metavar="MESH", parser=typed_path, help="A mesh as OBJ, PLY, GLB or FOLD.")
    ],
    as_json: Json = False,
) -> None:
    """Say whether a mesh is one folded square sheet; exit 1 if it is not."""
    from folding_server.audit.mesh_audit import audit_mesh
    from folding_server.audit.mesh_reading import read_mesh

    found = audit_mesh(read_mesh(mesh))
    if as_json:
        typer.echo(json.dumps({"mesh": str(mesh), "passes": found.passes, **asdict(found)}))
    else:
        crossings = (
            "order of the layers not told" if found.crossings is None else f"{found.crossings} crossings"
        )
        kawasaki = "" if found.kawasaki is None else f", {found.kawasaki} vertices that cannot lie flat"
        typer.echo(
            f"{found.components} pieces, {found.faces} faces, {found.panels} panels, {found.layers} layers, {found.shape}: "
            f"stretch {found.stretch:.2%}, faces apart {found.apart:.2%}{kawasaki}, {crossings}."
        )
        for problem in found.problems:
            typer.echo(problem)
        typer.echo("It is one folded square sheet." if found.passes else "It is not one folded square sheet.")
    if not found.passes:
        raise typer.Exit(1)
