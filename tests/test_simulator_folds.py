"""Folds and unfolds by example: which layers move, what is refused, and what the refusal names."""

from dataclasses import replace

import pytest
from folding_server.errors import ActionRefused
from folding_server.geometry.graph import Edge
from folding_server.interchange.fold_format import fold_document, fold_text
from folding_server.interchange.fold_reading import read_fold
from folding_server.interchange.obj import obj_text
from folding_server.simulator import Paper, add_vertex, flip, fold, folded_state, new_paper, rotate, unfold
from folding_server.simulator.plane_layers import layers_of_planes
from folding_server.simulator.validity import violations


def crease_across(
    paper: Paper, first: tuple[Edge, float], second: tuple[Edge, float], direction: int
) -> Paper:
    """Add a vertex on each of two edges and fold through them."""
    for edge, position in (first, second):
        paper = add_vertex(paper, edge, position)
    newest = max(paper.vertices_coords)
    return fold(paper, (newest - 1, newest), direction)


def half_folded() -> Paper:
    """The lower half of the square folded up: vertices 5 and 6 in the middle of the sides."""
    return crease_across(new_paper(), ((1, 4), 0.5), ((2, 3), 0.5), -1)


def test_a_fold_turns_one_side_over_on_top() -> None:
    paper = half_folded()
    assert paper.folded_vertices_coords[3] == pytest.approx((1.0, 1.0))
    assert [paper.back_up(face) for face in paper.order] == [False, True]
    assert {letter for _, letter in paper.edges()} == {"B", "V"}


def test_letters_belong_to_the_sheet_so_a_flip_keeps_them() -> None:
    paper = half_folded()
    assert dict(flip(paper, "x").edges()) == dict(paper.edges())


def test_a_positive_rotation_is_clockwise_about_the_mean_of_the_vertices() -> None:
    paper = rotate(new_paper(), 90)
    assert paper.folded_vertices_coords[1] == pytest.approx((1.0, 1.0))


def test_unfold_leaves_a_flat_crease_where_the_fold_was() -> None:
    paper = unfold(half_folded())
    assert dict(paper.edges())[(5, 6)] == "F"
    assert paper.folded_vertices_coords[3] == pytest.approx((1.0, 0.0))


def test_an_older_fold_unfolds_while_a_newer_one_stays() -> None:
    left = crease_across(new_paper(), ((1, 2), 0.2), ((3, 4), 0.8), -1)
    both = crease_across(left, ((5, 2), 0.75), ((3, 6), 0.25), 1)
    opened = unfold(both, (5, 6))
    assert opened.is_folded((7, 8))
    assert not opened.is_folded((5, 6))


def test_a_flap_on_the_underside_swings_under_the_bottom() -> None:
    turned = flip(crease_across(new_paper(), ((1, 2), 0.3), ((1, 4), 0.3), 1), "x")
    opened = unfold(turned)
    assert len(layers_of_planes(opened)) == 1
    assert all(opened.back_up(face) for face in opened.faces)


def test_a_flap_under_another_flap_is_held_and_the_refusal_names_what_holds_it() -> None:
    below = crease_across(new_paper(), ((1, 4), 0.4), ((2, 3), 0.4), -1)
    covered = crease_across(below, ((1, 5), 0.3), ((2, 6), 0.3), 1)
    with pytest.raises(ActionRefused, match=r"Fold 1 .*\[5, 6\].* face \d+ lies over it"):
        unfold(covered, (5, 6))
    assert unfold(unfold(covered), (5, 6)).folds == 2


def test_a_crease_bent_by_a_later_fold_is_not_unfolded_and_the_refusal_names_that_fold() -> None:
    slanted = crease_across(half_folded(), ((1, 2), 0.5), ((5, 6), 0.25), 1)
    with pytest.raises(ActionRefused, match=r"Fold 1 .* fold 2 .* has bent its crease"):
        unfold(slanted, (5, 6))


def test_a_flap_whose_tip_was_folded_since_swings_back_with_its_tip() -> None:
    corner = crease_across(new_paper(), ((1, 2), 0.5), ((1, 4), 0.5), 1)
    tipped = crease_across(corner, ((1, 5), 0.5), ((1, 6), 0.5), -1)
    opened = unfold(tipped, (5, 6))
    assert opened.is_folded((7, 8))
    assert not opened.is_folded((5, 6))
    assert violations(opened) == []


def test_a_fold_along_an_existing_mark_makes_no_new_vertex() -> None:
    marked = unfold(half_folded())
    assert set(fold(marked, (5, 6), 1).vertices_coords) == set(marked.vertices_coords)


def test_a_fold_along_a_folded_crease_lays_the_flap_back_and_leaves_a_mark() -> None:
    half = half_folded()
    back = fold(half, (5, 6), 1)
    assert dict(back.edges())[(5, 6)] == "F"
    assert all(
        back.folded_vertices_coords[v] == pytest.approx(place)
        for v, place in unfold(half).folded_vertices_coords.items()
    )
    assert set(back.faces) == set(half.faces)
    with pytest.raises(ActionRefused, match="Nothing is folded"):
        unfold(back)
    with pytest.raises(ActionRefused, match=r"line through \[5, 6\] has no paper to turn"):
        fold(half, (5, 6), -1)


def test_a_fold_along_a_crease_under_a_flap_takes_the_flap_along() -> None:
    covered = crease_across(half_folded(), ((3, 6), 0.4), ((4, 5), 0.4), 1)
    assert [covered.is_folded(edge) for edge in ((5, 6), (7, 8))] == [True, True]
    back = fold(covered, (5, 6), 1)
    assert violations(back) == []
    assert dict(back.edges())[(5, 6)] == "F"
    assert back.is_folded((7, 8))
    assert back.folded_vertices_coords[3] == pytest.approx((1.0, 0.4))


def test_a_fold_through_several_planes_creases_them_all() -> None:
    quarter = crease_across(half_folded(), ((1, 2), 0.5), ((5, 6), 0.5), 1)
    assert len(quarter.faces) == 4
    assert len(layers_of_planes(quarter)) == 4


def test_only_the_top_flap_moves_when_the_fold_is_named_on_it() -> None:
    half = half_folded()
    flap = crease_across(half, ((3, 6), 0.5), ((4, 5), 0.5), 1)
    assert len(flap.faces) == 3
    assert flap.folded_vertices_coords[1] == pytest.approx((0.0, 1.0))


def test_two_vertices_of_different_layers_at_one_place_give_no_line() -> None:
    with pytest.raises(ActionRefused, match="Vertices 1 and 4 lie at one place"):
        fold(half_folded(), (1, 4), 1)


def test_an_edge_may_join_vertices_of_different_layers() -> None:
    half = half_folded()
    crossed = fold(half, (1, 6), 1)
    assert violations(crossed) == []
    assert crossed.folds == 2


def test_woven_planes_are_listed_face_by_face() -> None:
    marked = unfold(crease_across(new_paper(), ((1, 2), 0.5), ((4, 3), 0.5), 1))
    half = crease_across(marked, ((1, 4), 0.5), ((2, 3), 0.5), -1)
    lower, upper = half.order[:2], half.order[2:]
    beside = {f: g for f in lower for g in upper if abs(middle(half, f) - middle(half, g)) < 0.1}
    first, second = lower
    woven = replace(half, order=(first, beside[first], beside[second], second))
    layers = layers_of_planes(woven)
    assert sorted(face for layer in layers for plane in layer for face in plane) == sorted(woven.faces)
    depth = {face: i for i, layer in enumerate(layers) for plane in layer for face in plane}
    assert depth[first] < depth[beside[first]]
    assert depth[beside[second]] < depth[second]
    assert folded_state(woven).layers == layers
    assert read_fold(fold_text(fold_document(woven))) == woven
    assert obj_text(woven).count("\ng face_") == 4


def middle(paper: Paper, face: int) -> float:
    """The x of a face's middle as it lies."""
    outline = paper.polygon(face)
    return sum(x for x, _ in outline) / len(outline)


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda p: add_vertex(p, (1, 3), 0.5), r"No edge joins 1 and 3; edges from 1 lead to 2, 4"),
        (lambda p: add_vertex(p, (1, 2), 1.5), r"Position 1.5 is outside edge \[1, 2\]"),
        (lambda p: add_vertex(p, (1, 2), 0.0), r"is vertex 1 itself"),
        (lambda p: fold(p, (1, 9), 1), r"There is no vertex 9; the vertices are 1 to 4"),
        (lambda p: fold(p, (1, 3), 0), r"Direction 0 is unknown"),
        (lambda p: fold(p, (1, 1), 1), r"lie at one place"),
        (lambda p: fold(p, (1, 2), 1), r"no paper to turn"),
        (lambda p: fold(p, (1, 2), -1), r"would turn the whole model over"),
        (unfold, r"Nothing is folded"),
        (lambda p: unfold(p, (1, 2)), r"\[1, 2\] is not a folded crease"),
        (lambda p: flip(p, "z"), r"Axis 'z' is unknown"),
        (lambda p: rotate(p, float("nan")), r"Angle nan is not a number"),
    ],
)
def test_impossible_actions_are_refused_in_one_sentence(act, words: str) -> None:
    with pytest.raises(ActionRefused, match=words):
        act(new_paper())


def test_a_rectangle_folds_like_a_square() -> None:
    paper = new_paper((2.0, 1.0))
    paper = crease_across(paper, ((1, 2), 0.5), ((4, 3), 0.5), 1)
    assert paper.folded_vertices_coords[2] == pytest.approx((0.0, 1.0))
    assert violations(paper) == []
    assert flip(paper, "x").folded_vertices_coords[1] == pytest.approx((2.0, 1.0))


def test_the_state_for_models_has_six_decimals_and_string_keys() -> None:
    state = folded_state(rotate(half_folded(), 30))
    assert set(state.model_dump()) == {"vertices", "faces", "faces_orientations", "edges", "layers"}
    assert all(round(x, 6) == x for point in state.vertices.values() for x in point)


def test_slivers_along_a_fold_line_do_not_stop_it() -> None:
    near = add_vertex(new_paper(), (1, 2), 0.5)
    near = add_vertex(near, (5, 2), 0.0004)
    near = add_vertex(near, (4, 3), 0.5)
    marked = unfold(fold(near, (5, 7), 1))
    folded = fold(marked, (6, 7), 1)
    assert violations(folded) == []
    assert folded.is_folded((6, 7))


def test_a_layer_that_lies_exactly_over_the_moving_part_moves_too() -> None:
    marked = add_vertex(new_paper(), (4, 1), 1 / 3)
    turned = flip(fold(marked, (2, 4), 1), "x")
    folded = fold(add_vertex(turned, (2, 1), 0.75), (6, 5), -1)
    assert violations(folded) == []
    assert len(folded.faces) == 4


def test_a_fold_that_just_misses_a_vertex_other_folds_just_missed_is_refused_and_names_it() -> None:
    paper = fold(rotate(new_paper(), -45), (2, 4), 1)
    paper = add_vertex(add_vertex(paper, (3, 4), 0.00013199103564270366), (2, 4), 0.500066)
    paper = fold(flip(fold(paper, (6, 5), 1), "y"), (4, 1), 1)
    paper = fold(add_vertex(paper, (2, 3), 0.500066), (8, 6), -1)
    assert violations(paper) == []
    with pytest.raises(
        ActionRefused, match=r"fold through \[9, 3\] would put the layers that meet at vertex 1 .* apart"
    ):
        fold(paper, (9, 3), -1)
    assert violations(fold(paper, (9, 4), -1)) == []


def test_a_fold_that_leaves_an_older_crease_at_a_tiny_angle_keeps_the_layers_apart() -> None:
    """A thousandth of a radian, past a vertex that several layers share: the slivers between taper to nothing."""
    paper = crease_across(new_paper(), ((3, 4), 1 / 3), ((1, 4), 1 / 3), -1)
    paper = unfold(crease_across(flip(paper, "y"), ((1, 2), 0.668), ((4, 5), 0.25), 1))
    assert violations(crease_across(paper, ((8, 9), 0.9234979205499458), ((5, 8), 0.75), 1)) == []

    paper = unfold(crease_across(new_paper(), ((3, 4), 0.76), ((2, 3), 0.25), 1))
    paper = unfold(crease_across(paper, ((3, 5), 0.029), ((2, 6), 0.25), -1))
    paper = crease_across(paper, ((5, 4), 1 / 3), ((8, 9), 0.8356221123600541), 1)
    assert violations(fold(paper, (2, 11), 1)) == []
