"""What the solver weighs: named terms, each with a weight, a unit and a source, and all of them on the wire."""

from dataclasses import fields

import pytest
from contract import evidence_table, vision_numbers
from folding_schemas.actions import Flip, Rotate
from folding_server.geometry.isometry import IDENTITY
from folding_server.mcp.services.presenters import proposals
from folding_server.simulator import apply, new_paper
from folding_server.vision.evidence import Evidence, terms
from folding_server.vision.solver.plan import Plan


def plan(**noted: float) -> Plan:
    """A plan that turns a sheet over."""
    flip = Flip(axis="x")
    return Plan((flip,), "flip", apply(new_paper(), flip), IDENTITY, 0.97, "turned over").noting(**noted)


def test_every_term_has_a_weight_a_unit_and_a_source() -> None:
    assert list(terms()) == [field.name for field in fields(Evidence)]
    assert all(term.weight and term.unit and term.source and term.words for term in terms().values())


def test_the_score_is_the_sum_of_what_the_terms_add() -> None:
    seen = plan(inner_lines=0.5, tilt=0.25)
    added = seen.evidence.contributions
    values = {"agreement": 0.97, "flips": 1, "inner_lines": 0.5, "tilt": 0.25}
    assert added == pytest.approx({name: terms()[name].weight * value for name, value in values.items()})
    assert seen.score == pytest.approx(sum(added.values()))


def test_a_term_that_does_not_exist_is_refused() -> None:
    with pytest.raises(TypeError, match="beauty"):
        plan(beauty=1.0)


def test_actions_speak_for_themselves() -> None:
    both = (Flip(axis="y=x"), Rotate(angle=90))
    told = Plan(both, "compound", new_paper(), IDENTITY, 1.0, "").evidence
    assert (told.flips, told.diagonal_flips, told.rotations, told.several_creasing_actions) == (1, 1, 1, 0)


def test_a_proposal_says_what_each_term_adds_to_its_score() -> None:
    (told,) = proposals([plan(roll=0.5)])
    assert sum(told.evidence.values()) == pytest.approx(told.score, abs=2e-4)
    assert told.evidence["roll"] < 0


def test_the_page_about_the_solver_has_the_weights_as_they_are() -> None:
    text = evidence_table.FILE.read_text(encoding="utf-8")
    assert evidence_table.page(text) == text, "run tests/contract/evidence_table.py and commit its result"


def test_the_page_of_numbers_has_them_as_they_are_and_says_what_each_means() -> None:
    written = vision_numbers.FILE.read_text(encoding="utf-8")
    assert written == vision_numbers.page(), "run tests/contract/vision_numbers.py and commit its result"
    assert not [row for row in written.splitlines() if row.endswith("|  |")]
