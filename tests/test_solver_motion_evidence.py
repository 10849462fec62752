"""The images between two photos tell plans apart that look alike when all is done."""

import numpy as np
import pytest
from films import eyes_on_film, film_movement, halves
from folding_server.geometry.isometry import IDENTITY
from folding_server.simulator import Paper, apply, flip, fold, new_paper, rotate, unfold
from folding_server.vision.solver import propose
from folding_server.vision.solver.motion_evidence import WatchedPlaces, contradiction, watched_places
from folding_server.vision.solver.plan import Plan, best_first


@pytest.fixture(scope="module")
def right_part_lifted() -> Paper:
    """The sheet folded as the film shows it: the right part over the left."""
    return fold(halves(), (5, 6), 1)


@pytest.mark.slow
def test_the_side_that_was_lifted_agrees_with_its_fold(right_part_lifted: Paper) -> None:
    seen = watched_places(film_movement(), IDENTITY)
    truth = contradiction(halves(), right_part_lifted, seen)
    other_side = contradiction(halves(), fold(halves(), (5, 6), -1), seen)
    turned_over = contradiction(halves(), flip(halves(), "x"), seen)
    nothing = contradiction(halves(), halves(), seen)
    assert truth < 0.2
    assert min(other_side, turned_over, nothing) > truth + 0.4


@pytest.mark.slow
def test_of_two_plans_that_look_alike_the_one_that_moves_what_moved_comes_first(
    right_part_lifted: Paper,
) -> None:
    seen = watched_places(film_movement(), IDENTITY)
    papers = {"right": right_part_lifted, "left": fold(halves(), (5, 6), -1)}
    plans = [Plan((), "fold", paper, IDENTITY, 0.99, name) for name, paper in papers.items()]
    judged = [
        plan.noting(moved_otherwise=contradiction(halves(), plan.paper, seen)) for plan in reversed(plans)
    ]
    assert best_first(judged)[0].explanation == "right"


@pytest.mark.slow
def test_proposals_take_the_images_in_between_into_account(right_part_lifted: Paper) -> None:
    best, *others = propose(halves(), eyes_on_film(), 2, 3)
    assert best.action_class == "fold"
    assert best.noted.moved_otherwise < 0.2
    assert others
    assert all(best.noted.moved_otherwise <= other.noted.moved_otherwise + 0.1 for other in others)
    found = halves()
    for action in best.actions:
        found = apply(found, action)
    assert sorted(map(found.back_up, found.faces)) == sorted(
        map(right_part_lifted.back_up, right_part_lifted.faces)
    )


def test_the_table_seen_in_between_refutes_plans_that_leave_paper_there() -> None:
    paper = halves()
    middle = np.array([[0.8, 0.1 * k] for k in range(10)] * 3)
    bare, never = np.ones(len(middle), bool), np.zeros(len(middle), bool)
    seen = WatchedPlaces(middle, changed=bare, still=never, turned=never, bare=bare)
    assert contradiction(paper, fold(paper, (5, 6), 1), seen) == 0
    assert contradiction(paper, flip(paper, "x"), seen) == 0
    assert contradiction(paper, fold(paper, (5, 6), -1), seen) == 1
    assert contradiction(paper, paper, seen) == 1


def test_a_lower_layer_that_stays_hides_the_table() -> None:
    paper = fold(new_paper(), (1, 3), 1)
    places = np.array([[0.1 + 0.01 * k, 0.1] for k in range(30)])
    yes, no = np.ones(30, bool), np.zeros(30, bool)
    opened, over = unfold(paper), flip(paper, "x")
    assert (
        contradiction(paper, opened, WatchedPlaces(places, changed=yes, still=no, turned=yes, bare=no)) == 0
    )
    assert (
        contradiction(paper, opened, WatchedPlaces(places, changed=yes, still=no, turned=no, bare=yes)) == 1
    )
    assert contradiction(paper, over, WatchedPlaces(places, changed=yes, still=no, turned=no, bare=yes)) == 0


def test_paper_that_slides_may_look_the_same_but_never_shows_its_other_side() -> None:
    turned = rotate(new_paper(), 30)
    places = np.array([[0.4 + 0.01 * k, 0.4] for k in range(25)])
    yes, no = np.ones(25, bool), np.zeros(25, bool)
    assert (
        contradiction(new_paper(), turned, WatchedPlaces(places, changed=no, still=yes, turned=no, bare=no))
        == 0
    )
    assert (
        contradiction(new_paper(), turned, WatchedPlaces(places, changed=yes, still=no, turned=yes, bare=no))
        == 1
    )
    assert (
        contradiction(
            new_paper(),
            flip(new_paper(), "x"),
            WatchedPlaces(places, changed=no, still=yes, turned=no, bare=no),
        )
        == 1
    )


def test_a_turn_of_the_whole_paper_bares_the_table_at_its_corners() -> None:
    corners = np.array([[x + 0.005 * k, y] for x in (0.05, 0.92) for y in (0.05, 0.95) for k in range(6)])
    yes, no = np.ones(24, bool), np.zeros(24, bool)
    for degrees in (90, -90):
        turned = rotate(new_paper(), degrees)
        still = WatchedPlaces(corners, changed=no, still=yes, turned=no, bare=no)
        assert contradiction(new_paper(), turned, still) == 1
        assert contradiction(new_paper(), turned, WatchedPlaces(corners, yes, no, no, yes)) == 0


def test_a_turn_of_the_whole_paper_never_bares_its_middle() -> None:
    middle = np.array([[0.4 + 0.007 * k, 0.5] for k in range(30)])
    yes, no = np.ones(30, bool), np.zeros(30, bool)
    for degrees in (10, 90, 180):
        seen = WatchedPlaces(middle, changed=yes, still=no, turned=no, bare=yes)
        assert contradiction(new_paper(), rotate(new_paper(), degrees), seen) == 1
    assert contradiction(new_paper(), flip(new_paper(), "x"), seen) == 0


def test_few_watched_places_say_nothing() -> None:
    seen = WatchedPlaces(np.array([[0.5, 0.5]]), *(np.array([True]) for _ in range(4)))
    assert contradiction(new_paper(), new_paper(), seen) == 0
