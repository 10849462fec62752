"""From a predicted fold to the actions that make it: which vertices to name, which to add."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, combinations
from math import dist

from folding_schemas.actions import Actions, AddVertex, Direction, Fold

from folding_server.errors import ActionRefused
from folding_server.geometry.graph import Edge
from folding_server.geometry.line import Line, Point, between, line_through
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator import apply
from folding_server.simulator.paper import Paper
from folding_server.simulator.state_diff import turned_faces
from folding_server.vision.solver.movable_layers import NEAR_LINE, MovableLayers, MovingSet

NICE_FRACTIONS = tuple(sorted({k / 20 for k in range(1, 20)} | {k / 8 for k in range(1, 8)} | {1 / 3, 2 / 3}))
NICE_REACH, NICE_SHARE = 0.0015, 0.005
"""A crossing this near a simple fraction of its edge is taken to be there (in sheet units, and as a share of the edge: on a
short one all crossings are near some).
"""
MOST_WAYS, MOST_TRIES = 3, 16
"""Ways to make a fold of actions that are given, and that are tried."""
MISSED = 0.003
"""Vertices beside the line by more, together, are taken only if nothing lies nearer (in sheet units)."""
AT_VERTEX = 0.008
"""A crossing this near a vertex is taken to be at it (in sheet units)."""
SHORTEST_SPAN, SPAN_PER_MISS = 0.01, 5.0
"""Points nearer to each other than the first (sheet units), or than so many times what a vertex misses the line by, say too
little of its direction.
"""


def realise(paper: Paper, moving: MovingSet, *, exact: bool) -> list[tuple[Actions, Paper]]:
    """Actions that fold the layers of ``moving`` along its line, each with the paper they make.

    One way if it turns just those layers; otherwise every way found that turns others, for the photo to decide.
    ``exact`` keeps the line to six digits, as one that was constructed deserves.
    """
    others: list[tuple[Actions, Paper]] = []
    for actions in chain(_ways(paper, moving, exact=exact), _ways_clear(paper, moving)):
        try:
            folded = _applied(paper, actions)
        except ActionRefused:
            continue
        if _matches(paper, folded, moving):
            return [(actions, folded)]
        others.append((actions, folded))
    return others[:MOST_WAYS]


def _ways_clear(paper: Paper, moving: MovingSet) -> Iterator[Actions]:
    """Folds along the line shifted until nothing that stays is tied to what moves.

    A line found from a photo may run a hair's breadth beside where a layer above begins, which would be taken along.
    """
    line = moving.line
    over = MovableLayers(paper).overreach(moving)
    if over > 0:
        clear = Line(line.nx, line.ny, line.offset + over + TOLERANCE / 4)
        yield from _ways(paper, replace(moving, line=clear), exact=True)


def _matches(paper: Paper, folded: Paper, moving: MovingSet) -> bool:
    """Whether the layers that turned are those meant, but for slivers beside the line."""
    return all(
        max(moving.line.distance(p) for p in paper.polygon(face)) <= 2 * NEAR_LINE
        for face in turned_faces(paper, folded) ^ moving.faces
    )


def _applied(paper: Paper, actions: Actions) -> Paper:
    for action in actions:
        paper = apply(paper, action)
    return paper


@dataclass(frozen=True)
class Meeting:
    """Where the line meets an edge: an existing vertex, or one to add; ``along`` is its coordinate on the line.

    ``miss`` is how far beside the line the vertex is, in sheet units.
    """

    vertex: int | None
    added: AddVertex | None
    along: float
    miss: float = 0.0


def _ways(paper: Paper, moving: MovingSet, *, exact: bool) -> Iterator[Actions]:
    """Folds through two points of the line: first those truly on it, then those with the fewest new vertices, then the
    farthest apart.
    """
    met = [
        m for face in _starting_faces(paper, moving) for m in _meetings(paper, face, moving.line, exact=exact)
    ]
    pairs = [
        (a, b)
        for a, b in combinations(_once(met), 2)
        if abs(a.along - b.along) > max(SHORTEST_SPAN, SPAN_PER_MISS * max(a.miss, b.miss))
    ]
    pairs.sort(
        key=lambda ab: (
            ab[0].miss + ab[1].miss > MISSED,
            (ab[0].added is not None) + (ab[1].added is not None),
            -abs(ab[0].along - ab[1].along),
        )
    )
    for first, second in pairs[:MOST_TRIES]:
        yield _fold_through(paper, first, second, moving.line)


def _once(met: list[Meeting]) -> list[Meeting]:
    """Meetings without repeats: a vertex or an edge is named once."""
    named: dict[object, Meeting] = {}
    for m in met:
        named.setdefault(m.vertex if m.added is None else frozenset(m.added.edge), m)
    return list(named.values())


def _fold_through(paper: Paper, first: Meeting, second: Meeting, line: Line) -> Actions:
    """The actions that add what vertices are missing and fold."""
    added = [m.added for m in (first, second) if m.added is not None]
    fresh = iter(range(max(paper.vertices_coords) + 1, max(paper.vertices_coords) + 3))
    u, v = (next(fresh) if m.vertex is None else m.vertex for m in (first, second))
    return (*added, Fold(edge=(u, v), direction=_direction(paper, added, (u, v), line)))


def _starting_faces(paper: Paper, moving: MovingSet) -> list[int]:
    """The seed, then the other moving faces, topmost first."""
    return [moving.seed, *(f for f in reversed(paper.order) if f in moving.faces and f != moving.seed)]


def _meetings(paper: Paper, face: int, line: Line, *, exact: bool) -> Iterator[Meeting]:
    """Where a line meets a face's boundary: vertices on it or nearly so, else points to add."""
    cycle = paper.faces[face]
    near = {v for v in cycle if abs(line.distance(paper.folded_vertices_coords[v])) <= AT_VERTEX}
    for u, v in zip(cycle, cycle[1:] + cycle[:1], strict=True):
        p, q = paper.folded_vertices_coords[u], paper.folded_vertices_coords[v]
        if u in near:
            yield Meeting(u, None, line.ny * p[0] - line.nx * p[1], abs(line.distance(p)))
        before, after = line.distance(p), line.distance(q)
        if before * after < 0 and not _ends_near(near, (u, v), p, q, before / (before - after)):
            x, y = between(p, q, before / (before - after))
            fraction = nice_fraction(before / (before - after), dist(p, q), exact=exact)
            yield Meeting(None, AddVertex(edge=(u, v), position=fraction), line.ny * x - line.nx * y)


def _ends_near(near: set[int], edge: Edge, p: Point, q: Point, fraction: float) -> bool:
    """Whether a crossing is within reach of an end of its edge that already counts as on the line."""
    length = dist(p, q)
    gaps = (fraction * length, (1 - fraction) * length)
    return any(v in near and gap < 5 * AT_VERTEX for v, gap in zip(edge, gaps, strict=True))


def nice_fraction(fraction: float, length: float, *, exact: bool) -> float:
    """A fraction of an edge of that length in few digits: six if the line was constructed, else a simple one or three."""
    nearest = min(NICE_FRACTIONS, key=lambda nice: abs(nice - fraction))
    reach = 1e-6 if exact else min(NICE_REACH, NICE_SHARE * length)
    if abs(nearest - fraction) * length <= reach:
        return nearest
    margin = min(0.4, 2 * TOLERANCE / max(length, TOLERANCE))
    return min(max(round(fraction, 6 if exact else 3), margin), 1 - margin)


def _direction(paper: Paper, added: list[AddVertex], ends: Edge, line: Line) -> Direction:
    """The direction that moves the side a line's normal points to, as ``fold`` reads it off its two vertices."""
    for action in added:
        paper = apply(paper, action)
    p, q = paper.folded_vertices_coords[ends[0]], paper.folded_vertices_coords[ends[1]]
    named = line_through(p, q)
    same_side = named.nx * line.nx + named.ny * line.ny > 0
    vertical = abs(q[0] - p[0]) <= TOLERANCE * abs(q[1] - p[1])
    upwards = named.nx > 0 if vertical else named.ny > 0
    return 1 if same_side == upwards else -1
