"""What is said, folded: each saying as actions of a program on the paper that it is said of."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from math import dist
from typing import cast

from folding_schemas.actions import Action, AddVertex, Direction, Flip, Fold, Rotate, Unfold

from folding_server.errors import ActionRefused, ProgramError
from folding_server.geometry.graph import Edge, edge_of, sides
from folding_server.geometry.line import Line, Point, between, line_through
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.instructions.step_scene import layers_turned
from folding_server.photographer.movements import Swing, swing_of
from folding_server.simulator import Paper, apply
from folding_server.wording.axioms import lines_of
from folding_server.wording.landmarks import MEETING, Landmarks, NamedLine, toward
from folding_server.wording.said import (
    InBox,
    LineKey,
    MarkedPoint,
    OnLine,
    OnSheet,
    PlaceKey,
    Said,
    SaidFold,
    SaidMarks,
    SaidTurn,
    SaidTurnOver,
    SaidUnfold,
)

Folded = tuple[tuple[Action, ...], Paper]
"""Actions, and the paper after them."""

BEHIND = Flip(axis="x")
"""How the model is held to fold behind: turned over, and back again afterwards."""


class SaidPlaces:
    """The places and lines of a saying on the paper that it is said of. ProgramError for one that the paper does not have."""

    def __init__(self, landmarks: Landmarks, marks: Iterable[MarkedPoint] = ()) -> None:
        self.landmarks = landmarks
        self.letters: dict[str, Point] = {}
        self.on_sheet: dict[str, Point] = {}
        for mark in marks:
            self.letters[mark.letter] = self._marked(mark)

    def point(self, key: PlaceKey) -> Point:
        """Where a place is."""
        kind, _, letter = key.partition(".")
        found = self.letters.get(letter) if kind == "letter" else self.landmarks.points.get(key)
        if found is None:
            known = ", ".join(sorted(self.landmarks.points))
            raise ProgramError(f"The paper has no {key!r} now; its named points are {known or 'none'}.")
        return found

    def line(self, key: LineKey) -> NamedLine:
        """Where a line is."""
        if key.count(":") == 2:
            kind, first, last = key.split(":")
            start, end = self.point(first), self.point(last)
            if dist(start, end) > MEETING:
                return NamedLine(kind, line_through(start, end), start, end)
        found = self.landmarks.lines.get(key)
        if found is None:
            known = ", ".join(sorted(self.landmarks.lines))
            raise ProgramError(f"The paper has no {key!r} now; its named lines are {known or 'none'}.")
        return found

    def _marked(self, mark: MarkedPoint) -> Point:
        if isinstance(mark, OnLine):
            return between(*self.line(mark.line).ends(), mark.part)
        if isinstance(mark, InBox):
            (left, low), (right, high) = self.landmarks.box
            at = left + mark.across * (right - left), low + mark.up * (high - low)
            near = min(self.landmarks.spots, key=lambda spot: dist(spot, at))
            return near if dist(near, at) <= MEETING else at
        self.on_sheet[mark.letter] = mark.x, mark.y
        return folded_place(self.landmarks.paper, (mark.x, mark.y))


def folded_place(paper: Paper, at: Point) -> Point:
    """Where a point of the unfolded sheet lies now: on the face that it is in, or nearest to."""

    def outside(face: int) -> float:
        outline = paper.sheet_polygon(face)
        middle = sum(x for x, _ in outline) / len(outline), sum(y for _, y in outline) / len(outline)
        worst = 0.0
        for p, q in zip(outline, [*outline[1:], outline[0]], strict=True):
            if dist(p, q) > 1e-9:
                side = line_through(p, q)
                sign = 1 if side.distance(middle) > 0 else -1
                worst = min(worst, sign * side.distance(at))
        return worst

    return paper.isometries[max(paper.order, key=outside)](at)


def refold(paper: Paper, said: Said) -> Folded:
    """The actions of a saying and the paper after them. ProgramError if the paper has no such place or fold."""
    match said:
        case SaidTurnOver(axis=axis):
            return _done(paper, (Flip(axis=axis),))
        case SaidTurn(angle=angle):
            return _done(paper, (Rotate(angle=angle),))
    marked, paper = _marked_on_sheet(paper, said.marks)
    match said:
        case SaidMarks():
            return marked, paper
        case SaidUnfold():
            found = next(unfoldings(paper, said), None) or _nothing("No crease there is folded.")
        case SaidFold():
            found = next(foldings(paper, said), None) or _nothing("The paper cannot be folded so.")
    return (*marked, *found[0]), found[1]


def _marked_on_sheet(paper: Paper, marks: Iterable[MarkedPoint]) -> Folded:
    """The paper with vertices at the points that are marked on the unfolded sheet, of which each lies on an edge."""
    actions: list[Action] = []
    for mark in marks:
        if isinstance(mark, OnSheet):
            paper, action, _ = _at_sheet_point((mark.x, mark.y))(paper)
            actions += [action] if action else []
    return tuple(actions), paper


def _nothing(sentence: str) -> Folded:
    raise ProgramError(f"{sentence[:-1]}; say another line, side or number of layers.")


def _done(paper: Paper, actions: Iterable[Action]) -> Folded:
    done = tuple(actions)
    for action in done:
        paper = apply(paper, action)
    return done, paper


def unfoldings(paper: Paper, said: SaidUnfold) -> Iterator[Folded]:
    """Ways to open what is said, the newest fold first."""
    if not said.places:
        yield _done(paper, (Unfold(),))
        return
    places = SaidPlaces(Landmarks(paper), said.marks)
    ends = [places.point(key) for key in said.places]
    coords = paper.folded_vertices_coords
    on_sheet = list(places.on_sheet.values())

    def off(edge: Edge) -> float:
        """How far from the points of the sheet that are said, if any, the ends of an edge lie on it."""
        return sum(min(dist(at, paper.vertices_coords[v]) for v in edge) for at in on_sheet)

    for edge in sorted(paper.creases, key=lambda e: (off(e), -paper.creases[e].fold)):
        here = coords[edge[0]], coords[edge[1]]
        if paper.is_folded(edge) and all(min(dist(p, end) for p in here) <= MEETING for end in ends):
            try:
                yield _done(paper, (Unfold(edge=edge),))
            except ActionRefused:
                continue


def foldings(paper: Paper, said: SaidFold) -> Iterator[Folded]:
    """Ways to fold what is said, those of the upper layers first; opened again if that is said too."""
    for actions, folded in _foldings(paper, said):
        if not said.unfold:
            yield actions, folded
            continue
        try:
            opened = apply(folded, Unfold())
        except ActionRefused:
            continue
        yield (*actions, Unfold()), opened


def _foldings(paper: Paper, said: SaidFold) -> Iterator[Folded]:
    places = SaidPlaces(Landmarks(paper), said.marks)
    points, lines = [places.point(key) for key in said.places], [places.line(key) for key in said.lines]
    brought = _brought(said, points, places)
    for line in lines_of(said.axiom, points, lines):
        towards = _oriented(
            line, said, brought or [end for each in lines[:1] for end in (each.start, each.end)]
        )
        if towards is None:
            continue
        ways = _between_sheet_points(paper, said, places, towards) or _by_face(
            paper, towards, behind=said.behind
        )
        for actions, folded in ways:
            if _folds_so(paper, folded, actions, said, brought):
                yield from (
                    _repeated(actions, folded, said, towards, brought, places)
                    if said.repeat
                    else [(actions, folded)]
                )


def _folds_so(
    paper: Paper, folded: Paper, actions: Sequence[Action], said: SaidFold, brought: Sequence[Point]
) -> bool:
    """Whether a fold goes through as many layers as are said, and moves what is said to be brought somewhere."""
    swing = swing_of(actions[-1], paper, folded)
    return layers_turned(swing) == said.layers and _moves(swing, brought)


def _repeated(
    actions: tuple[Action, ...],
    folded: Paper,
    said: SaidFold,
    line: Line,
    brought: Sequence[Point],
    places: SaidPlaces,
) -> Iterator[Folded]:
    """The same on the other side, of the model as it was before."""
    middle = places.landmarks.middle
    other, points = mirrored_line(line, middle), [mirrored_point(at, middle) for at in brought]
    for more, after in _by_face(folded, other, behind=said.behind):
        if _folds_so(folded, after, more, said, points):
            yield (*actions, *more), after


def mirrored_line(line: Line, middle: float) -> Line:
    """A line with left and right swapped about an upright line at ``middle``."""
    return Line(-line.nx, line.ny, line.offset - 2 * middle * line.nx)


def mirrored_point(point: Point, middle: float) -> Point:
    """A point with left and right swapped about an upright line at ``middle``."""
    return 2 * middle - point[0], point[1]


def _brought(said: SaidFold, points: Sequence[Point], places: SaidPlaces) -> list[Point]:
    """The points that are said to move."""
    if said.flap is not None:
        return [places.point(said.flap)]
    return list(points[: {2: 1, 5: 1, 6: 2, 7: 1}.get(said.axiom, 0)])


def _oriented(line: Line, said: SaidFold, moving: Sequence[Point]) -> Line | None:
    """The line with its normal to the side that moves; None if what is brought does not lie on one side of it."""
    if said.side is not None:
        x, y = toward(said.side)
        return line if line.nx * x + line.ny * y > 0 else line.opposite()
    apart = [line.distance(point) for point in moving]
    if max(apart) > MEETING and min(apart) >= -MEETING:
        return line
    return line.opposite() if min(apart) < -MEETING and max(apart) <= MEETING else None


def _moves(swing: Swing, brought: Sequence[Point]) -> bool:
    """Whether the points that are brought somewhere lie on the part that moves."""
    paper = swing.paper
    corners = [
        motion(paper.vertices_coords[v]) for face, motion in swing.starts.items() for v in paper.faces[face]
    ]
    return all(any(dist(corner, point) <= 2 * MEETING for corner in corners) for point in brought)


def _by_face(paper: Paper, line: Line, *, behind: bool) -> Iterator[Folded]:
    """Folds along a line, each started from another face, the upper faces first."""
    if behind:
        yield from (
            _turned_back(way) for way in _by_face(apply(paper, BEHIND), _flipped(paper, line), behind=False)
        )
        return
    for face in reversed(paper.order):
        ends = _ends_on_face(paper, face, line)
        if ends is not None:
            folded = _folded_through(paper, ends, line)
            if folded is not None:
                yield folded


def _flipped(paper: Paper, line: Line) -> Line:
    """A line as it lies after the model was turned over sideways."""
    return mirrored_line(line, paper.sheet[0] / 2)


def _turned_back(way: Folded) -> Folded:
    """A fold made from the back: the marks first, then turned over, folded and turned back."""
    actions = (BEHIND, *way[0], BEHIND)
    return actions, apply(way[1], BEHIND)


End = Callable[[Paper], tuple[Paper, AddVertex | None, int]]
"""Makes one end of a fold on a paper: the paper with it, the action if one was needed, and the vertex."""


def _ends_on_face(paper: Paper, face: int, line: Line) -> tuple[End, End] | None:
    """The two ends of a line on the boundary of a face that has area on the side that moves; None if it has no such."""
    coords = paper.folded_vertices_coords
    outline = paper.polygon(face)
    far = {v: line.distance(at) for v, at in zip(paper.faces[face], outline, strict=True)}
    if max(far.values()) <= TOLERANCE:
        return None
    found: list[tuple[float, End]] = []
    for u, v in sides(paper.faces[face]):
        if abs(far[u]) <= TOLERANCE:
            found.append((_along(line, coords[u]), _at_vertex(u)))
        elif abs(far[v]) > TOLERANCE and far[u] * far[v] < 0:
            part = far[u] / (far[u] - far[v])
            found.append((_along(line, between(coords[u], coords[v], part)), _on_edge(u, v, part)))
    found.sort(key=lambda each: each[0])
    if len(found) < 2 or found[-1][0] - found[0][0] <= TOLERANCE:
        return None
    return found[0][1], found[-1][1]


def _along(line: Line, point: Point) -> float:
    return -line.ny * point[0] + line.nx * point[1]


def _at_vertex(vertex: int) -> End:
    return lambda paper: (paper, None, vertex)


def _on_edge(u: int, v: int, part: float) -> End:
    def make(paper: Paper) -> tuple[Paper, AddVertex | None, int]:
        action = AddVertex(edge=(u, v), position=part)
        return apply(paper, action), action, max(paper.vertices_coords) + 1

    return make


def _folded_through(paper: Paper, ends: tuple[End, End], line: Line) -> Folded | None:
    """The fold through two ends, the side of the line's normal moving; None if the paper refuses."""
    actions: list[Action] = []
    vertices: list[int] = []
    try:
        for end in ends:
            paper, action, vertex = end(paper)
            actions += [action] if action else []
            vertices.append(vertex)
        u, v = vertices
        actions.append(Fold(edge=(u, v), direction=_direction(paper, u, v, line)))
        return tuple(actions), apply(paper, actions[-1])
    except ActionRefused:
        return None


def _direction(paper: Paper, u: int, v: int, line: Line) -> Direction:
    """The direction of a fold that moves the side of a line's normal."""
    (px, py), (qx, qy) = paper.folded_vertices_coords[u], paper.folded_vertices_coords[v]
    vertical = abs(qx - px) <= TOLERANCE * abs(qy - py)
    return 1 if (line.nx if vertical else line.ny) > 0 else -1


def _between_sheet_points(paper: Paper, said: SaidFold, places: SaidPlaces, line: Line) -> list[Folded]:
    """The fold between two points of the sheet, where both places are such: no other face is meant than theirs."""
    named = [places.on_sheet.get(key.removeprefix("letter.")) for key in said.places]
    if said.axiom != 1 or None in named:
        return []
    first, last = (_at_sheet_point(cast("Point", at)) for at in named)
    if not said.behind:
        found = _folded_through(paper, (first, last), line)
        return [found] if found else []
    found = _folded_through(apply(paper, BEHIND), (first, last), _flipped(paper, line))
    return [_turned_back(found)] if found else []


def _at_sheet_point(at: Point) -> End:
    def make(paper: Paper) -> tuple[Paper, AddVertex | None, int]:
        coords = paper.vertices_coords
        vertex = min(coords, key=lambda v: dist(coords[v], at))
        if dist(coords[vertex], at) <= SAME_SHEET_POINT:
            return paper, None, vertex
        (u, v), part = min(
            ((edge, _foot(coords[edge[0]], coords[edge[1]], at)) for edge in paper.edge_faces),
            key=lambda each: dist(between(coords[each[0][0]], coords[each[0][1]], each[1]), at),
        )
        reach = dist(coords[u], coords[v])
        if min(part, 1 - part) * reach <= TOLERANCE:
            return paper, None, u if part < 0.5 else v
        return _on_edge(*edge_of(u, v), part)(paper)

    return make


SAME_SHEET_POINT = 1e-6
"""A vertex this near a point of the sheet is meant by it: points are said to nine digits."""


def _foot(p: Point, q: Point, at: Point) -> float:
    """Where on a stretch, as a part from 0 to 1, is nearest to a point."""
    dx, dy = q[0] - p[0], q[1] - p[1]
    square = dx * dx + dy * dy
    return min(1.0, max(0.0, ((at[0] - p[0]) * dx + (at[1] - p[1]) * dy) / square)) if square > 0 else 0.0
