"""The solver on photographs of a sailboat: painted ones, and ones that a person took with a camera in the hand."""

from functools import cache
from pathlib import Path

import pytest
from folding_schemas.actions import AddVertex, Fold
from folding_server.frames.sequences import load_sequence
from folding_server.photographer import photograph
from folding_server.simulator import new_paper
from folding_server.vision.seeing import see_sequence
from folding_server.vision.solver import Plan, propose
from photographed import SAILBOAT, SIZE, photos
from reference_data import REFERENCE


@pytest.fixture(
    params=["photographed", pytest.param("taken", marks=pytest.mark.reference("photos/sailboat"))],
)
def plans(request: pytest.FixtureRequest) -> list[Plan]:
    """What is proposed first for each photo of a sailboat after the sheet."""
    return proposed(photos() if request.param == "photographed" else REFERENCE / "photos")


@cache
def proposed(folder: Path) -> list[Plan]:
    """The plans for the photos in a folder, made once."""
    observer, paper, found = see_sequence(load_sequence(folder / "sailboat")), new_paper(), []
    for frame in (2, 3, 4):
        found.append(propose(paper, observer, frame)[0])
        paper = found[-1].paper
    return found


@pytest.mark.slow
def test_a_fold_meant_to_be_along_the_diagonal_is(plans: list[Plan]) -> None:
    assert plans[0].actions == (Fold(edge=(2, 4), direction=1),)


@pytest.mark.slow
def test_an_edge_is_folded_onto_an_edge(plans: list[Plan]) -> None:
    added, fold = plans[1].actions
    assert isinstance(added, AddVertex)
    assert added.position == pytest.approx(2 - 2**0.5, abs=1e-6)
    assert isinstance(fold, Fold)


@pytest.mark.slow
def test_the_hull_is_one_fold(plans: list[Plan]) -> None:
    assert [action.action for action in plans[2].actions].count("fold") == 1
    assert plans[2].agreement > 0.97


@pytest.mark.slow
def test_photos_framed_anew_of_a_sheet_with_earlier_creases_are_followed(tmp_path: Path) -> None:
    photograph(SAILBOAT, tmp_path / "sailboat", 22, 4, SIZE)
    diagonal, side, hull = proposed(tmp_path)
    assert diagonal.actions == (Fold(edge=(2, 4), direction=1),)
    added, fold = side.actions
    assert isinstance(added, AddVertex)
    assert added.position == pytest.approx(2 - 2**0.5, abs=1e-6)
    assert isinstance(fold, Fold)
    assert [action.action for action in hull.actions] == ["add_vertex", "add_vertex", "fold"]
    places = sorted(action.position for action in hull.actions if isinstance(action, AddVertex))
    assert places == pytest.approx([0.78, 0.78], abs=0.02)
