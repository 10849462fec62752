"""Whether people can fold a model from a given paper: bends of thick stacks, small flaps, and how errors of folds add up.

A bend of k layers of thickness t takes pi k t of its outermost layer, as in B. Gallivan, "How to Fold Paper in Half Twelve Times"
(2002), where the bends of a strip that is folded in half again and again add up to the length that is needed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import dist, hypot, pi

from folding_schemas.actions import Action, AddVertex, Fold

from folding_server.errors import ActionRefused
from folding_server.geometry.line import Point
from folding_server.instructions.moves import Lesson, Move
from folding_server.instructions.step_scene import layers_turned
from folding_server.photographer.movements import swing_of
from folding_server.simulator import apply, new_paper
from folding_server.simulator.counterpart import Counterpart, NoCounterpart

BEND_PART = 0.25
"""A stack folds sharply while its bend takes no more than this part of the flap: more, and the flap springs open."""
FINGER_MM = 5.0
"""Flaps that reach less far from their crease than half a fingertip are hard to hold."""
FOLDED: tuple[str, ...] = ("fold", "fold-behind", "fold-and-unfold")


@dataclass(frozen=True)
class PaperStock:
    """A paper: the longer side of the sheet and its thickness in millimetres, and by how much each fold may be off."""

    side: float = 150.0
    thickness: float = 0.1
    off: float = 0.5


@dataclass(frozen=True)
class FoldDemand:
    """What a fold asks of the paper: layers, how far its flap reaches and how much of that its bend takes, in millimetres."""

    number: int
    layers: int
    flap: float
    bend: float

    @property
    def too_thick(self) -> bool:
        """Whether the bend takes more of the flap than paper gives."""
        return self.bend > BEND_PART * self.flap

    @property
    def too_small(self) -> bool:
        """Whether the flap is smaller than fingers hold."""
        return self.flap < FINGER_MM


@dataclass(frozen=True)
class CornerError:
    """How far a corner of the finished model may be off, in millimetres: if errors are independent, and at worst.

    ``at`` is where it lies, ``moved`` how many of the ``folds`` could be moved to find out.
    """

    at: Point
    usual: float
    worst: float
    moved: int
    folds: int


def fold_demands(lesson: Lesson, stock: PaperStock) -> list[FoldDemand]:
    """What each fold asks of the paper, by the number of its move."""
    scale = stock.side / max(lesson.program.sheet)
    moves = enumerate(lesson.moves, 1)
    return [_demand(number, move, scale, stock.thickness) for number, move in moves if move.kind in FOLDED]


def _demand(number: int, move: Move, scale: float, thickness: float) -> FoldDemand:
    swing = swing_of(move.action, move.before, move.turned)
    reach = max(
        swing.line.distance(motion(swing.paper.vertices_coords[v]))
        for face, motion in swing.starts.items()
        for v in swing.paper.faces[face]
    )
    layers = layers_turned(swing)
    return FoldDemand(number, layers, reach * scale, pi * layers * thickness)


def corner_error(lesson: Lesson, stock: PaperStock) -> CornerError | None:
    """The corner of the finished model that small errors of folds move furthest; None where no fold could be moved.

    Each fold in turn is moved by ``stock.off`` at one end, either way, and the rest is folded by the landmarks that this
    leaves: what the corners move by is added up, squares for what is usual.
    """
    actions = [action for step in lesson.program.steps[: _steps_done(lesson)] for action in step]
    off = stock.off / stock.side * max(lesson.program.sheet)
    places = lesson.final.folded_vertices_coords
    squares, sums, moved = dict.fromkeys(places, 0.0), dict.fromkeys(places, 0.0), 0
    ends = list(_movable(actions))
    for at in ends:
        found = [
            shifts for sign in (1, -1) if (shifts := _shifts(lesson, actions, at, sign * off)) is not None
        ]
        moved += bool(found)
        for v in places:
            most = max((shifts.get(v, 0.0) for shifts in found), default=0.0)
            squares[v], sums[v] = squares[v] + most**2, sums[v] + most
    if not moved:
        return None
    worst = max(places, key=lambda v: (round(sums[v], 9), v))
    scale = stock.side / max(lesson.program.sheet)
    return CornerError(places[worst], squares[worst] ** 0.5 * scale, sums[worst] * scale, moved, len(ends))


def _steps_done(lesson: Lesson) -> int:
    """How many steps of the program the lesson has."""
    if lesson.refusal is None:
        return len(lesson.program.steps)
    return lesson.moves[-1].step if lesson.moves else 0


def _movable(actions: Sequence[Action]) -> Iterator[int]:
    """The actions that place a line: points that are marked, and folds for which none is."""
    marked = False
    for i, action in enumerate(actions):
        if isinstance(action, AddVertex):
            marked = True
            yield i
        elif isinstance(action, Fold):
            if not marked:
                yield i
            marked = False


def _shifts(lesson: Lesson, actions: Sequence[Action], at: int, off: float) -> dict[int, float] | None:
    """How far each vertex ends from where it should if one action is off; None if that makes another model."""
    sheet = lesson.program.sheet
    hands = Counterpart.of(new_paper(sheet), new_paper(sheet))
    try:
        for i, action in enumerate(actions):
            if i == at and isinstance(action, Fold):
                _fold_beside(hands, action, off)
            else:
                hands.carry_out(action, off if i == at else 0.0)
    except (NoCounterpart, ActionRefused):
        return None
    if not hands.same_model():
        return None
    exact, real = hands.exact.folded_vertices_coords, hands.real.folded_vertices_coords
    ways = {v: (real[w][0] - exact[v][0], real[w][1] - exact[v][1]) for v, w in hands.twin.items()}
    x, y = (sum(way[i] for way in ways.values()) / len(ways) for i in (0, 1))
    return {v: hypot(way[0] - x, way[1] - y) for v, way in ways.items()}


def _fold_beside(hands: Counterpart, action: Fold, off: float) -> None:
    """Fold with the second end of the line a little along the sheet's edge, on the paper of imprecise hands alone."""
    v, real = hands.twin[action.edge[1]], hands.real
    neighbours = [
        w
        for edge, beside in real.edge_faces.items()
        if v in edge and len(beside) == 1
        for w in edge
        if w != v
    ]
    if not neighbours:
        raise NoCounterpart
    ordered = sorted(neighbours)
    w = ordered[0 if off > 0 else -1]
    reach = dist(real.vertices_coords[v], real.vertices_coords[w])
    if reach <= 2 * abs(off):
        raise NoCounterpart
    hands.real = apply(real, AddVertex(edge=(v, w), position=abs(off) / reach))
    hands.twin[action.edge[1]] = max(hands.real.vertices_coords)
    hands.carry_out(action, 0.0)
    hands.twin[action.edge[1]] = v
