"""What evaluation is told of a state: through the protocol, and of patterns whose answers are known."""

import json
from pathlib import Path
from typing import Any

import pytest
from evaluated import example_states
from folding_schemas.actions import AddVertex, Fold
from folding_schemas.state_measures import StateMeasures
from folding_server.interchange.fold_format import fold_document
from folding_server.measuring.state_measuring import measured_model, measured_paper
from folding_server.measuring.stated_model import stated_model
from folding_server.simulator import Paper
from folding_server.simulator.apply import replay
from hosts import in_memory

HALVES = (
    AddVertex(edge=(1, 2), position=0.5),
    AddVertex(edge=(4, 3), position=0.5),
    Fold(edge=(5, 6), direction=1),
)
QUARTERS = (
    *HALVES,
    AddVertex(edge=(1, 4), position=0.5),
    AddVertex(edge=(5, 6), position=0.5),
    Fold(edge=(7, 8), direction=1),
)
GATE = (
    AddVertex(edge=(1, 2), position=0.25),
    AddVertex(edge=(4, 3), position=0.25),
    Fold(edge=(5, 6), direction=-1),
    AddVertex(edge=(5, 2), position=1 / 3),
    AddVertex(edge=(6, 3), position=1 / 3),
    Fold(edge=(7, 8), direction=1),
)
"""A quarter folded to the right, then the right half over it and beyond."""

FOLD_DIAGONAL = {"action": "fold", "edge": [4, 2], "direction": 1}


def counts(paper: Paper) -> tuple[int, int, int]:
    found = measured_paper(paper).constraints
    return found.taco_taco, found.taco_tortilla, found.transitivity


def test_a_sheet_in_quarters_has_a_pair_of_folds_on_each_side_and_four_threes_of_faces() -> None:
    assert counts(replay(QUARTERS)) == (2, 0, 4)


def test_a_face_that_spans_a_fold_is_one_condition() -> None:
    assert counts(replay(GATE)) == (0, 1, 1)


def test_a_flat_sheet_has_no_conditions() -> None:
    assert counts(replay(())) == (0, 0, 0)


def test_vertices_that_can_lie_flat_are_counted_by_their_creases() -> None:
    found = measured_paper(replay(QUARTERS))
    assert found.locally_flat == 1
    document = pattern(found)
    inner = next(i for i, letter in enumerate(document["edges_assignment"]) if letter in "MV")
    document["edges_assignment"][inner] = {"M": "V", "V": "M"}[document["edges_assignment"][inner]]
    assert measured_model(stated_model(document)).locally_flat == 0


def pattern(measured: StateMeasures) -> dict[str, Any]:
    """The crease pattern alone, as a FOLD file that another program might write."""
    told = measured.model_dump(mode="json")
    names = ("vertices_coords", "edges_vertices", "edges_assignment", "faces_vertices")
    return {"frame_classes": ["creasePattern"], **{name: told[name] for name in names}}


def test_a_pattern_alone_is_folded_by_its_letters() -> None:
    paper = replay(QUARTERS)
    whole = measured_paper(paper)
    alone = measured_model(stated_model(pattern(whole)))
    assert alone.compiles
    assert alone.constraints == whole.constraints
    assert alone.folded_coords is not None
    xs, ys = zip(*alone.folded_coords, strict=True)
    assert max(xs) - min(xs) == max(ys) - min(ys) == pytest.approx(0.5)
    assert len(alone.over) == len(whole.over) == 6


def shifted(document: dict[str, Any]) -> dict[str, Any]:
    return document | {"vertices_coords": [[x + 0.5, y] for x, y in document["vertices_coords"]]}


def in_two_pieces(document: dict[str, Any]) -> dict[str, Any]:
    count = len(document["vertices_coords"])
    more = [[0.6, 0.6], [0.7, 0.6], [0.7, 0.7]]
    edges = [[count, count + 1], [count + 1, count + 2], [count + 2, count]]
    return document | {
        "vertices_coords": [*document["vertices_coords"], *more],
        "edges_vertices": [*document["edges_vertices"], *edges],
        "edges_assignment": [*document["edges_assignment"], "F", "F", "F"],
    }


def with_all_valleys(document: dict[str, Any]) -> dict[str, Any]:
    letters = ["V" if letter in "MV" else letter for letter in document["edges_assignment"]]
    return document | {"edges_assignment": letters}


@pytest.mark.parametrize(
    ("spoil", "problem"),
    [
        (shifted, "reaches from (0.5, 0) to (1.5, 1)"),
        (in_two_pieces, "in 2 pieces"),
        (with_all_valleys, "Maekawa"),
    ],
    ids=["off the square", "two pieces", "only valleys"],
)
def test_what_does_not_compile_says_why(spoil: Any, problem: str) -> None:
    found = measured_model(stated_model(spoil(pattern(measured_paper(replay(QUARTERS))))))
    assert not found.compiles
    assert problem in found.problem
    assert found.vertices_coords


def test_a_face_that_changes_its_shape_does_not_compile() -> None:
    document = fold_document(replay(HALVES))
    document["vertices_coords"][0][0] += 0.01
    found = measured_model(stated_model(document))
    assert "does not keep its shape" in found.problem


def test_every_state_of_an_example_compiles() -> None:
    assert all(measured.compiles for measured in example_states("cat"))


@pytest.mark.anyio
class TestTool:
    async def test_it_is_offered_only_for_evaluation(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            assert "measure_state" not in {tool.name for tool in (await host.client.list_tools()).tools}
        async with in_memory(tmp_path, for_evaluation=True) as host:
            assert "measure_state" in {tool.name for tool in (await host.client.list_tools()).tools}

    async def test_the_state_of_a_run_and_its_file_are_measured_alike(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, for_evaluation=True) as host:
            await host.call("open_run")
            await host.call("fold", edge=[4, 2], direction=1)
            file = (await host.call("export_state", format="fold"))["text"]
            assert await host.call("measure_state") == await host.call("measure_state", fold=file)

    async def test_a_file_that_is_none_is_refused_in_a_sentence(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, for_evaluation=True) as host:
            assert "is not JSON" in await host.refusal("measure_state", fold="{")
            assert "no vertices_coords" in await host.refusal("measure_state", fold=json.dumps({}))

    async def test_a_program_is_measured_on_the_sheet_that_it_gives(self, tmp_path: Path) -> None:
        uneven = {"name": "uneven", "sheet": [1, 0.99], "steps": [[FOLD_DIAGONAL]]}
        async with in_memory(tmp_path, for_evaluation=True) as host:
            found = StateMeasures.model_validate(await host.call("measure_state", program=uneven))
            assert found.compiles
            assert max(y for _, y in found.vertices_coords) == 0.99
            square = {**uneven, "sheet": [1, 1]}
            await host.call("open_run")
            await host.call("fold", edge=[4, 2], direction=1)
            assert await host.call("measure_state", program=square) == await host.call("measure_state")

    async def test_a_program_that_cannot_be_folded_and_two_states_are_refused(self, tmp_path: Path) -> None:
        twice = {"name": "twice", "steps": [[FOLD_DIAGONAL, FOLD_DIAGONAL]]}
        async with in_memory(tmp_path, for_evaluation=True) as host:
            assert "Step 1, action 2" in await host.refusal("measure_state", program=twice)
            assert "not both" in await host.refusal("measure_state", program=twice, fold="{}")
