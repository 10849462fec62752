"""What speaks against an explanation besides the photo."""

import pytest
from folding_schemas.actions import Action, AddVertex, Flip, Fold, Rotate, Unfold
from folding_server.geometry.isometry import IDENTITY
from folding_server.simulator import Paper, apply, new_paper, replay
from folding_server.vision.solver.plan import FREE_TURN, Plan
from folding_server.vision.solver.visible_change import against_nothing

BOOK: tuple[Action, ...] = (
    AddVertex(edge=(1, 2), position=0.5),
    AddVertex(edge=(3, 4), position=0.5),
    Fold(edge=(5, 6), direction=1),
    Unfold(),
)
"""A sheet creased in the middle."""


def fold_at(position: float) -> tuple[Action, ...]:
    """A fold across a creased sheet, parallel to its crease."""
    return (
        AddVertex(edge=(1, 5), position=position),
        AddVertex(edge=(6, 4), position=1 - position),
        Fold(edge=(7, 8), direction=-1),
    )


def plan(before: Paper, actions: tuple[Action, ...], agreement: float = 0.99, turned: float = 0.0) -> Plan:
    after = before
    for action in actions:
        after = apply(after, action)
    kind = actions[-1].action if actions else "none"
    assert kind != "add_vertex"
    return Plan(actions, kind, after, IDENTITY, agreement, "").noting(drift_turn=max(0.0, turned - FREE_TURN))


def judged(
    actions: tuple[Action, ...], agreement: float = 0.99, nothing: float = 0.9, turned: float = 0.0
) -> Plan:
    """A plan for a creased sheet; ``nothing`` is the agreement without it, under a drift of ``turned`` degrees."""
    paper = replay(BOOK)
    return against_nothing(plan(paper, actions, agreement), plan(paper, (), nothing, turned))


def test_a_fold_along_a_crease_that_is_there_is_likelier_than_beside_it() -> None:
    along, beside = judged((Fold(edge=(5, 6), direction=-1),)), judged(fold_at(0.97))
    assert not along.noted.new_crease
    assert beside.noted.new_crease
    assert along.score > beside.score


def test_a_crease_a_hair_beside_another_makes_a_sliver() -> None:
    assert judged(fold_at(0.98)).noted.sliver
    assert not judged(fold_at(0.8)).noted.sliver
    assert judged(fold_at(0.98)).score < judged(fold_at(0.8)).score


@pytest.mark.parametrize(("gain", "doubt"), [(0.0, 1.0), (0.0015, 0.5), (0.003, 0.0), (0.1, 0.0)])
def test_the_less_a_photo_shows_of_a_fold_the_more_it_is_doubted(gain: float, doubt: float) -> None:
    assert judged(fold_at(0.5), 0.9 + gain).noted.unseen_fold == pytest.approx(doubt)


def test_a_turn_that_shows_is_not_idle_and_a_drift_as_far_does_not_show_less() -> None:
    turn = (Rotate(angle=90),)
    assert judged(turn, 0.99, nothing=0.9).noted.unseen_turn == 0
    assert judged(turn, 0.99, nothing=0.99).noted.unseen_turn == 1
    assert judged(turn, 0.99, nothing=0.99, turned=90).noted.unseen_turn == 0


def test_a_flip_makes_no_crease() -> None:
    flipped = judged((Flip(axis="x"),))
    assert not flipped.noted.new_crease
    assert not flipped.noted.sliver
    assert against_nothing(plan(new_paper(), (Flip(axis="x"),)), plan(new_paper(), ())).noted.unseen_fold == 0
