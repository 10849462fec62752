"""Folds of one-coloured paper: label images alike before and after, found by what the light shows."""

from collections.abc import Sequence
from dataclasses import replace

import pytest
from exactness import exactness
from folding_schemas.actions import Action, AddVertex, Fold
from folding_server.geometry.isometry import IDENTITY, Isometry, turn
from folding_server.simulator import Paper, apply, replay
from folding_server.simulator.state_diff import origins
from folding_server.vision.labels import as_one_colour
from folding_server.vision.registration.scene import Views
from folding_server.vision.solver.differences import Differences
from folding_server.vision.solver.plan import Plan
from folding_server.vision.solver.same_colour_folds import SameColourFolds
from folding_server.vision.solver.transition import explain
from label_views import lit_scene, views

BOOK: tuple[Action, ...] = (
    AddVertex(edge=(1, 2), position=0.5),
    AddVertex(edge=(3, 4), position=0.5),
    Fold(edge=(5, 6), direction=1),
)
"""A sheet folded in half like a book."""
CORNER: tuple[Action, ...] = (
    AddVertex(edge=(2, 5), position=0.4),
    AddVertex(edge=(2, 3), position=0.25),
    Fold(edge=(7, 8), direction=1),
)
"""A corner of its upper page folded inwards."""
LATER = turn(1.5, (0.5, 0.5))
"""How the sheet has drifted when the second photo is taken."""
MOVED_ON = Isometry(1, 0, 0, 1, 0.03, 0.01).after(LATER)
"""Where the pattern lies if other paper is seen there."""


def done(paper: Paper, actions: Sequence[Action]) -> Paper:
    for action in actions:
        paper = apply(paper, action)
    return paper


def differences(paper: Paper, after: Paper, slope: float = 0.0) -> Differences:
    """Two photos, the second of ``after``, seen with the knowledge of ``paper`` alone."""
    return Differences(
        paper, lit_scene(paper, IDENTITY, 1), IDENTITY, lit_scene(after, LATER, 2, slope), LATER
    )


def one_coloured(after: Paper, before: Paper) -> Views:
    """Two views of a paper whose sides look alike, and both photos at their finest."""
    seen = views(after)
    alike = [replace(s, labels=as_one_colour(s.labels), two_coloured=False) for s in (seen.coarse, seen.fine)]
    photos = lit_scene(before, IDENTITY, 1), lit_scene(after, IDENTITY, 2)
    return replace(seen, coarse=alike[0], fine=alike[1], closely=lambda: photos)


def best(before: Paper, after: Paper) -> Plan:
    return explain(before, IDENTITY, one_coloured(after, before))[0]


def corner_folded() -> tuple[Paper, Paper]:
    book = replay(BOOK)
    return book, done(book, CORNER)


def test_the_corner_of_a_page_is_folded_within_one_colour() -> None:
    book, folded = corner_folded()
    same = as_one_colour(views(book).fine.labels) == as_one_colour(views(folded).fine.labels)
    assert same.all()


@pytest.mark.slow
def test_a_fold_within_one_colour_is_found_by_the_light() -> None:
    book, folded = corner_folded()
    plan = best(book, folded)
    assert plan.action_class == "fold"
    assert plan.noted.explained_change > 0.25
    assert exactness(folded, plan.paper).holds()


@pytest.mark.slow
def test_without_a_closer_look_nothing_is_found() -> None:
    book, folded = corner_folded()
    blind = replace(one_coloured(folded, book), closely=None)
    assert explain(book, IDENTITY, blind)[0].noted.explained_change == 0


def test_light_that_changes_slowly_is_no_trace() -> None:
    book = replay(BOOK)
    seen = differences(book, book, slope=12.0)
    assert SameColourFolds(seen, seen.after).run() == []


def test_the_true_fold_leaves_least_unexplained() -> None:
    book, folded = corner_folded()
    seen = differences(book, folded)
    other = done(book, (*CORNER[:1], AddVertex(edge=(2, 3), position=0.5), CORNER[2]))
    assert seen.unexplained(folded) < 0.3 * seen.unexplained(book)
    assert seen.unexplained(folded) < seen.unexplained(other)


def test_every_face_knows_the_face_it_was_cut_from() -> None:
    book, folded = corner_folded()
    assert set(origins(book, folded)) == set(folded.faces)
    assert set(origins(book, folded).values()) == set(book.faces)
