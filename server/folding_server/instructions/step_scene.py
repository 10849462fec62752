"""What a drawing of a move shows, in sheet units on the table plane: the paper, lines to fold on, ways of flaps, points."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import hypot

from folding_schemas.actions import Action, Flip, Rotate

from folding_server.geometry.convex import overlap
from folding_server.geometry.graph import Edge, edge_of, sides
from folding_server.geometry.isometry import mirror
from folding_server.geometry.line import Line, Point, between
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.instructions.moves import Move, MoveKind
from folding_server.photographer.movements import Swing, swing_of
from folding_server.simulator import Paper
from folding_server.simulator.state_diff import turned_faces

Stretch = tuple[Point, Point]
"""A straight stretch of the table plane."""

INSET = 0.16
"""How far inside a flap's tip its arrow starts, in parts of the way to the middle of the tip's face."""
SEEN_BORDER = 10 * TOLERANCE
"""What lies under the paper by no more than this is seen at its edge."""
ARROWS: dict[MoveKind, str] = {
    "fold": "valley-arrow",
    "fold-behind": "mountain-arrow",
    "fold-and-unfold": "fold-and-unfold-arrow",
    "unfold": "unfold-arrow",
}


@dataclass(frozen=True)
class Way:
    """Where an arrow starts, on the flap that moves, and where that spot of the paper lands."""

    kind: str
    start: Point
    end: Point


@dataclass(frozen=True)
class StepScene:
    """A drawing: ``lines`` by their kind, ``ways`` of flaps (those after the first repeat it), ``dots`` and ``letters`` at points that are to be met or named.

    ``sign`` is the turn or the turning over of the whole; ``reach`` the corners of all that the drawing has to have room for.
    """

    paper: Paper
    lines: Mapping[str, tuple[Stretch, ...]] = field(default_factory=dict)
    ways: tuple[Way, ...] = ()
    dots: tuple[Point, ...] = ()
    letters: Mapping[str, Point] = field(default_factory=dict)
    sign: Action | None = None
    reach: tuple[Point, ...] = ()


def scene_of(move: Move, letters: Mapping[str, Point] | None = None, dots: Sequence[Point] = ()) -> StepScene:
    """The drawing of a move: the paper before it, with what is to be done. ``letters`` and ``dots`` are those of its words."""
    paper, named = move.before, dict(letters or {})
    corners = tuple(paper.folded_vertices_coords.values())
    if isinstance(move.action, (Flip, Rotate)):
        return StepScene(paper, letters=named, sign=move.action, reach=corners)
    if move.kind == "mark":
        return StepScene(
            paper,
            dots=tuple(paper.folded_vertices_coords[v] for v in move.marks),
            letters=named,
            reach=corners,
        )
    swing = swing_of(move.action, paper, move.turned)
    ways, lines = [_way(swing, ARROWS[move.kind])], _lines(move, swing)
    reach = (*corners, *move.turned.folded_vertices_coords.values())
    if move.repeat is not None:
        again = scene_of(move.repeat)
        ways += again.ways
        lines = {kind: (*stretches, *again.lines.get(kind, ())) for kind, stretches in lines.items()}
        reach = (*reach, *again.reach)
    return StepScene(paper, lines, tuple(ways), tuple(dots), named, None, reach)


def finished(paper: Paper) -> StepScene:
    """The drawing of the finished model."""
    return StepScene(paper, reach=tuple(paper.folded_vertices_coords.values()))


def turned_edges(swing: Swing) -> list[Edge]:
    """The edges about which a part turns: of their two faces one moves and one stays."""
    return [
        edge
        for edge, beside in swing.paper.edge_faces.items()
        if len(beside) == 2 and (beside[0] in swing.starts) != (beside[1] in swing.starts)
    ]


def _lines(move: Move, swing: Swing) -> dict[str, tuple[Stretch, ...]]:
    """The line of a fold; of an unfolding, as x-ray lines, the edges of its flap that the paper hides."""
    if move.kind == "unfold":
        hidden = hidden_parts(swing.before, _flap_edges(swing), lying_over(swing))
        return {"x-ray-line": tuple(hidden)} if hidden else {}
    stretches = joined_stretches(swing.line, [_ends(swing, edge) for edge in turned_edges(swing)])
    return {"mountain-line" if move.kind == "fold-behind" else "valley-line": tuple(stretches)}


def _flap_edges(swing: Swing) -> list[Stretch]:
    """The edges of the part that moves, as they lie before, without the creases that lie flat within it."""
    paper = swing.paper
    return [
        (start(paper.vertices_coords[u]), start(paper.vertices_coords[v]))
        for face, start in swing.starts.items()
        for u, v in sides(paper.faces[face])
        if paper.edge_assignment(edge_of(u, v)) != "F" or edge_of(u, v) in turned_edges(swing)
    ]


def lying_over(swing: Swing) -> list[int]:
    """The faces, of the paper before, that stay and are higher in the stack than the lowest that moves."""
    before = swing.before
    moving = turned_faces(before, swing.paper)
    lowest = min(before.rank[face] for face in moving)
    return [face for face in before.order[lowest:] if face not in moving]


def _ends(swing: Swing, edge: Edge) -> Stretch:
    """An edge about which a part turns, on the table."""
    (stays,) = (f for f in swing.paper.edge_faces[edge] if f not in swing.starts)
    motion, coords = swing.paper.isometries[stays], swing.paper.vertices_coords
    return motion(coords[edge[0]]), motion(coords[edge[1]])


def joined_stretches(line: Line, stretches: Iterable[Stretch]) -> list[Stretch]:
    """Stretches of one line, those that overlap or touch joined, from one end of it to the other."""
    along = (-line.ny, line.nx)
    spans = sorted(tuple(sorted(x * along[0] + y * along[1] for x, y in stretch)) for stretch in stretches)
    joined: list[tuple[float, float]] = []
    for first, last in spans:
        if joined and first <= joined[-1][1] + 2 * TOLERANCE:
            joined[-1] = joined[-1][0], max(last, joined[-1][1])
        else:
            joined.append((first, last))
    foot = line.nx * line.offset, line.ny * line.offset

    def point(at: float) -> Point:
        return foot[0] + at * along[0], foot[1] + at * along[1]

    return [(point(first), point(last)) for first, last in joined]


def hidden_parts(paper: Paper, stretches: Iterable[Stretch], over: Iterable[int]) -> list[Stretch]:
    """The parts of stretches that lie under faces of a paper."""
    import shapely

    cover = shapely.union_all([shapely.Polygon(paper.polygon(face)) for face in over])
    if cover.is_empty:
        return []
    lines = shapely.union_all([shapely.LineString(stretch) for stretch in stretches])
    covered = shapely.get_parts(shapely.intersection(lines, shapely.buffer(cover, -SEEN_BORDER)))
    return [
        (piece.coords[0], piece.coords[-1])
        for piece in covered
        if piece.geom_type == "LineString" and piece.length > SEEN_BORDER
    ]


def _way(swing: Swing, kind: str) -> Way:
    """The way of the tip of the flap: what moves furthest, of the faces that are seen first there."""
    tip, face = flap_tip(swing)
    outline = [swing.starts[face](swing.paper.vertices_coords[v]) for v in swing.paper.faces[face]]
    middle = sum(x for x, _ in outline) / len(outline), sum(y for _, y in outline) / len(outline)
    start = between(tip, middle, INSET)
    return Way(kind, start, mirror(swing.line)(start))


def flap_tip(swing: Swing) -> tuple[Point, int]:
    """The corner of the moving part that goes furthest, where it lies before, and the highest face that has it there.

    Of corners that go as far the highest in the stack, then the one nearest to the middle of them, is taken.
    """
    height = {
        face: i for i, face in enumerate(reversed(swing.paper.order) if swing.over else swing.paper.order)
    }
    corners = [
        (swing.starts[face](swing.paper.vertices_coords[v]), face)
        for face in swing.starts
        for v in swing.paper.faces[face]
    ]
    far = max(swing.line.distance(point) for point, _ in corners)
    far_ones = [each for each in corners if swing.line.distance(each[0]) > far - 5 * TOLERANCE]
    highest = max(height[face] for _, face in far_ones)
    best = [each for each in far_ones if height[each[1]] == highest]
    middle = sum(p[0] for p, _ in best) / len(best), sum(p[1] for p, _ in best) / len(best)
    return min(
        best, key=lambda each: (round(hypot(each[0][0] - middle[0], each[0][1] - middle[1]), 6), each[0])
    )


def layers_turned(swing: Swing) -> int:
    """Through how many layers the line goes where it goes through most: how many are folded at once."""
    spans = [
        tuple(sorted(-swing.line.ny * x + swing.line.nx * y for x, y in _ends(swing, edge)))
        for edge in turned_edges(swing)
    ]
    return max((sum(a < (first + last) / 2 < b for a, b in spans) for first, last in spans), default=0)


def layers_at(paper: Paper, point: Point) -> int:
    """How many faces of a paper lie at a point."""
    speck = 3 * TOLERANCE
    box = [
        (point[0] + x, point[1] + y)
        for x, y in ((-speck, -speck), (speck, -speck), (speck, speck), (-speck, speck))
    ]
    return sum(overlap(paper.polygon(face), box) for face in paper.faces)
