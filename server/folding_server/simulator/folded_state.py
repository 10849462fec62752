"""The folded state as models see it: rounded, with string keys, layers derived from the stack."""

from typing import Literal, cast

from folding_schemas.state import EdgeKind, FoldedState

from folding_server.simulator.paper import Paper
from folding_server.simulator.plane_layers import layers_of_planes


def folded_state(paper: Paper) -> FoldedState:
    """S = (V, F, E, O, L) with folded coordinates in sheet units to 6 decimals (paper, "Origami State Representation")."""
    coords = paper.folded_vertices_coords
    return FoldedState(
        vertices={str(v): (_rounded(coords[v][0]), _rounded(coords[v][1])) for v in sorted(coords)},
        faces={str(f): list(paper.faces[f]) for f in sorted(paper.faces)},
        faces_orientations={
            str(f): cast("Literal[0, 1]", int(paper.back_up(f))) for f in sorted(paper.faces)
        },
        edges=[(u, v, cast("EdgeKind", assignment)) for (u, v), assignment in paper.edges()],
        layers=layers_of_planes(paper),
    )


def _rounded(value: float) -> float:
    """Six decimals, and no negative zero."""
    return round(value, 6) + 0.0
