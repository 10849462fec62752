"""Validators: real papers pass, and each kind of impossible paper is named for what is wrong with it."""

import ast
import json
from dataclasses import replace
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
import shapely
from folding_schemas.actions import Program
from folding_server.geometry.isometry import Isometry
from folding_server.interchange.programs import load_recorded, resolved
from folding_server.simulator import (
    Paper,
    add_vertex,
    apply,
    flip,
    fold,
    new_paper,
    overlapping_pairs,
    rotate,
    unfold,
    validity,
)
from folding_server.simulator.foldability import check_paper
from folding_server.simulator.validity import violations
from folding_server.simulator.validity.contacts import common_stretch, meet_across
from papers import FIGURES, RESULTS


def kinds(paper: Paper) -> set[str]:
    return {found.kind for found in violations(paper)}


def book() -> Paper:
    """A square folded in half: face 1 below, face 2 on top; edge 5-6 is the spine."""
    paper = add_vertex(add_vertex(new_paper(), (1, 2), 0.5), (4, 3), 0.5)
    return fold(paper, (5, 6), 1)


def quarter() -> Paper:
    """A square folded in half twice: four faces, one vertex in the middle."""
    paper = add_vertex(add_vertex(book(), (1, 4), 0.5), (5, 6), 0.5)
    return fold(paper, (7, 8), 1)


def pleat() -> Paper:
    """Three panels of width 0.3, 0.2 and 0.5, folded to and fro: the last reaches past both creases."""
    paper = add_vertex(add_vertex(new_paper(), (1, 2), 0.3), (4, 3), 0.3)
    paper = add_vertex(add_vertex(paper, (5, 2), 2 / 7), (6, 3), 2 / 7)
    return fold(fold(paper, (7, 8), 1), (5, 6), 1)


def test_the_validators_share_no_code_with_what_they_check():
    """They import the record alone, beside the names of array types, and of it call nothing but its assignments."""
    folder = Path(validity.__file__).parent
    sources = {file.name: ast.parse(file.read_text()) for file in folder.glob("*.py")}
    imported = {
        (node.module, name.name)
        for tree in sources.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and "validity" not in str(node.module)
        for name in node.names
        if str(node.module).startswith("folding_")
    }
    code = {(module, name) for module, name in imported if module != "folding_server.arrays"}
    assert code == {("folding_server.simulator.paper", "Paper")}
    fields = set(Paper.__dataclass_fields__)
    read = {
        node.attr
        for tree in sources.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) in {"paper", "sheet.paper"}
    }
    assert read - fields == {"edges"}


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: path.stem)
def test_every_state_of_the_published_figures_is_valid(path):
    steps = json.loads(path.read_text())["steps"]
    paper = new_paper()
    for action in (a for step in Program.model_validate({"steps": steps}).steps for a in step):
        paper = apply(paper, action)
        assert violations(paper) == []


@pytest.mark.parametrize("path", RESULTS)
def test_every_state_of_the_known_results_is_valid_and_the_last_folds_flat(path):
    paper = new_paper()
    for recorded in load_recorded(path.read_text()).actions:
        paper = apply(paper, resolved(paper, recorded))
        assert violations(paper) == []
    report = check_paper(paper)
    assert report.foldable
    assert violations(replace(paper, order=report.stack)) == []


@pytest.mark.parametrize("make", [new_paper, book, quarter, pleat])
def test_simple_models_are_valid_turned_flipped_and_unfolded(make):
    paper = make()
    assert violations(paper) == []
    assert violations(flip(rotate(paper, 33.0), "y=x")) == []
    if paper.folds:
        assert violations(unfold(paper)) == []


def test_a_rectangle_is_a_sheet_too():
    assert violations(fold(new_paper((2.0, 1.0)), (1, 3), 1)) == []
    assert kinds(replace(new_paper(), sheet=(2.0, 1.0))) >= {"area", "tiling"}


def test_a_face_left_out_of_the_stack_is_a_broken_record():
    assert kinds(replace(book(), order=(1, 1))) == {"record"}


def test_an_unknown_vertex_is_a_broken_record():
    assert kinds(replace(new_paper(), faces={1: (1, 2, 3, 9)})) == {"record"}


def test_a_vertex_on_no_face_is_a_broken_record():
    paper = new_paper()
    assert kinds(replace(paper, vertices_coords={**paper.vertices_coords, 5: (0.5, 0.5)})) == {"record"}


def test_a_stretched_face_is_no_isometry():
    paper = book()
    stretched = Isometry(1.001, 0.0, 0.0, 1.0, 0.0, 0.0)
    (found,) = violations(replace(paper, isometries={**paper.isometries, 1: stretched}))
    assert (found.kind, found.faces) == ("isometry", (1,))


def test_a_corner_pulled_off_the_sheet_is_named_by_its_edges():
    paper = new_paper()
    found = violations(replace(paper, vertices_coords={**paper.vertices_coords, 2: (1.1, 1.0)}))
    assert {v.kind for v in found} == {"area", "tiling"}
    assert {(1, 2), (2, 3)} & {edge for v in found for edge in v.edges}


def test_a_dented_face_is_not_convex():
    paper = add_vertex(new_paper(), (1, 2), 0.5)
    dented = replace(paper, vertices_coords={**paper.vertices_coords, 5: (0.5, 0.9)})
    assert any("convex" in v.detail for v in violations(dented))


def test_edges_that_cross_are_not_planar():
    paper = quarter()
    moved = replace(paper, vertices_coords={**paper.vertices_coords, 8: (1.3, 0.5)})
    assert "planar" in kinds(moved)


def test_two_faces_on_one_side_of_an_edge_do_not_tile():
    paper = book()
    assert "tiling" in kinds(replace(paper, faces={**paper.faces, 2: paper.faces[2][::-1]}))


def test_a_face_torn_off_disagrees_on_its_vertices():
    paper = book()
    away = Isometry(1.0, 0.0, 0.0, 1.0, 0.01, 0.0).after(paper.isometries[2])
    found = violations(replace(paper, isometries={**paper.isometries, 2: away}))
    assert {v.vertices for v in found if v.kind == "agreement"} == {(5,), (6,)}


def test_a_wrong_letter_breaks_parity_only_if_it_hides_a_fold():
    class Mislabelled(Paper):
        def edge_assignment(self, edge):
            return {"V": wrong}.get(super().edge_assignment(edge), super().edge_assignment(edge))

    paper = Mislabelled(**{name: getattr(book(), name) for name in Paper.__dataclass_fields__})
    wrong = "M"
    assert kinds(paper) == {"letter"}
    wrong = "F"
    assert kinds(paper) == {"letter", "parity"}


def test_of_24_stacks_of_a_quartered_sheet_the_eight_possible_ones_pass():
    paper = quarter()
    results = [kinds(replace(paper, order=stack)) for stack in permutations(paper.order)]
    assert results.count(set()) == 8
    assert all(found == {"Maekawa", "taco-taco"} for found in results if found)


def test_a_vertex_off_its_place_breaks_kawasaki():
    paper = quarter()
    assert "Kawasaki" in kinds(replace(paper, vertices_coords={**paper.vertices_coords, 8: (0.55, 0.6)}))


def test_a_long_panel_inside_a_fold_it_reaches_out_of_crosses_it():
    paper = pleat()
    first, second, third, last = paper.order
    assert kinds(replace(paper, order=(first, third, second, last))) == {"taco-tortilla"}


def test_a_flat_crease_woven_through_another_crosses_it():
    paper = unfold(quarter())
    assert violations(paper) == []
    (lower, upper) = next(pair for pair in overlapping_pairs(paper))
    swapped = {lower: upper, upper: lower}
    woven = replace(paper, order=tuple(swapped.get(face, face) for face in paper.order))
    assert kinds(woven) == {"Maekawa", "tortilla-tortilla"}


def test_a_fold_around_half_of_a_flat_pair_crosses_it():
    """A strip of four panels: a mark, a fold back over the second, and a fold with its spine along the mark."""
    paper = add_vertex(add_vertex(new_paper((4.0, 1.0)), (1, 2), 0.25), (4, 3), 0.25)
    paper = unfold(fold(paper, (5, 6), 1))
    paper = add_vertex(add_vertex(paper, (5, 2), 1 / 3), (6, 3), 1 / 3)
    paper = fold(paper, (7, 8), 1)
    paper = add_vertex(add_vertex(paper, (7, 2), 0.5), (8, 3), 0.5)
    paper = fold(paper, (9, 10), -1)
    assert violations(paper) == []
    first, second, third, last = paper.order
    assert kinds(replace(paper, order=(first, third, second, last))) == {"taco-tortilla"}


def test_a_sliver_thinner_than_the_slack_has_no_place_in_the_stack():
    paper = add_vertex(add_vertex(new_paper(), (1, 2), 0.5), (4, 3), 0.5)
    paper = add_vertex(add_vertex(paper, (5, 2), 0.0003), (6, 3), 0.0003)
    paper = fold(paper, (5, 6), 1)
    assert violations(paper) == []


def test_faces_are_measured_where_the_edges_meet():
    """A wedge a thousandth of a radian wide is thick at its far end and nothing at its tip."""
    wedge = shapely.Polygon([(0.0, 0.0), (1.0, 0.0), (1.0, 0.005)])
    square = shapely.box(0.0, 0.0, 1.0, 1.0)
    for start, thick in ((0.0, False), (0.9, True)):
        stretch = common_stretch(
            np.array([(0.0, 0.0), (1.0, 0.0)]), np.array([(start + 0.05, 1e-5), (start, 0.0)])
        )
        assert stretch == pytest.approx(np.array([(start, 0.0), (start + 0.05, 0.0)]))
        assert meet_across(np.array([wedge, square]), stretch, 5e-4) == thick


def test_a_stack_in_the_wrong_order_is_found_beside_slivers_too():
    """A sheet with a sliver along a flat crease, halved across both: every layer swapped with its neighbour crosses."""
    paper = add_vertex(add_vertex(new_paper(), (1, 2), 0.5), (4, 3), 0.5)
    paper = fold(add_vertex(unfold(fold(paper, (5, 6), 1)), (6, 3), 0.003), (5, 7), 1)
    paper = fold(add_vertex(add_vertex(paper, (1, 4), 0.5), (6, 5), 0.5), (8, 9), 1)
    assert violations(paper) == []
    overlapping = set(overlapping_pairs(paper))
    for k, pair in enumerate(zip(paper.order, paper.order[1:], strict=False)):
        swapped = (*paper.order[:k], *reversed(pair), *paper.order[k + 2 :])
        assert bool(kinds(replace(paper, order=swapped))) == (pair in overlapping)
