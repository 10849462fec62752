"""The programs printed in the paper's figures, and programs with the final state that is known of them, replayed."""

import json
from math import dist
from pathlib import Path
from typing import Any

import pytest
from folding_schemas.actions import Action, Program
from folding_server.geometry.line import Point
from folding_server.simulator import Paper, apply, new_paper, overlapping_pairs
from known_results import BEYOND, FROZEN, PROGRAMS, final_state, folded_plainly, placed_actions, program
from papers import FIGURES, RESULTS, states
from pydantic import TypeAdapter

ROUNDING = 2e-3
ALIKE = sorted({path.stem for path in PROGRAMS.glob("*.json")} - BEYOND - set(FROZEN))
ACTION: TypeAdapter[Action] = TypeAdapter(Action)
KINDS = {"B": "boundary", "F": "flat", "M": "folded", "V": "folded"}


def vertex_at(paper: Paper, place: list[float]) -> int:
    """The vertex nearest to a place on the sheet."""
    return min(paper.vertices_coords, key=lambda v: dist(paper.vertices_coords[v], place))


def replay_recorded(actions: list[dict[str, object]]) -> Paper:
    """Apply recorded actions with the ends of each edge resolved by their place on the sheet."""
    paper = new_paper()
    for recorded in actions:
        action = {key: value for key, value in recorded.items() if key != "at"}
        if "at" in recorded:
            action["edge"] = [vertex_at(paper, place) for place in recorded["at"]]
        paper = apply(paper, ACTION.validate_python(action))
    return paper


def middle(paper: Paper, face: int) -> Point:
    """The mean of a face's vertices on the sheet."""
    points = paper.sheet_polygon(face)
    return sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points)


def face_at(paper: Paper, place: list[float]) -> int:
    """The face whose mean is nearest to a place on the sheet."""
    return min(paper.faces, key=lambda f: dist(middle(paper, f), place))


@pytest.mark.parametrize("path", FIGURES, ids=lambda p: p.stem)
def test_figure_programs_run_verbatim_and_make_the_printed_vertices(path: Path) -> None:
    figure = json.loads(path.read_text())
    program = Program(steps=figure["steps"])
    paper = new_paper()
    for step, expected in zip(program.steps, figure["new_vertices"], strict=True):
        before = set(paper.vertices_coords)
        for action in step:
            paper = apply(paper, action)
        assert sorted(set(paper.vertices_coords) - before) == expected


@pytest.mark.parametrize("path", RESULTS)
def test_known_results_reproduce_their_final_state(path: Path) -> None:
    recorded = json.loads(path.read_text())
    assert_state(replay_recorded(recorded["actions"]), recorded["final"])


@pytest.mark.parametrize("name", ALIKE)
def test_programs_lead_to_what_a_folder_that_shares_no_code_finds(name: str) -> None:
    given = program(name)
    assert_state(states(given)[-1], final_state(folded_plainly(placed_actions(given))))


def assert_state(paper: Paper, final: dict[str, Any]) -> None:
    """The paper has these vertices, creases, sides up and layers, all told by their places on the flat sheet."""
    assert len(paper.vertices_coords) == len(final["vertices"])
    for vertex in final["vertices"]:
        v = vertex_at(paper, vertex["sheet"])
        assert dist(paper.vertices_coords[v], vertex["sheet"]) < ROUNDING
        assert dist(paper.folded_vertices_coords[v], vertex["folded"]) < ROUNDING

    edges = {
        tuple(sorted(vertex_at(paper, end) for end in edge["sheet"])): edge["kind"] for edge in final["edges"]
    }
    assert {edge: KINDS[letter] for edge, letter in paper.edges()} == edges

    assert {f for f in paper.faces if not paper.back_up(f)} == {face_at(paper, c) for c in final["front_up"]}
    over = {(face_at(paper, lower), face_at(paper, upper)) for upper, lower in final["over"]}
    assert set(overlapping_pairs(paper)) == over
