"""A program as the moves that a folder makes: what one drawing of a sheet of instructions shows.

The points that are marked for a fold belong to its move; a fold that is undone at once is one move with its unfolding; a
step that turns over, folds and turns over again folds behind.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import dist
from typing import Literal

from folding_schemas.actions import Action, Actions, AddVertex, Flip, Fold, Program, Rotate, Unfold

from folding_server.diagram.strip import describe_action
from folding_server.errors import ActionRefused
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator import Paper, apply, new_paper

MoveKind = Literal["fold", "fold-behind", "fold-and-unfold", "unfold", "turn-over", "rotate", "mark"]


@dataclass(frozen=True)
class Move:
    """One move: ``base`` is the paper before it, ``before`` that with the points marked for it, ``after`` the paper after it.

    ``turned`` is the paper as the action left it: of a fold that is undone at once, while it is folded. ``repeat`` is the same fold
    on the other side, if it is told as one with it; ``after`` then is the paper after both.
    """

    kind: MoveKind
    step: int
    action: Action
    marks: tuple[int, ...]
    base: Paper
    before: Paper
    turned: Paper
    after: Paper
    repeat: "Move | None" = None


@dataclass(frozen=True)
class Lesson:
    """The moves of a program as far as it can be folded. ``refusal`` says why it ends early, None if it does not."""

    program: Program
    moves: tuple[Move, ...]
    refusal: str | None = None

    @property
    def title(self) -> str:
        """What people call the model: its name without the signs of a file's name."""
        return self.program.name.replace("_", " ").strip()

    @property
    def final(self) -> Paper:
        """The finished model."""
        return self.moves[-1].after if self.moves else new_paper(self.program.sheet)


def lesson_of(program: Program) -> Lesson:
    """The moves of a program; of one that fails, those of the steps before the one that does."""
    paper = new_paper(program.sheet)
    moves: list[Move] = []
    for number, step in enumerate(program.steps, 1):
        try:
            made = list(_moves_of_step(paper, step, number))
        except _StepRefused as refused:
            return Lesson(program, _joined_with_unfolding(moves), str(refused))
        moves += made
        paper = made[-1].after if made else paper
    return Lesson(program, _joined_with_unfolding(moves))


class _StepRefused(Exception):
    """A step of which an action is refused."""


def _moves_of_step(paper: Paper, step: Actions, number: int) -> Iterator[Move]:
    base, marks, at = paper, tuple[int, ...](), 0
    while at < len(step):
        action, count = step[at], 1
        if isinstance(action, AddVertex):
            paper = _applied(paper, step, at, number)
            marks = (*marks, max(paper.vertices_coords))
        elif (count := _folds_behind(step, at)) > 1:
            move = _behind(base, paper, step, at, count, number)
            yield replace(move, marks=(*marks, *move.marks))
            base, paper, marks = move.after, move.after, ()
        else:
            after = _applied(paper, step, at, number)
            yield Move(_kind(action), number, action, marks, base, paper, after, after)
            base, paper, marks = after, after, ()
        at += count
    if marks:
        yield Move("mark", number, step[-1], marks, base, paper, paper, paper)


def _applied(paper: Paper, step: Actions, at: int, number: int) -> Paper:
    try:
        return apply(paper, step[at])
    except ActionRefused as refused:
        message = f"Step {number}, action {at + 1} ({describe_action(step[at])}): {refused}"
        raise _StepRefused(message) from refused


def _kind(action: Action) -> MoveKind:
    kinds: dict[type, MoveKind] = {Fold: "fold", Unfold: "unfold", Flip: "turn-over", Rotate: "rotate"}
    return kinds.get(type(action), "mark")


def _folds_behind(step: Actions, at: int) -> int:
    """How many actions from ``at`` on turn over, fold and turn back over; 1 if they do not."""
    end = at + 1
    while end < len(step) and isinstance(step[end], AddVertex):
        end += 1
    if isinstance(step[at], Flip) and end + 1 < len(step) and isinstance(step[end], Fold):
        return end + 2 - at if step[end + 1] == step[at] else 1
    return 1


def _behind(base: Paper, paper: Paper, step: Actions, at: int, count: int, number: int) -> Move:
    """A fold made from the back. Points marked on the way are marked from the front, where they are the same."""
    marked, marks, turned = paper, list[int](), paper
    for i in range(at, at + count):
        turned = _applied(turned, step, i, number)
        if isinstance(step[i], AddVertex):
            marked = apply(marked, step[i])
            marks.append(max(marked.vertices_coords))
    return Move("fold-behind", number, step[at + count - 2], tuple(marks), base, marked, turned, turned)


def _joined_with_unfolding(moves: Sequence[Move]) -> tuple[Move, ...]:
    """The moves, each fold that is undone by the next move as one with it."""
    joined: list[Move] = []
    for move in moves:
        last = joined[-1] if joined else None
        undoes = move.kind == "unfold" and not move.marks and last is not None and last.kind == "fold"
        if undoes and last is not None and lies_as(last.before, move.after):
            joined[-1] = replace(last, kind="fold-and-unfold", after=move.after)
        else:
            joined.append(move)
    return tuple(joined)


def lies_as(before: Paper, after: Paper) -> bool:
    """Whether every vertex that both papers have lies where it did."""
    there = after.folded_vertices_coords
    return all(dist(at, there[v]) <= TOLERANCE for v, at in before.folded_vertices_coords.items())
