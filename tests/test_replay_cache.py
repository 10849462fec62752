"""The cache of papers and the account of what an action changed."""

import pytest
from folding_schemas.actions import Action, AddVertex, Fold, Rotate
from folding_server.errors import ActionRefused
from folding_server.mcp.services.replay_cache import ReplayCache
from folding_server.simulator import folded_state, new_paper, replay
from folding_server.simulator.state_diff import state_difference

SQUARE = (1.0, 1.0)
ACTIONS: tuple[Action, ...] = (
    AddVertex(edge=(1, 2), position=0.5),
    AddVertex(edge=(4, 3), position=0.5),
    Fold(edge=(5, 6), direction=1),
    Rotate(angle=30),
)


def test_a_cached_paper_is_the_paper_that_a_replay_makes() -> None:
    papers = ReplayCache()
    for end in range(len(ACTIONS) + 1):
        assert folded_state(papers.after(SQUARE, ACTIONS[:end])) == folded_state(replay(ACTIONS[:end]))


def test_an_action_more_costs_one_step_and_not_a_replay() -> None:
    papers = ReplayCache()
    before = papers.after(SQUARE, ACTIONS[:3])
    papers.after(SQUARE, ACTIONS)
    assert papers.after(SQUARE, ACTIONS[:3]) is before


def test_papers_that_were_dropped_are_made_again() -> None:
    papers = ReplayCache(size=1)
    papers.after(SQUARE, ACTIONS)
    assert folded_state(papers.after(SQUARE, ACTIONS[:2])) == folded_state(replay(ACTIONS[:2]))


def test_sheets_of_other_sizes_are_kept_apart() -> None:
    papers = ReplayCache()
    assert papers.after(SQUARE, ACTIONS).sheet != papers.after((2.0, 1.0), ACTIONS).sheet


def test_a_refused_action_leaves_nothing_behind() -> None:
    papers = ReplayCache()
    impossible = (*ACTIONS, Fold(edge=(1, 99), direction=1))
    for _ in range(2):
        with pytest.raises(ActionRefused):
            papers.after(SQUARE, impossible)


def test_a_fold_moves_one_side_and_makes_a_face() -> None:
    before = replay(ACTIONS[:2])
    made = state_difference(before, replay(ACTIONS[:3]))
    assert made.new_vertices == []
    assert len(made.new_faces) == 1
    assert len(made.moved_faces) == 1


def test_a_turn_moves_every_face_and_a_new_vertex_none() -> None:
    flat = new_paper()
    assert state_difference(flat, replay([Rotate(angle=10)])).moved_faces == [1]
    assert state_difference(flat, replay(ACTIONS[:1])) == ([5], [], [])


def test_undoing_a_fold_makes_nothing_new() -> None:
    folded, flat = replay(ACTIONS[:3]), replay(ACTIONS[:2])
    assert state_difference(folded, flat).new_faces == []
    assert state_difference(folded, flat).new_vertices == []
