"""Plans that a photo cannot tell apart: the photos after it are explained from each, as far as it takes."""

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

from folding_schemas.actions import AddVertex, Flip, Fold, Rotate
from folding_server.geometry.isometry import IDENTITY
from folding_server.simulator import Paper, apply, new_paper
from folding_server.vision.solver.look_ahead import DECIDED, MOST_AHEAD, TIE_NOTHING, behind, tied_plans
from folding_server.vision.solver.plan import Plan
from folding_server.vision.solver.same_model import same_model

LAID, TURNED = new_paper(), apply(new_paper(), Flip(axis="x"))


def plan(paper: Paper, agreement: float) -> Plan:
    """A plan that needs no action."""
    return Plan((), "none", paper, IDENTITY, agreement, "")


TIED = [plan(LAID, 0.98), plan(TURNED, 0.98)]


def following(agreements: dict[tuple[bool, int], float], asked: list[int]) -> Callable[[Paper, int], Plan]:
    """Explanations of the photos to come: by whether the sheet was turned over, and the photo; others explain it all."""

    def explain(paper: Paper, frame: int) -> Plan:
        asked.append(frame)
        return plan(paper, agreements.get((paper == TURNED, frame), 1.0))

    return explain


def ahead(frame: int, last: int, explain: Callable[[Paper, int], Plan]) -> list[float]:
    """How far the tied plans fall behind if a thorough look finds no more than a quick one."""
    return behind(TIED, frame, last, explain, explain)


def test_a_photo_that_nothing_usual_explains_is_looked_at_thoroughly() -> None:
    quick = following({(False, 3): 0.7, (True, 3): 0.8}, [])
    lost = behind(TIED, 2, 3, quick, following({(True, 3): 0.9}, []))
    assert [round(x, 6) for x in lost] == [0.0, 0.1]


def test_the_next_photo_decides_where_it_can() -> None:
    asked: list[int] = []
    lost = ahead(2, 9, following({(True, 3): 0.9}, asked))
    assert [round(x, 6) for x in lost] == [0.0, 0.1]
    assert set(asked) == {3}


def test_what_the_next_photo_leaves_open_a_later_one_decides() -> None:
    asked: list[int] = []
    assert ahead(2, 9, following({(False, 4): 0.8}, asked))[1] == 0.0
    assert set(asked) == {3, 4}


def test_small_differences_add_up_until_they_decide() -> None:
    little = 0.6 * DECIDED
    lost = ahead(2, 9, following({(True, 3): 1 - little, (True, 4): 1 - little}, []))
    assert round(lost[1], 6) == round(2 * little, 6)


def test_strips_along_borders_count_less_than_a_patch_as_large() -> None:
    little = 0.6 * DECIDED

    def explaining(patch: float) -> Callable[[Paper, int], Plan]:
        def explain(paper: Paper, _: int) -> Plan:
            wrong = paper == TURNED
            seen = plan(paper, 1 - little if wrong else 1.0)
            return seen.noting(own_camera=1.0, own_camera_residual=patch if wrong else 0.0)

        return explain

    strips, patch = (behind(TIED, 2, 3, explaining(x), explaining(x))[1] for x in (0.0, little))
    assert 0 < strips < 0.5 * little
    assert patch > little


def test_no_more_photos_are_looked_at_than_there_are_or_than_is_worth_it() -> None:
    asked: list[int] = []
    assert ahead(2, 3, following({}, asked)) == [0.0, 0.0]
    assert set(asked) == {3}
    assert ahead(2, 2, following({}, [])) == [0.0, 0.0]
    ahead(2, 99, following({}, asked))
    assert max(asked) == 2 + MOST_AHEAD


def letter(*folds: Fold) -> Paper:
    """A sheet with marks at two fifths and three fifths of two sides, folded along them."""
    paper = new_paper()
    for edge, place in (((1, 2), 0.4), ((4, 3), 0.4), ((5, 2), 1 / 3), ((6, 3), 1 / 3)):
        paper = apply(paper, AddVertex(edge=edge, position=place))
    for fold in folds:
        paper = apply(paper, fold)
    return paper


def test_one_model_under_other_names_is_the_same_and_one_with_other_layers_is_not() -> None:
    left, right = Fold(edge=(5, 6), direction=-1), Fold(edge=(7, 8), direction=1)
    first, other = letter(left, right), letter(right, left)
    assert same_model(apply(apply(first, Flip(axis="x")), Rotate(angle=180)), apply(first, Flip(axis="y")))
    assert not same_model(apply(first, Flip(axis="x")), first)
    assert not same_model(first, other)


def halved(direction: Literal[1, -1]) -> Paper:
    """A triangle, halved by folding one of its ends on the other."""
    triangle = apply(new_paper(), Fold(edge=(1, 3), direction=-1))
    return apply(
        apply(triangle, AddVertex(edge=(1, 3), position=0.5)), Fold(edge=(5, 2), direction=direction)
    )


def test_a_free_camera_sees_one_model_from_any_side_but_other_joints_are_another_model() -> None:
    one, other = halved(1), halved(-1)
    turned = apply(one, Rotate(angle=90))
    assert not same_model(one, turned)
    assert same_model(one, turned, turned=True)
    assert not same_model(one, other, turned=True)


def test_a_hidden_fold_is_looked_ahead_from_only_where_nothing_seems_to_have_happened() -> None:
    fold = Fold(edge=(1, 3), direction=1)
    hidden = Plan((fold,), "fold", apply(new_paper(), fold), IDENTITY, 0.98, "")
    nothing = plan(new_paper(), hidden.score + 0.8 * TIE_NOTHING - plan(new_paper(), 0.0).score)
    assert tied_plans([nothing, hidden]) == [nothing, hidden]
    turned = replace(nothing, actions=(Rotate(angle=90),), action_class="rotate")
    turned = replace(turned, agreement=turned.agreement + hidden.score + 0.8 * TIE_NOTHING - turned.score)
    assert tied_plans([turned, hidden]) == [turned]
