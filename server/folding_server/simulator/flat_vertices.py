"""The last check of a fold or unfold: every vertex it touched must still lie flat, with one pair of coordinates.

Lines that run along a crease to within the tolerance and leave it at a tiny angle would end a fold inside the sheet,
which no paper can do (Maekawa's and Kawasaki's theorems). And where fold after fold runs past one vertex within the
tolerance, each adds to what the faces around it disagree by on its folded coordinates. Such actions are refused.
"""

from collections.abc import Iterable
from math import atan2, hypot, pi

from folding_server.geometry.graph import Edge
from folding_server.geometry.line import Point
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator.paper import Paper

DRIFT = 4 * TOLERANCE
"""How far faces may disagree on the folded coordinates of a vertex, in sheet units, since a vertex of each fold through it may be off by the tolerance."""


def unflat_vertex(paper: Paper, edges: Iterable[Edge]) -> int | None:
    """A vertex inside the sheet, at an end of one of the edges, that cannot lie flat; None if there is none.

    Its mountains and valleys must differ by two and its alternate angles add up to half a turn, as far as creases whose
    ends may each be off by the tolerance can say. A vertex without folded creases lies flat.
    """
    touched = {v for edge in edges for v in edge}
    around: dict[int, list[Edge]] = {v: [] for v in touched}
    for edge in paper.edge_faces:
        for v in edge:
            if v in touched:
                around[v].append(edge)
    return next((v for v in sorted(touched) if not _lies_flat(paper, v, around[v])), None)


def torn_vertex(paper: Paper, edges: Iterable[Edge]) -> int | None:
    """A vertex at an end of one of the edges to which its faces give folded coordinates further apart than DRIFT; None if none."""
    touched = {v for edge in edges for v in edge}
    found: dict[int, list[Point]] = {v: [] for v in touched}
    for face, cycle in paper.faces.items():
        if not touched.isdisjoint(cycle):
            motion = paper.isometries[face]
            for v in touched.intersection(cycle):
                found[v].append(motion(paper.vertices_coords[v]))
    return next((v for v in sorted(touched) if _spread(found[v]) > DRIFT), None)


def _spread(points: list[Point]) -> float:
    """The diagonal of the box around points."""
    xs, ys = zip(*points, strict=True)
    return hypot(max(xs) - min(xs), max(ys) - min(ys))


def _lies_flat(paper: Paper, vertex: int, edges: list[Edge]) -> bool:
    assignments = [paper.edge_assignment(edge) for edge in edges]
    if "B" in assignments:
        return True
    folded = [edge for edge, assignment in zip(edges, assignments, strict=True) if assignment != "F"]
    if not folded:
        return True
    mountains = assignments.count("M")
    return abs(2 * mountains - len(folded)) == 2 and _balanced(paper, vertex, folded)


def _balanced(paper: Paper, vertex: int, folded: list[Edge]) -> bool:
    """Kawasaki's theorem at a vertex."""
    x, y = paper.vertices_coords[vertex]
    arms = [paper.vertices_coords[u if v == vertex else v] for u, v in folded]
    shortest = min(hypot(px - x, py - y) for px, py in arms)
    turns = sorted(atan2(py - y, px - x) for px, py in arms)
    alternate = sum(turns[i + 1] - turns[i] for i in range(0, len(turns), 2))
    return abs(alternate - pi) <= 2 * TOLERANCE * len(folded) / max(shortest, TOLERANCE)
