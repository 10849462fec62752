"""What to say of each move of a lesson, so that whoever folds what is said has the same paper.

Sayings are tried from the plainest on: a corner to a corner, an edge to a crease, the other axioms among named places, points
marked at fractions, and at last points of the sheet. Each is folded on the paper that the sayings before it lead to, and the
first is taken that leads to the state of the program.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, islice, permutations
from math import dist

from folding_schemas.actions import Flip, Fold, Rotate, Unfold

from folding_server.errors import FoldingError
from folding_server.geometry.isometry import mirror
from folding_server.geometry.line import Line, Point
from folding_server.instructions.moves import Lesson, Move
from folding_server.instructions.step_scene import layers_at, layers_turned, turned_edges
from folding_server.photographer.movements import Swing, swing_of
from folding_server.simulator import Paper, new_paper
from folding_server.wording.landmarks import MEETING, Landmarks, NamedLine, spot_in_box
from folding_server.wording.refolding import SaidPlaces, refold
from folding_server.wording.said import (
    InBox,
    MarkedPoint,
    OnLine,
    OnSheet,
    Said,
    SaidFold,
    SaidMarks,
    SaidTurn,
    SaidTurnOver,
    SaidUnfold,
)
from folding_server.wording.same_state import shift_between

MOST_TRIED = 40
"""So many sayings of a fold are tried by names before points are marked for it."""
SQUARE = 1e-3
"""Lines whose unit normals have no larger product stand at right angles."""
DIGITS = (6, 9)
"""How many decimals a fraction is said with: more only where fewer lead elsewhere."""
LETTERS = "ABCDEFGH"


@dataclass(frozen=True)
class SaidMove:
    """What is said of a move, and the papers of whoever folds it: ``before`` and ``after``.

    ``exact`` is False where no saying leads to the state of the program; the papers are then those of the program.
    """

    said: Said
    before: Paper
    after: Paper
    exact: bool = True


def say(lesson: Lesson) -> list[SaidMove]:
    """What is said of each move of a lesson."""
    paper = new_paper(lesson.program.sheet)
    told: list[SaidMove] = []
    for move in lesson.moves:
        told.append(say_move(move, paper))
        paper = told[-1].after
    return told


def say_move(move: Move, paper: Paper) -> SaidMove:
    """What is said of a move to whoever has ``paper``, which is in the state that the move starts from."""
    shift = shift_between(move.base, paper)
    tried: Iterator[Said] = iter(()) if shift is None else _sayings(move, paper, shift)
    for said in tried:
        after = _leads_to(move, paper, said)
        if after is not None:
            return SaidMove(said, paper, after)
    return SaidMove(SaidMarks(), move.base, move.after, exact=False)


def _leads_to(move: Move, paper: Paper, said: Said) -> Paper | None:
    """The paper after what is said, if it is in the state that the move leads to."""
    try:
        _, after = refold(paper, said)
    except FoldingError:
        return None
    return None if shift_between(move.after, after) is None else after


def _sayings(move: Move, paper: Paper, shift: Point) -> Iterator[Said]:
    match move.action:
        case Flip(axis=axis) if move.kind == "turn-over":
            yield SaidTurnOver(axis)
        case Rotate(angle=angle):
            yield SaidTurn(round(angle, 9))
        case Unfold():
            yield from _unfold_sayings(move, paper)
        case Fold():
            yield from _fold_sayings(move, paper, shift)
        case _:
            yield SaidMarks()


def _unfold_sayings(move: Move, paper: Paper) -> Iterator[SaidUnfold]:
    yield SaidUnfold()
    places = Landmarks(paper)
    swing = swing_of(move.action, move.before, move.after)
    coords = paper.folded_vertices_coords
    numbers = {move.before.creases[e].fold for e in turned_edges(swing) if e in move.before.creases}
    edges = [e for e, crease in paper.creases.items() if crease.fold in numbers and paper.is_folded(e)]
    for edge in sorted(edges, key=lambda e: -dist(coords[e[0]], coords[e[1]])):
        keys, marks = _named_or_marked([coords[v] for v in edge], places, DIGITS[0])
        yield SaidUnfold(keys, marks)
    for u, v in edges:
        ends = [
            OnSheet(letter, *_rounded(paper.vertices_coords[w], DIGITS[1]))
            for letter, w in zip("AB", (u, v), strict=True)
        ]
        yield SaidUnfold(("letter.A", "letter.B"), tuple(ends))


def _fold_sayings(move: Move, paper: Paper, shift: Point) -> Iterator[SaidFold]:
    swing = swing_of(move.action, move.before, move.turned)
    nx, ny, offset = swing.line
    line = Line(nx, ny, offset + nx * shift[0] + ny * shift[1])
    layers, of = layers_turned(swing), layers_there(swing)
    common = SaidFold(
        1, layers=layers, of=of, behind=move.kind == "fold-behind", unfold=move.kind == "fold-and-unfold"
    )
    moving = [_shifted(p, shift) for p in moving_corners(swing)]
    places = Landmarks(paper)
    named = _by_names(places, line, moving)
    for said in islice(named, MOST_TRIED):
        yield replace(said, layers=layers, of=of, behind=common.behind, unfold=common.unfold)
    assert isinstance(move.action, Fold)
    ends = [_shifted(_fold_end(move, v), shift) for v in move.action.edge]
    for said in _by_marks(places, line, moving, ends):
        yield replace(said, layers=layers, of=of, behind=common.behind, unfold=common.unfold)
    sheet = [_rounded(move.turned.vertices_coords[v], 12) for v in move.action.edge]
    marks = tuple(OnSheet(letter, *at) for letter, at in zip("AB", sheet, strict=True))
    yield replace(common, places=("letter.A", "letter.B"), marks=marks, side=side_of(line))


def _by_marks(
    places: Landmarks, line: Line, moving: Sequence[Point], ends: Sequence[Point]
) -> Iterator[SaidFold]:
    """The sayings of a fold by points that are marked for it: first with a corner that moves, then with its side."""
    far = sorted(moving, key=lambda p: -round(line.distance(p), 4))
    flaps = [p for p in far if places.name_at(p)][:3] + far[:1]
    for digits in DIGITS:
        for through in (ends, _outermost(places, line, ends)):
            for flap in flaps:
                keys, marks = _named_or_marked([*through, flap], places, digits)
                yield SaidFold(1, keys[:2], flap=keys[2], marks=marks)
            keys, marks = _named_or_marked(through, places, digits)
            yield SaidFold(1, keys, side=side_of(line), marks=marks)


def _fold_end(move: Move, vertex: int) -> Point:
    """Where a vertex of a fold lies before it."""
    return move.before.folded_vertices_coords[vertex]


def _outermost(places: Landmarks, line: Line, ends: Sequence[Point]) -> list[Point]:
    """The two spots on a line that are furthest apart, with the ends of the fold."""
    on_line = [*(spot for spot in places.spots if abs(line.distance(spot)) <= MEETING), *ends]
    along = sorted(on_line, key=lambda p: -line.ny * p[0] + line.nx * p[1])
    return [along[0], along[-1]]


@dataclass(frozen=True)
class _Alignments:
    """What a line aligns on a paper: named places that are ``brought`` somewhere, furthest first, and those ``met`` by it.

    ``landings`` are places and the named lines that they are brought to; ``across`` the named lines at right angles to it.
    """

    places: Landmarks
    line: Line
    moving: Sequence[Point]

    @cached_property
    def brought(self) -> list[tuple[str, Point]]:
        found = [
            (key, at)
            for key, at in self.places.points.items()
            if any(dist(at, p) <= MEETING for p in self.moving)
        ]
        return sorted(found, key=lambda each: -round(self.line.distance(each[1]), 4))

    @cached_property
    def met(self) -> list[tuple[str, Point]]:
        return [(key, at) for key, at in self.places.points.items() if abs(self.line.distance(at)) <= MEETING]

    @cached_property
    def landings(self) -> list[tuple[str, str]]:
        reflect, lines = mirror(self.line), self.places.lines.items()
        return [
            (key, other) for key, at in self.brought for other, each in lines if each.reaches(reflect(at))
        ]

    @cached_property
    def across(self) -> list[str]:
        return [key for key, each in self.places.lines.items() if _square_to(each.line, self.line)]

    def along(self, axiom: int, places: tuple[str, ...], lines: tuple[str, ...] = ()) -> SaidFold:
        """A fold along a line that brings nothing anywhere: with a place that moves, or else the side."""
        if self.brought:
            return SaidFold(axiom, places, lines, flap=self.brought[0][0])
        return SaidFold(axiom, places, lines, side=side_of(self.line))


def _by_names(places: Landmarks, line: Line, moving: Sequence[Point]) -> Iterator[SaidFold]:
    """The sayings of a fold by named places and lines, the plainest first; without layers."""
    found = _Alignments(places, line, moving)
    yield from _to_landmarks(found)
    yield from _through_landmarks(found)
    yield from _spot_to_spot(places, line, moving)
    for key, other in found.landings:
        yield from (SaidFold(7, (key,), (other, square)) for square in found.across if square != other)
    for (first, to), (second, other) in combinations(found.landings, 2):
        if first != second:
            yield SaidFold(6, (first, second), (to, other))


def _to_landmarks(found: _Alignments) -> Iterator[SaidFold]:
    """Axioms 2, 3 and 5."""
    reflect, lines = mirror(found.line), found.places.lines
    for key, at in found.brought:
        target = found.places.name_at(reflect(at))
        if target:
            yield SaidFold(2, (key, target))
    for first, second in permutations(lines, 2):
        if _is_brought(lines[first], lines[second], found.line):
            yield SaidFold(3, lines=(first, second))
    for key, other in found.landings:
        yield from (SaidFold(5, (key, through), (other,)) for through, _ in found.met)


def _through_landmarks(found: _Alignments) -> Iterator[SaidFold]:
    """Axioms 1 and 4."""
    for (first, p), (last, q) in combinations(found.met, 2):
        if dist(p, q) > 10 * MEETING:
            yield found.along(1, (first, last))
    for key in found.across:
        yield from (found.along(4, (through,), (key,)) for through, _ in found.met)


def _spot_to_spot(places: Landmarks, line: Line, moving: Sequence[Point]) -> Iterator[SaidFold]:
    """Axiom 2 for points that have no name but can be seen: the furthest of the part that moves, to where another lies."""
    far = sorted((p for p in moving if line.distance(p) > MEETING), key=lambda p: -round(line.distance(p), 4))
    for start in far[:4]:
        end = mirror(line)(start)
        if any(dist(spot, end) <= MEETING for spot in places.spots):
            keys, marks = _named_or_marked([start, end], places, DIGITS[0])
            yield SaidFold(2, keys, marks=marks)


def _is_brought(first: NamedLine, second: NamedLine, line: Line) -> bool:
    """Whether a fold brings the whole of one line to another."""
    reflect = mirror(line)
    apart = line.distance(first.start), line.distance(first.end)
    if min(apart) < -MEETING or max(apart) <= MEETING:
        return False
    return all(abs(second.line.distance(reflect(p))) <= MEETING for p in (first.start, first.end))


def _square_to(first: Line, second: Line) -> bool:
    return abs(first.nx * second.nx + first.ny * second.ny) <= SQUARE


def _named_or_marked(
    points: Iterable[Point], places: Landmarks, digits: int
) -> tuple[tuple[str, ...], tuple[MarkedPoint, ...]]:
    """The keys of points, and the marks of those that have no name."""
    keys: list[str] = []
    marks: list[MarkedPoint] = []
    for point in points:
        key = places.name_at(point)
        if key is None:
            marks.append(_mark(LETTERS[len(marks)], point, places, digits))
            key = f"letter.{marks[-1].letter}"
        keys.append(key)
    return tuple(keys), tuple(marks)


def _mark(letter: str, point: Point, places: Landmarks, digits: int) -> MarkedPoint:
    """A point by the part of the way along a named line, else by where it is in the box around the model."""
    for key, line in sorted(places.lines.items(), key=lambda item: not item[0].startswith("edge")):
        if line.reaches(point):
            first, last = line.ends()
            part = min(1.0, round(dist(first, point) / dist(first, last), digits))
            return OnLine(letter, key, part, line.upright)
    return InBox(letter, *_rounded(spot_in_box(places.box, point), digits))


def _rounded(point: Point, digits: int) -> Point:
    return round(point[0], digits), round(point[1], digits)


def _shifted(point: Point, shift: Point) -> Point:
    return point[0] + shift[0], point[1] + shift[1]


def side_of(line: Line) -> str:
    """The side to which the normal of a line points: top, bottom, left or right."""
    if abs(line.nx) > abs(line.ny):
        return "right" if line.nx > 0 else "left"
    return "top" if line.ny > 0 else "bottom"


def moving_corners(swing: Swing) -> list[Point]:
    """Where the corners of the part that moves lie before it does."""
    paper = swing.paper
    return [
        motion(paper.vertices_coords[v]) for face, motion in swing.starts.items() for v in paper.faces[face]
    ]


def layers_there(swing: Swing) -> int:
    """How many layers lie beside the line on the side that moves, where most are folded; those that stay count too."""
    turned, paper = layers_turned(swing), swing.paper
    most = turned
    for edge in turned_edges(swing):
        (stays,) = (f for f in paper.edge_faces[edge] if f not in swing.starts)
        p, q = (paper.isometries[stays](paper.vertices_coords[v]) for v in edge)
        beside = (p[0] + q[0]) / 2 + 0.01 * swing.line.nx, (p[1] + q[1]) / 2 + 0.01 * swing.line.ny
        most = max(most, layers_at(swing.before, beside))
    return most


def letters_of(told: SaidMove) -> dict[str, Point]:
    """The points that a saying gives letters to, on its own paper."""
    marks = getattr(told.said, "marks", ())
    return dict(SaidPlaces(Landmarks(told.before), marks).letters)
