"""What one photo cannot tell apart, the next one may."""

from collections.abc import Sequence

import pytest
from folding_schemas.actions import Action, AddVertex, Direction, Flip, FlipAxis, Fold, Unfold
from folding_server.simulator import Paper, apply, new_paper
from folding_server.vision.seeing import see_sequence
from folding_server.vision.solver import propose
from vision_scenes import Look, PhotoList, paint

LOOK = Look(front=(235, 215, 90), back=(150, 60, 50), table=(70, 80, 90), lamp=0.1)
STRIP_OVER: tuple[Action, ...] = (
    AddVertex(edge=(1, 2), position=0.75),
    AddVertex(edge=(4, 3), position=0.75),
    Fold(edge=(5, 6), direction=1),
)
"""The right quarter folded over: turned over, either way, the sheet is a plain rectangle."""


def states(steps: Sequence[Sequence[Action]]) -> list[Paper]:
    """The flat sheet and the paper after each step."""
    found = [new_paper()]
    for step in steps:
        paper = found[-1]
        for action in step:
            paper = apply(paper, action)
        found.append(paper)
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "direction"), [("x", 1), ("y", -1)])
def test_the_fold_after_a_flip_tells_about_which_axis_it_was(axis: FlipAxis, direction: Direction) -> None:
    corner = (
        AddVertex(edge=(5, 1), position=0.4),
        AddVertex(edge=(5, 6), position=0.3),
        Fold(edge=(7, 8), direction=direction),
    )
    papers = states([STRIP_OVER, (Flip(axis=axis),), corner])
    observer = see_sequence(PhotoList([paint(paper, LOOK, seed=i) for i, paper in enumerate(papers)]))
    turned, *_ = propose(papers[1], observer, 3)
    assert turned.paper == papers[2]


def test_without_a_photo_after_it_the_flip_is_one_of_two() -> None:
    papers = states([STRIP_OVER, (Flip(axis="x"),)])
    observer = see_sequence(PhotoList([paint(paper, LOOK, seed=i) for i, paper in enumerate(papers)]))
    first, second, *_ = propose(papers[1], observer, 3)
    assert {plan.actions for plan in (first, second)} == {(Flip(axis="x"),), (Flip(axis="y"),)}
    assert abs(first.score - second.score) < 0.001


@pytest.mark.slow
def test_a_crease_that_is_folded_along_next_tells_how_the_sheet_was_turned_over() -> None:
    diagonal = (Fold(edge=(2, 4), direction=1),)
    papers = states([diagonal, (Unfold(),), (Flip(axis="y=x"),), diagonal])
    observer = see_sequence(PhotoList([paint(paper, LOOK, seed=i) for i, paper in enumerate(papers)]))
    turned, *_ = propose(papers[2], observer, 4)
    assert turned.actions in {(Flip(axis="y=x"),), (Flip(axis="y=-x"),)}
    folded, *_ = propose(turned.paper, observer, 5)
    assert not folded.noted.new_crease
