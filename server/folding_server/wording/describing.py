"""What to say of each move of a lesson, so that whoever folds what is said has the same paper.

Sayings are tried from the plainest on: a corner to a corner, an edge to a crease, the other axioms among named places, points
marked at fractions, and at last points of the sheet. Each is read back from its English words and folded on the paper that the
sayings before it lead to, and the first is taken that leads to the state of the program.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import islice
from math import dist

from folding_schemas.actions import Flip, Fold, Rotate, Unfold

from folding_server.errors import FoldingError
from folding_server.geometry.line import Line, Point
from folding_server.instructions.moves import Lesson, Move
from folding_server.instructions.step_scene import layers_at, layers_turned, turned_edges
from folding_server.photographer.movements import Swing, swing_of
from folding_server.simulator import Paper, new_paper
from folding_server.wording.alignments import LETTERS, by_marks, by_names, named_or_marked, rounded, side_of
from folding_server.wording.landmarks import Landmarks
from folding_server.wording.reading import read_line
from folding_server.wording.refolding import SaidPlaces, refold
from folding_server.wording.said import OnSheet, Said, SaidFold, SaidMarks, SaidTurn, SaidTurnOver, SaidUnfold
from folding_server.wording.same_state import ALIKE, shift_between
from folding_server.wording.sentences import Sentences

MOST_TRIED = 40
"""So many sayings of a fold are tried by names before points are marked for it."""


@cache
def _english() -> Sentences:
    return Sentences("en")


@dataclass(frozen=True)
class Care:
    """How exact sayings are: states may differ ``within`` so many sheet units; fractions have so many decimals.

    Said ``by_letter``, every point is marked on the unfolded sheet, as the program has it.
    """

    within: float
    digits: tuple[int, ...]
    by_letter: bool = False


CARES = (Care(ALIKE / 5, (6, 9)), Care(1e-8, (6, 9, 12)), Care(1e-8, (12,), by_letter=True))
"""From plain to careful: more care is taken with a program of which the words would else lead elsewhere in the end.

Points that almost coincide make it so: a fold through two of them 0.0005 apart turns by 0.1 degrees when one is off by 0.000001.
"""


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
    """What is said of each move of a lesson, as plainly as it leads to the same states."""
    best: list[SaidMove] = []
    for care in CARES:
        told, paper = list[SaidMove](), new_paper(lesson.program.sheet)
        for move in lesson.moves:
            told.append(say_move(move, paper, care))
            paper = told[-1].after
        if all(each.exact for each in told):
            return told
        best = best or told
    return best


def say_move(move: Move, paper: Paper, care: Care = CARES[0]) -> SaidMove:
    """What is said of a move to whoever has ``paper``, which is in the state that the move starts from."""
    shift = shift_between(move.base, paper)
    tried: Iterator[Said] = iter(()) if shift is None else _sayings(move, paper, shift, care)
    for said in tried:
        try:
            heard = read_line(_english().say(said))
            _, after = refold(paper, heard or said)
        except FoldingError:
            continue
        if shift_between(move.after, after, care.within) is not None:
            return SaidMove(heard or said, paper, after)
    return SaidMove(SaidMarks(), move.base, move.after, exact=False)


def _sayings(move: Move, paper: Paper, shift: Point, care: Care) -> Iterator[Said]:
    match move.action:
        case Flip(axis=axis) if move.kind == "turn-over":
            yield SaidTurnOver(axis)
        case Rotate(angle=angle):
            yield SaidTurn(round(angle, max(care.digits)))
        case Unfold():
            yield from _unfold_sayings(paper, care)
        case Fold() if care.by_letter:
            yield _fold_by_letter(move)
        case Fold():
            yield from _fold_sayings(move, paper, shift, care)
        case _:
            marks = (
                _on_sheet(letter, move.before, v) for letter, v in zip(LETTERS, move.marks, strict=False)
            )
            yield SaidMarks(tuple(marks) if care.by_letter else ())


def _unfold_sayings(paper: Paper, care: Care) -> Iterator[SaidUnfold]:
    yield SaidUnfold()
    places = Landmarks(paper)
    coords = paper.folded_vertices_coords
    folded = [edge for edge in paper.creases if paper.is_folded(edge)]
    edges = sorted(folded, key=lambda e: -dist(coords[e[0]], coords[e[1]]))
    for edge in edges:
        keys, marks = named_or_marked([coords[v] for v in edge], places, care.digits[0])
        yield SaidUnfold(keys, marks)
    for u, v in edges:
        yield SaidUnfold(("letter.A", "letter.B"), (_on_sheet("A", paper, u), _on_sheet("B", paper, v)))


def _fold_sayings(move: Move, paper: Paper, shift: Point, care: Care) -> Iterator[SaidFold]:
    assert isinstance(move.action, Fold)
    swing = swing_of(move.action, move.before, move.turned)
    nx, ny, offset = swing.line
    line = Line(nx, ny, offset + nx * shift[0] + ny * shift[1])
    moving = [_shifted(p, shift) for p in moving_corners(swing)]
    ends = [_shifted(move.before.folded_vertices_coords[v], shift) for v in move.action.edge]
    places = Landmarks(paper)
    for said in islice(by_names(places, line, moving), MOST_TRIED):
        yield _completed(said, move, swing)
    for said in by_marks(places, line, moving, ends, care.digits):
        yield _completed(said, move, swing)
    yield _fold_by_letter(replace(move, marks=()))


def _fold_by_letter(move: Move) -> SaidFold:
    """The fold of a move between two points of the sheet, after all points that the program marks for it."""
    assert isinstance(move.action, Fold)
    swing = swing_of(move.action, move.before, move.turned)
    ends = move.action.edge
    marked = [*(v for v in move.marks if v not in ends), *ends]
    marks = tuple(_on_sheet(letter, move.before, v) for letter, v in zip(LETTERS, marked, strict=False))
    places = tuple(f"letter.{mark.letter}" for mark in marks[-2:])
    return _completed(SaidFold(1, places, side=side_of(swing.line), marks=marks), move, swing)


def _completed(said: SaidFold, move: Move, swing: Swing) -> SaidFold:
    """A saying with the layers of the fold, and whether it goes behind or is opened again."""
    behind, unfold = move.kind == "fold-behind", move.kind == "fold-and-unfold"
    counted = replace(said, layers=layers_turned(swing), of=layers_there(swing))
    return replace(counted, behind=behind, unfold=unfold, repeat=move.repeat is not None)


def _on_sheet(letter: str, paper: Paper, vertex: int) -> OnSheet:
    return OnSheet(letter, *rounded(paper.vertices_coords[vertex], 12))


def _shifted(point: Point, shift: Point) -> Point:
    return point[0] + shift[0], point[1] + shift[1]


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
