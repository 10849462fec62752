"""Whether the creases that meet in a vertex can be folded flat there: a guard for folds along nearly coincident lines.

A fold whose line grazes an older crease within the tolerance can come out as a pleat without width that ends inside the
sheet. Faces and layers look sound then; the vertex where the pleat ends does not.
"""

from collections.abc import Collection, Sequence
from math import atan2, hypot, pi, tau

from folding_server.simulator.paper import Edge, Paper
from folding_server.simulator.plane_geometry import TOLERANCE


def unsound_vertex(paper: Paper, vertices: Collection[int]) -> int | None:
    """The first of some vertices inside the sheet that breaks Maekawa's or Kawasaki's theorem, or None.

    Alternate angles may be off half a turn by what the tolerance turns the creases by.
    """
    around: dict[int, list[Edge]] = {v: [] for v in vertices}
    for edge in paper.edge_faces:
        for v in edge:
            if v in around:
                around[v].append(edge)
    for v, edges in around.items():
        inside = all(len(paper.edge_faces[edge]) == 2 for edge in edges)
        if inside and not _folds_flat(paper, v, [edge for edge in edges if paper.is_folded(edge)]):
            return v
    return None


def _folds_flat(paper: Paper, vertex: int, creases: Sequence[Edge]) -> bool:
    """Maekawa and Kawasaki for the folded creases around a vertex."""
    if not creases:
        return True
    mountains = sum(paper.letter(edge) == "M" for edge in creases)
    if abs(2 * mountains - len(creases)) != 2:
        return False
    x, y = paper.places[vertex]
    arms = [paper.places[u if v == vertex else v] for u, v in creases]
    angles = sorted(atan2(v - y, u - x) for u, v in arms)
    gaps = [b - a for a, b in zip(angles, [*angles[1:], angles[0] + tau], strict=True)]
    shortest = min(hypot(u - x, v - y) for u, v in arms)
    return abs(sum(gaps[::2]) - pi) <= 1e-9 + 2 * TOLERANCE * len(creases) / shortest
