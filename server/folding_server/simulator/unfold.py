"""The action ``unfold``: undo one fold, leaving a flat crease where it was.

The side that moved when the crease was folded swings back over the top or under the bottom; if it cannot, the other
side may, which is the same model seen from another place.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import dist

from folding_server.errors import ActionRefused
from folding_server.geometry.convex import bounding_box, boxes_meet, overlap
from folding_server.geometry.graph import Edge, edge_of, sides
from folding_server.geometry.isometry import Isometry, mirror_line
from folding_server.geometry.line import Line
from folding_server.simulator.flat_vertices import DRIFT, torn_vertex, unflat_vertex
from folding_server.simulator.paper import FoldedCrease, Paper
from folding_server.simulator.vertices import known_vertices


@dataclass(frozen=True)
class Hinge:
    """One fold to undo: its number, its edges, the line it turns about and the mirror that turns it."""

    fold: int
    edges: frozenset[Edge]
    reflection: Isometry
    line: Line


def unfold(paper: Paper, edge: Edge | None = None) -> Paper:
    """Undo the fold of a crease, or the newest fold that is still folded.

    Raises ActionRefused if nothing is folded, the edge is not a folded crease, a later fold has bent the crease, both
    sides are joined around it, or neither side can swing; the message names the fold or face in the way.
    """
    number = newest_fold(paper) if edge is None else fold_of(paper, edge)
    hinge = _hinge(paper, number)
    moved = _joined(paper, {paper.creases[e].moved for e in hinge.edges}, hinge.edges)
    for e in hinge.edges:
        if all(face in moved for face in paper.edge_faces[e]):
            raise ActionRefused(
                f"{_name(paper, number)} cannot be undone: its two sides are joined around the crease at edge "
                f"[{e[0]}, {e[1]}]; unfold a newer fold first."
            )
    reasons = []
    for swinging in (moved, frozenset(paper.faces) - moved):
        way = _way(paper, swinging, hinge)
        if isinstance(way, bool):
            return _checked(_swung(paper, swinging, hinge, over=way), hinge, _name(paper, number))
        reasons.append(way)
    raise ActionRefused(
        f"{_name(paper, number)} cannot be undone: {reasons[0]} and, for the other side, {reasons[1]}; "
        "unfold what is in the way first."
    )


def _checked(paper: Paper, hinge: Hinge, name: str) -> Paper:
    """The unfolded paper; ActionRefused if a vertex of the crease would not lie flat, or its faces would disagree on its coordinates."""
    blunt = unflat_vertex(paper, hinge.edges)
    if blunt is not None:
        raise ActionRefused(
            f"{name} cannot be undone: a newer crease ends at vertex {blunt} of it, where the paper would not lie flat; "
            "unfold the newer fold first."
        )
    torn = torn_vertex(paper, hinge.edges)
    if torn is not None:
        raise ActionRefused(
            f"{name} cannot be undone: it would put the layers that meet at vertex {torn} more than {DRIFT:g} apart, since "
            "later folds just missed that vertex; unfold a newer fold first."
        )
    return paper


def newest_fold(paper: Paper) -> int:
    """The number of the newest fold with a crease that is still folded; ActionRefused if the sheet is flat."""
    numbers = [record.fold for edge, record in paper.creases.items() if paper.is_folded(edge)]
    if not numbers:
        raise ActionRefused("Nothing is folded, so there is nothing to unfold; fold first.")
    return max(numbers)


def fold_of(paper: Paper, edge: Edge) -> int:
    """The fold that holds a crease: an edge of it, or two vertices at the ends of a straight run of its edges.

    Raises ActionRefused if neither is folded.
    """
    known_vertices(paper, edge)
    u, v = edge
    key = edge_of(u, v)
    if key in paper.creases and paper.is_folded(key):
        return paper.creases[key].fold
    folded = {record.fold for e, record in paper.creases.items() if paper.is_folded(e)}
    for number in sorted(folded, reverse=True):
        ends = {w for e, r in paper.creases.items() if r.fold == number for w in e}
        if {u, v} <= ends or edge_of(*paper.fold_edges[number]) == key:
            return number
    creases = ", ".join(f"[{a}, {b}]" for (a, b), assignment in paper.edges() if assignment in "MV")
    raise ActionRefused(f"[{u}, {v}] is not a folded crease; the folded creases are {creases or 'none'}.")


def _name(paper: Paper, number: int) -> str:
    u, v = paper.fold_edges[number]
    return f"Fold {number} (through [{u}, {v}])"


def _hinge(paper: Paper, number: int) -> Hinge:
    """The line that all creases of a fold lie on now; ActionRefused if a later fold has bent them."""
    edges = frozenset(e for e, record in paper.creases.items() if record.fold == number)
    folded = sorted(e for e in edges if paper.is_folded(e))
    longest = max(folded, key=lambda e: _length(paper, e))
    reflection = _reflection(paper, longest)
    for e in edges:
        ends = [motion(paper.vertices_coords[v]) for v in e for motion in _motions(paper, e)]
        if any(dist(reflection(p), p) > 2 * DRIFT for p in ends):
            raise ActionRefused(
                f"{_name(paper, number)} cannot be undone: {_bender(paper, number)} has bent its crease at edge "
                f"[{e[0]}, {e[1]}]; unfold that first."
            )
    return Hinge(number, edges, reflection, mirror_line(reflection))


def _length(paper: Paper, edge: Edge) -> float:
    return dist(paper.vertices_coords[edge[0]], paper.vertices_coords[edge[1]])


def _motions(paper: Paper, edge: Edge) -> list[Isometry]:
    return [paper.isometries[face] for face in paper.edge_faces[edge]]


def _reflection(paper: Paper, edge: Edge) -> Isometry:
    """The mirror that lays the side of a folded edge that moved flat beside the other."""
    moved = paper.creases[edge].moved
    (stays,) = (face for face in paper.edge_faces[edge] if face != moved)
    return paper.isometries[stays].after(paper.isometries[moved].inverse())


def _bender(paper: Paper, number: int) -> str:
    """The name of the oldest later fold that shares a vertex with a fold's creases, else of the newest fold."""
    corners = {v for e, record in paper.creases.items() if record.fold == number for v in e}
    later = {
        record.fold
        for e, record in paper.creases.items()
        if record.fold > number and corners & set(e) and paper.is_folded(e)
    }
    return _name(paper, min(later) if later else newest_fold(paper)).replace("Fold", "fold", 1)


def _joined(paper: Paper, start: Iterable[int], cut: frozenset[Edge]) -> frozenset[int]:
    """All faces joined to some other than through the cut edges."""
    seen, waiting = set(start), list(start)
    while waiting:
        cycle = paper.faces[waiting.pop()]
        for u, v in sides(cycle):
            e = edge_of(u, v)
            if e not in cut:
                fresh = [f for f in paper.edge_faces[e] if f not in seen]
                seen.update(fresh)
                waiting.extend(fresh)
    return frozenset(seen)


def _way(paper: Paper, swinging: frozenset[int], hinge: Hinge) -> bool | str:
    """True if a side can swing over the top, False if under the bottom, else what is in the way."""
    low, high = 0.0, 0.0
    for face in swinging:
        for p in paper.polygon(face):
            d = hinge.line.distance(p)
            low, high = min(low, d), max(high, d)
    if min(-low, high) > DRIFT:
        return "it reaches over the hinge"
    over, under = _in_the_way(paper, swinging)
    if over is None:
        return True
    if under is None:
        return False
    return f"face {over} lies over it and face {under} under it"


def _in_the_way(paper: Paper, swinging: frozenset[int]) -> tuple[int | None, int | None]:
    """A static face that lies over the swinging side, and one that lies under it; None where there is none."""
    over = under = None
    outlines = {f: paper.polygon(f) for f in paper.order}
    boxes = {f: bounding_box(o) for f, o in outlines.items()}
    for m in swinging:
        for s in paper.order:
            if s in swinging or not boxes_meet(boxes[m], boxes[s]):
                continue
            above = paper.rank[s] > paper.rank[m]
            if (over if above else under) is None and overlap(outlines[m], outlines[s]):
                over, under = (s, under) if above else (over, s)
        if over is not None and under is not None:
            break
    return over, under


def _swung(paper: Paper, swinging: frozenset[int], hinge: Hinge, *, over: bool) -> Paper:
    """The paper with one side mirrored about the hinge and its stack reversed, on top or at the bottom."""
    stays = [f for f in paper.order if f not in swinging]
    turned = [f for f in reversed(paper.order) if f in swinging]
    creases: dict[Edge, FoldedCrease] = dict(paper.creases)
    for e in hinge.edges:
        below = creases.pop(e).below
        if below is not None:
            creases[e] = below
    motions = {f: hinge.reflection.after(t) if f in swinging else t for f, t in paper.isometries.items()}
    order = (*stays, *turned) if over else (*turned, *stays)
    return replace(paper, isometries=motions, order=order, creases=creases)
