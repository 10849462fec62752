"""Applying the actions of a program to a paper."""

from collections.abc import Iterable
from typing import assert_never

from folding_schemas.actions import Action, AddVertex, Flip, Fold, Rotate, Unfold

from folding_server.simulator.fold import fold
from folding_server.simulator.motions import flip, rotate
from folding_server.simulator.paper import Paper, new_paper
from folding_server.simulator.unfold import unfold
from folding_server.simulator.vertices import add_vertex


def apply(paper: Paper, action: Action) -> Paper:
    """The paper after one action. Raises ActionRefused with one sentence; the paper given is never changed."""
    match action:
        case AddVertex(edge=edge, position=position):
            return add_vertex(paper, edge, position)
        case Fold(edge=edge, direction=direction):
            return fold(paper, edge, direction)
        case Unfold(edge=edge):
            return unfold(paper, edge)
        case Rotate(angle=angle):
            return rotate(paper, angle)
        case Flip(axis=axis):
            return flip(paper, axis)
    assert_never(action)


def replay(actions: Iterable[Action], sheet: tuple[float, float] = (1.0, 1.0)) -> Paper:
    """The paper that a list of actions makes from a flat sheet. Raises ActionRefused at the first impossible one."""
    paper = new_paper(sheet)
    for action in actions:
        paper = apply(paper, action)
    return paper
