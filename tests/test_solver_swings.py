"""The images between two photos tell plans apart that look alike when all is done."""

from dataclasses import replace

import pytest
from films import film, halves
from folding_server.simulator import Paper, apply, flip, fold
from folding_server.simulator.plane_geometry import IDENTITY
from folding_server.vision.motion import movement
from folding_server.vision.seeing import see_sequence
from folding_server.vision.solver import propose
from folding_server.vision.solver.plan import Plan, best_first
from folding_server.vision.solver.swings import contradiction, watched


@pytest.fixture(scope="module")
def right_part_lifted() -> Paper:
    """The sheet folded as the film shows it: the right part over the left."""
    return fold(halves(), (5, 6), 1)


def test_the_side_that_was_lifted_agrees_with_its_fold(right_part_lifted: Paper) -> None:
    shown = movement(see_sequence(film()), film().frame_count)
    assert shown is not None
    seen = watched(shown, IDENTITY)
    truth = contradiction(halves(), right_part_lifted, seen)
    other_side = contradiction(halves(), fold(halves(), (5, 6), -1), seen)
    turned_over = contradiction(halves(), flip(halves(), "x"), seen)
    nothing = contradiction(halves(), halves(), seen)
    assert truth < 0.1
    assert min(other_side, turned_over, nothing) > truth + 0.1


def test_of_two_plans_that_look_alike_the_one_that_moves_what_moved_comes_first(
    right_part_lifted: Paper,
) -> None:
    shown = movement(see_sequence(film()), film().frame_count)
    assert shown is not None
    seen = watched(shown, IDENTITY)
    papers = {"right": right_part_lifted, "left": fold(halves(), (5, 6), -1)}
    plans = [Plan((), "fold", paper, IDENTITY, 0.99, name) for name, paper in papers.items()]
    judged = [replace(plan, swing=contradiction(halves(), plan.paper, seen)) for plan in reversed(plans)]
    assert best_first(judged)[0].explanation == "right"


def test_proposals_take_the_images_in_between_into_account(right_part_lifted: Paper) -> None:
    best, *others = propose(halves(), see_sequence(film()), film().frame_count, 3)
    assert best.action_class == "fold"
    assert best.swing < 0.1
    assert all(best.swing <= other.swing + 0.1 for other in others)
    found = halves()
    for action in best.actions:
        found = apply(found, action)
    assert sorted(map(found.back_up, found.faces)) == sorted(
        map(right_part_lifted.back_up, right_part_lifted.faces)
    )
