"""Folds and unfolds that bring a paper nearer to a given state, read off the creases that the state has and the paper lacks."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import hypot, sqrt

from folding_schemas.actions import Actions, AddVertex, Direction, Fold, Unfold

from folding_server.derivation.given_states import NEAR, ROUNDING, GivenState
from folding_server.derivation.pose_matching import origins_of, spare_vertices
from folding_server.errors import ActionRefused
from folding_server.geometry.graph import Edge, edge_faces, sides
from folding_server.geometry.line import Line, Point, between, line_through
from folding_server.simulator import Paper, apply

FRACTION_DENOMINATORS = (2, 3, 4, 5, 6, 8, 10, 16, 20, 50, 100)
"""Of the fractions that a place on an edge is taken for where one is near enough."""
FOLDED_FRACTIONS = tuple(
    sorted(
        value
        for root in (sqrt(2) - 1, 1 - sqrt(0.5), sqrt(1 / 3), sqrt(3) - 1, (sqrt(5) - 1) / 2)
        for value in (root, 1 - root)
    )
)
"""Other places that folding gives: by halves and thirds of a right angle, and the golden section."""
ANCHORS_APART = 0.2
"""Sheet units between two vertices from which on they give a line better than a crease's own rounded ends do."""
Prepared = tuple[Actions, Paper, Edge]
"""Vertices added, the paper that has them, and the two through which it is folded."""
DIRECTIONS: tuple[Direction, ...] = (1, -1)


@dataclass(frozen=True)
class CreaseOnPaper:
    """A crease of the given state as it lies on the paper: a face of the paper, and the line on the sheet."""

    face: int
    ends: tuple[Point, Point]


def missing_creases(paper: Paper, given: GivenState, origins: Sequence[int]) -> list[CreaseOnPaper]:
    """The longest crease on each line of each face of the paper along which the state has one and the paper none, and the
    marks of the paper that are folded in the state.
    """
    found: list[CreaseOnPaper] = []
    for (u, v), beside in edge_faces(dict(enumerate(given.pattern.cycles))).items():
        if len(beside) < 2:
            continue
        ends = given.pattern.vertices_coords[u], given.pattern.vertices_coords[v]
        first, second = origins[beside[0]], origins[beside[1]]
        folds = given.motions[beside[0]].mirrors != given.motions[beside[1]].mirrors
        turned = paper.back_up(first) != paper.back_up(second)
        if first == second or folds != turned:
            found.append(CreaseOnPaper(first, ends))
    found.sort(key=lambda crease: -_length(crease.ends))
    kept: list[CreaseOnPaper] = []
    for crease in found:
        if not any(crease.face == other.face and _on_one_line(crease, other) for other in kept):
            kept.append(crease)
    return kept


def fold_candidates(
    paper: Paper, given: GivenState, origins: Sequence[int]
) -> Iterator[tuple[Actions, Paper]]:
    """Actions that end in a fold along a crease that the paper lacks, and the paper after them, all of whose creases the state
    has.

    Of the ways to make a crease, the first counts that makes no vertex which the state has not; if all do, each counts.
    """
    tried: set[Actions] = set()
    for crease in missing_creases(paper, given, origins):
        lines = [*_anchored(paper, crease), *_at_ends(paper, crease)]
        for direction in DIRECTIONS:
            loose: list[tuple[Actions, Paper]] = []
            for actions, folded in _folded(lines, direction, tried):
                if origins_of(given, folded) is None:
                    continue
                loose.append((actions, folded))
                if not spare_vertices(given, folded):
                    loose = loose[-1:]
                    break
            yield from loose


def _folded(
    lines: Sequence[Prepared], direction: Direction, tried: set[Actions]
) -> Iterator[tuple[Actions, Paper]]:
    """The paper folded along each line that was not tried before, where that is possible."""
    for made, prepared, edge in lines:
        fold = Fold(edge=edge, direction=direction)
        actions = (*made, fold)
        if actions not in tried:
            tried.add(actions)
            with suppress(
                ActionRefused, ValueError
            ):  # in papers of rounded states, slivers may have no outline left
                yield actions, apply(prepared, fold)


def _at_ends(paper: Paper, crease: CreaseOnPaper) -> Iterator[Prepared]:
    """The ends of a crease as vertices: where they are likely to be meant, and where the rounded state has them."""
    for snaps in (True, False):
        ends = _ends_on(paper, crease, snaps=snaps)
        if ends is not None:
            yield ends


def _anchored(paper: Paper, crease: CreaseOnPaper) -> Iterator[Prepared]:
    """Vertices of any layer through which the line of a crease goes, as nearly as rounding tells: the two farthest apart.

    A fold through them is exact, where one through rounded ends would pass just beside them.
    """
    motion, places = paper.isometries[crease.face], paper.folded_vertices_coords
    line = line_through(motion(crease.ends[0]), motion(crease.ends[1]))
    on_line = [v for v, place in places.items() if abs(line.distance(place)) <= NEAR]
    pairs = [(u, v) for i, u in enumerate(on_line) for v in on_line[i + 1 :]]
    if pairs:
        edge = max(pairs, key=lambda pair: _length((places[pair[0]], places[pair[1]])))
        if _length((places[edge[0]], places[edge[1]])) > ANCHORS_APART:
            yield (), paper, edge


def unfold_candidates(
    paper: Paper, given: GivenState, origins: Sequence[int]
) -> Iterator[tuple[Actions, Paper]]:
    """Undoing each fold that holds a crease which is flat in the given state, and the paper after it."""
    flat = _flattened(paper, given, origins)
    for number in sorted({paper.creases[edge].fold for edge in flat}, reverse=True):
        edge = next(edge for edge in flat if paper.creases[edge].fold == number)
        newest = number == max(record.fold for e, record in paper.creases.items() if paper.is_folded(e))
        unfold = Unfold() if newest else Unfold(edge=edge)
        try:
            yield (unfold,), apply(paper, unfold)
        except ActionRefused:
            continue


def _flattened(paper: Paper, given: GivenState, origins: Sequence[int]) -> list[Edge]:
    """The folded creases of the paper whose two faces show the same side in the given state."""
    mirrored = {face: given.motions[index].mirrors for index, face in enumerate(origins)}
    return [
        edge
        for edge, beside in sorted(paper.edge_faces.items())
        if paper.is_folded(edge)
        and edge in paper.creases
        and all(face in mirrored for face in beside)
        and mirrored[beside[0]] == mirrored[beside[1]]
    ]


def _ends_on(paper: Paper, crease: CreaseOnPaper, *, snaps: bool) -> Prepared | None:
    """Vertices where the line of a crease leaves its face, made where there are none; with the paper that has them."""
    actions: Actions = ()
    vertices: list[int] = []
    for point in _crossings(paper, crease.face, line_through(*crease.ends), crease.ends):
        ready = _with_vertex(paper, crease.face, point, snaps=snaps)
        if ready is None:
            return None
        made, paper, vertex = ready
        actions = (*actions, *made)
        vertices.append(vertex)
    if len(set(vertices)) != 2:
        return None
    return actions, paper, (vertices[0], vertices[1])


def _with_vertex(paper: Paper, face: int, point: Point, *, snaps: bool) -> tuple[Actions, Paper, int] | None:
    """The vertex of a face at a point of its outline, made if there is none; None if it cannot be made."""
    vertex = _vertex_at(paper, face, point)
    if vertex is not None:
        return (), paper, vertex
    added = _vertex_to_add(paper, face, point, snaps=snaps)
    try:
        paper = apply(paper, added)
    except ActionRefused:
        return None
    return (added,), paper, max(paper.vertices_coords)


def _crossings(paper: Paper, face: int, line: Line, ends: tuple[Point, Point]) -> list[Point]:
    """Where a line on the sheet meets the outline of a face: at an end of the crease if that lies there, else computed."""
    outline = paper.sheet_polygon(face)
    found: list[Point] = []
    for p, q in zip(outline, (*outline[1:], outline[0]), strict=True):
        a, b = line.distance(p), line.distance(q)
        if abs(a) <= NEAR and abs(b) <= NEAR:
            points = [p, q]
        elif min(a, b) <= NEAR and max(a, b) >= -NEAR and a != b:
            points = [between(p, q, min(max(a / (a - b), 0.0), 1.0))]
        else:
            points = []
        for point in points:
            seen = next((end for end in ends if _length((end, point)) <= 2 * NEAR), point)
            if all(_length((seen, other)) > 2 * NEAR for other in found):
                found.append(seen)
    return [*_farthest(found)] if len(found) > 2 else found


def _farthest(points: Sequence[Point]) -> tuple[Point, Point]:
    pairs = ((p, q) for i, p in enumerate(points) for q in points[i + 1 :])
    return max(pairs, key=_length)


def _vertex_at(paper: Paper, face: int, point: Point) -> int | None:
    near = min(paper.faces[face], key=lambda v: _length((paper.vertices_coords[v], point)))
    return near if _length((paper.vertices_coords[near], point)) <= NEAR else None


def _vertex_to_add(paper: Paper, face: int, point: Point, *, snaps: bool) -> AddVertex:
    """The vertex on the side of a face that is nearest to a point, at the fraction that was meant or as it is."""
    candidates = []
    for u, v in sides(paper.faces[face]):
        p, q = paper.vertices_coords[u], paper.vertices_coords[v]
        length = _length((p, q))
        along = ((point[0] - p[0]) * (q[0] - p[0]) + (point[1] - p[1]) * (q[1] - p[1])) / length**2
        away = _length((between(p, q, min(max(along, 0.0), 1.0)), point))
        candidates.append(
            (away, (u, v), snapped_fraction(along, 2 * ROUNDING / length) if snaps else round(along, 6))
        )
    _, edge, position = min(candidates)
    return AddVertex(edge=edge, position=min(max(position, 0.0), 1.0))


def snapped_fraction(value: float, within: float) -> float:
    """The value that folding gives ``within`` reach, the fraction with the smallest denominator first; else four decimals."""
    fractions = [round(value * denominator) / denominator for denominator in FRACTION_DENOMINATORS]
    simple = FRACTION_DENOMINATORS.index(20)
    near = (*fractions[:simple], *FOLDED_FRACTIONS, *fractions[simple:])
    return next((each for each in near if abs(each - value) <= within), round(value, 4))


def _on_one_line(one: CreaseOnPaper, other: CreaseOnPaper) -> bool:
    line = line_through(*other.ends)
    return all(abs(line.distance(end)) <= NEAR for end in one.ends)


def _length(ends: tuple[Point, Point]) -> float:
    return hypot(ends[0][0] - ends[1][0], ends[0][1] - ends[1][1])
