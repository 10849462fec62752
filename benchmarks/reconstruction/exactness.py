"""Whether a reconstructed paper is the true one: same vertices, same creases, same order of layers.

The sheet is a square, and which corner is called which is a matter of taste: the best of its four turns
counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import dist, hypot

from folding_server.geometry.line import Point, between, line_through
from folding_server.simulator import Paper, overlapping_pairs
from shapely.geometry import Polygon
from shapely.ops import polylabel
from sheet import QUARTERS, Segment, gap, turned

TOLERANCE = 0.02
"""How far off a vertex or a crease may be, in sheet units."""
SAMPLES = (0.3, 0.5, 0.7)
"""Where along a crease it is looked for in the other paper."""
THIN = 0.01
"""Overlaps less than twice this wide (sheet units) say nothing of the order: creases may be off by as much."""
LEAST_OVERLAP = 4e-4
"""Faces that overlap by less area than this may lie in any order."""
STRAIGHT = 1e-3
"""Two edges whose directions differ by a smaller sine are one line."""
KINDS = {"B": "boundary", "F": "flat"}
"""Kinds of edges by their letter; all others are folded."""


@dataclass(frozen=True)
class Exactness:
    """How well two papers agree under one turn of the sheet.

    ``farthest``  largest distance (sheet units) from a true vertex that shows to the nearest found one
    ``creases``   share of sampled points on creases of either that lie on one of the same kind in the other
    ``order``     share of overlapping pairs of true faces that lie in the same order
    """

    farthest: float
    creases: float
    order: float

    def holds(self, tolerance: float = TOLERANCE) -> bool:
        """Whether vertices, creases and order all agree."""
        return self.farthest <= tolerance and self.creases == 1.0 and self.order == 1.0


def exactness(truth: Paper, found: Paper, tolerance: float = TOLERANCE) -> Exactness:
    """The best agreement over the four turns of the sheet."""
    results = [_under(truth, found, quarters, tolerance) for quarters in QUARTERS]
    return max(results, key=lambda e: (e.creases + e.order, -e.farthest))


def same_side_up(truth: Paper, found: Paper) -> bool:
    """Whether both papers, the same but for a turn of the sheet, lie with the same side up: their largest face tells."""
    quarters = max(QUARTERS, key=lambda q: (e := _under(truth, found, q, TOLERANCE)).creases + e.order)
    face = max(truth.faces, key=lambda f: Polygon(truth.sheet_polygon(f)).area)
    middle = Polygon(truth.sheet_polygon(face)).centroid
    other = _face_at(found, turned((middle.x, middle.y), quarters))
    first, second = truth.isometries[face], found.isometries[other]
    return (first.a * first.d - first.b * first.c) * (second.a * second.d - second.b * second.c) > 0


def kind(letter: str) -> str:
    """Boundary, flat or folded."""
    return KINDS.get(letter, "folded")


def _under(truth: Paper, found: Paper, quarters: int, tolerance: float) -> Exactness:
    places = list(found.vertices_coords.values())
    farthest = max(min(dist(turned(p, quarters), q) for q in places) for p in _shown(truth))
    return Exactness(farthest, _creases(truth, found, quarters, tolerance), _order(truth, found, quarters))


def _shown(paper: Paper) -> list[Point]:
    """The places of the vertices that a photo can show: all but marks on an edge that runs straight through them."""
    beside: dict[int, list[Point]] = {v: [] for v in paper.vertices_coords}
    for u, v in paper.edge_faces:
        beside[u].append(paper.vertices_coords[v])
        beside[v].append(paper.vertices_coords[u])
    return [p for v, p in paper.vertices_coords.items() if not _straight_through(p, beside[v])]


def _straight_through(place: Point, others: Sequence[Point]) -> bool:
    """Whether two edges meet at a place in one line."""
    if len(others) != 2:
        return False
    (ax, ay), (bx, by) = ((x - place[0], y - place[1]) for x, y in others)
    return abs(ax * by - ay * bx) < STRAIGHT * hypot(ax, ay) * hypot(bx, by)


def _creases(truth: Paper, found: Paper, quarters: int, tolerance: float) -> float:
    """Share of sampled points on the creases of either that lie on one of the same kind in the other."""
    true_lines, found_lines = _lines(truth, quarters), _lines(found, 0)
    true_slivers, found_slivers = _beside_slivers(truth, tolerance), _beside_slivers(found, tolerance)
    checks = [
        any(kind_ == other and gap(point, segment) <= tolerance for segment, other in lines)
        for own, lines, slivers in (
            (true_lines, found_lines, true_slivers),
            (found_lines, true_lines, found_slivers),
        )
        for ((a, b), kind_), beside_sliver in zip(own, slivers, strict=True)
        if kind_ != "boundary" and dist(a, b) > 3 * tolerance and not beside_sliver
        for point in (between(a, b, t) for t in SAMPLES)
    ]
    return sum(checks) / len(checks) if checks else 1.0


def _lines(paper: Paper, quarters: int) -> list[tuple[Segment, str]]:
    """All edges on the turned sheet with their kinds."""
    places = {v: turned(p, quarters) for v, p in paper.vertices_coords.items()}
    return [((places[u], places[v]), kind(letter)) for (u, v), letter in paper.edges()]


def _beside_slivers(paper: Paper, tolerance: float) -> list[bool]:
    """For each edge whether it borders a face thinner than half the tolerance, whose two sides no photo tells apart."""
    thin = {face for face in paper.faces if _width(paper.sheet_polygon(face)) < tolerance / 2}
    return [any(face in thin for face in paper.edge_faces[edge]) for edge, _ in paper.edges()]


def _width(outline: Sequence[Point]) -> float:
    """The least width of a convex outline."""
    corners = zip(outline, [*outline[1:], outline[0]], strict=True)
    lines = [line_through(p, q) for p, q in corners if dist(p, q) > 1e-9]
    return min(max(abs(line.distance(p)) for p in outline) for line in lines)


def _order(truth: Paper, found: Paper, quarters: int) -> float:
    """Share of overlapping pairs of true faces whose order agrees, where their overlap is deepest."""
    checks = []
    for lower, upper in overlapping_pairs(truth):
        common = Polygon(truth.polygon(lower)).intersection(Polygon(truth.polygon(upper)))
        if not isinstance(common, Polygon) or common.area < LEAST_OVERLAP or common.buffer(-THIN).is_empty:
            continue
        spot = polylabel(common, THIN / 2)
        below, above = (
            _face_at(found, turned(truth.isometries[face].inverse()((spot.x, spot.y)), quarters))
            for face in (lower, upper)
        )
        checks.append(found.rank[below] < found.rank[above])
    return sum(checks) / len(checks) if checks else 1.0


def _face_at(paper: Paper, place: Point) -> int:
    """The face whose part of the sheet holds a place, or is nearest to it."""
    return min(paper.faces, key=lambda f: _outside(paper.sheet_polygon(f), place))


def _outside(outline: Sequence[Point], point: Point) -> float:
    """How far a point is outside a convex outline, negative inside."""
    corners = zip(outline, [*outline[1:], outline[0]], strict=True)
    return max(
        line_through(p, q).distance(point) for p, q in corners if hypot(p[0] - q[0], p[1] - q[1]) > 1e-9
    )
