"""What a model asks of paper and hands: thick bends, small flaps, errors that add up."""

import json
from math import pi

import pytest
from commands_here import run_here
from folding_schemas.actions import AddVertex, Fold, Program
from folding_server.instructions.moves import lesson_of
from folding_server.instructions.practicality import PaperStock, corner_error, fold_demands
from folding_server.interchange.programs import load_published
from paths import EXAMPLES

HALVES = Program(
    steps=(
        (
            AddVertex(edge=(1, 2), position=0.5),
            AddVertex(edge=(4, 3), position=0.5),
            Fold(edge=(5, 6), direction=1),
        ),
        (
            AddVertex(edge=(1, 5), position=0.5),
            AddVertex(edge=(4, 6), position=0.5),
            Fold(edge=(7, 8), direction=1),
        ),
    )
)


def test_layers_flaps_and_bends_are_those_of_the_folds() -> None:
    first, second = fold_demands(lesson_of(HALVES), PaperStock(100, 0.1))
    assert (first.layers, second.layers) == (1, 2)
    assert (first.flap, second.flap) == (pytest.approx(50), pytest.approx(25))
    assert (first.bend, second.bend) == (pytest.approx(pi * 0.1), pytest.approx(pi * 0.2))
    assert not first.too_thick and not second.too_small


def test_thick_paper_and_small_paper_are_told() -> None:
    demands = fold_demands(lesson_of(HALVES), PaperStock(12, 0.6))
    assert [each.too_thick for each in demands] == [True, True]
    assert [each.too_small for each in demands] == [False, True]


def test_errors_of_folds_add_up_in_the_corner_that_is_named() -> None:
    """The fold in half moves what lies on the moved side by twice its own error at most where the line is moved at both ends."""
    one = Program(steps=HALVES.steps[:1])
    error = corner_error(lesson_of(one), PaperStock(100, 0.1, 0.5))
    assert error is not None and (error.moved, error.folds) == (2, 2)
    assert 0.5 <= error.usual <= error.worst <= 2.0


def test_no_error_no_deviation_and_twice_the_error_about_twice_as_much() -> None:
    lesson = lesson_of(load_published((EXAMPLES / "programs" / "cup.json").read_text()).program)
    small, large = (corner_error(lesson, PaperStock(150, 0.1, off)) for off in (0.2, 0.4))
    assert small is not None and large is not None
    assert large.worst == pytest.approx(2 * small.worst, rel=0.15)
    assert large.worst < 10


def test_the_command_says_it_in_sentences_and_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    cat = EXAMPLES / "programs" / "cat.json"
    said = run_here(capsys, "practicality", cat, "--paper", "5cm", "--thickness", "0.5mm")
    assert said.code == 0
    assert "layers at once" in said.out and "0.5 mm off" in said.out
    report = json.loads(run_here(capsys, "practicality", cat, "--json").out)
    assert {each["step"] for each in report["folds"]} == {2, 3, 4, 5, 6}
    refused = run_here(capsys, "practicality", cat, "--paper", "huge")
    assert refused.code != 0 and "'huge'" in refused.err and "150mm" in refused.err
