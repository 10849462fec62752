"""Whether the layers that a file from elsewhere orders can be: files may follow another convention for face orders."""

from collections.abc import Sequence

from folding_server.errors import ProgramError
from folding_server.geometry.graph import edge_of
from folding_server.simulator.foldability import CreasePattern
from folding_server.simulator.paper import Paper
from folding_server.simulator.validity.layers import crossing_violations
from folding_server.simulator.validity.measures import measure

ADVICE = "check faceOrders, and whether the file follows another convention for their signs"


def check_layers(paper: Paper, pattern: CreasePattern, vertex_ids: Sequence[int]) -> None:
    """ProgramError if the stack of a paper makes a mountain of a valley of its pattern, or layers cross each other.

    ``vertex_ids`` are the ids of the pattern's vertices on the paper; faces are named by their number in the file.
    """
    for (u, v), assignment in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True):
        edge = edge_of(vertex_ids[u], vertex_ids[v])
        found = paper.edge_assignment(edge) if edge in paper.edge_faces else assignment
        if {assignment, found} == {"M", "V"}:
            raise ProgramError(
                f"Edge {u}-{v} of the FOLD file has the letter {assignment}, but its face orders make it {found}; {ADVICE}."
            )
    for crossing in crossing_violations(measure(paper)):
        faces = ", ".join(str(face - 1) for face in crossing.faces)
        raise ProgramError(
            f"Layers of the FOLD file cross each other: its faces {faces} cannot lie as they are ordered ({crossing.kind}); "
            f"{ADVICE}."
        )
