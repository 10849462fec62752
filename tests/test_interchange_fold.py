"""FOLD files: what we write, that we read it back exactly, and files from elsewhere."""

import json
from typing import Any

import pytest
from folding_server.errors import ProgramError
from folding_server.interchange.crease_pattern import crease_pattern_of
from folding_server.interchange.fold_format import crease_pattern_document, fold_document, fold_text
from folding_server.interchange.fold_reading import FaceOrders, fold_flat, read_crease_pattern, read_fold
from folding_server.interchange.programs import load_recorded, resolved
from folding_server.simulator import (
    TOLERANCE,
    Paper,
    add_vertex,
    apply,
    flip,
    fold,
    new_paper,
    overlapping_pairs,
    unfold,
)
from folding_server.simulator.foldability import check_pattern
from hypothesis import given, settings
from hypothesis import strategies as st
from papers import FIGURES, RECORDED, figure, random_paper, states
from paths import SHARED

PATTERNS = sorted((SHARED / "flatfold" / "patterns").glob("*.fold"))


def quarter() -> Paper:
    """The square folded in half twice."""
    paper = add_vertex(add_vertex(new_paper(), (4, 1), 0.5), (3, 2), 0.5)
    paper = fold(paper, (5, 6), 1)
    paper = add_vertex(add_vertex(paper, (5, 6), 0.5), (1, 2), 0.5)
    return fold(paper, (7, 8), 1)


def gate() -> Paper:
    """The left side folded in over the middle, then the right side over both."""
    paper = add_vertex(add_vertex(new_paper(), (1, 2), 0.3), (4, 3), 0.3)
    paper = fold(paper, (5, 6), -1)
    paper = add_vertex(add_vertex(paper, (5, 2), 0.5), (6, 3), 0.5)
    return fold(paper, (7, 8), 1)


def without_record(document: dict[str, Any]) -> dict[str, Any]:
    """The file as other software would have written it: standard properties only."""
    bare = {key: value for key, value in document.items() if not key.startswith("folding:")}
    return json.loads(json.dumps(bare))


def stacking(paper: Paper) -> set[tuple[int, int]]:
    """Overlapping pairs (lower, upper), faces by their index."""
    index = {face: i for i, face in enumerate(paper.faces)}
    return {(index[low], index[high]) for low, high in overlapping_pairs(paper)}


def letters(paper: Paper) -> list[str]:
    return [letter for _, letter in paper.edges()]


def recorded_paper(path: Any) -> Paper:
    paper = new_paper()
    for recorded in load_recorded(path.read_text(encoding="utf-8")).actions:
        paper = apply(paper, resolved(paper, recorded))
    return paper


def test_the_folded_form_comes_first_and_the_crease_pattern_inherits_from_it() -> None:
    paper = quarter()
    document = fold_document(paper, "quarter")
    (pattern,) = document["file_frames"]
    assert document["file_spec"] == 1.2
    assert document["frame_classes"] == ["foldedForm"]
    assert "selfTouching" in document["frame_attributes"]
    assert pattern["frame_classes"] == ["creasePattern"]
    assert (pattern["frame_parent"], pattern["frame_inherit"]) == (0, True)
    assert "nonSelfTouching" in pattern["frame_attributes"]
    ids = document["folding:vertex_ids"]
    assert ids == sorted(paper.places)
    assert [tuple(p) for p in document["vertices_coords"]] == [paper.positions[v] for v in ids]
    assert [tuple(p) for p in pattern["vertices_coords"]] == [paper.places[v] for v in ids]


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, 6))
def test_the_mesh_is_what_the_specification_says(seed: int, folds: int) -> None:
    paper = random_paper(seed, folds)
    document = fold_document(paper)
    places = document["file_frames"][0]["vertices_coords"]
    for cycle, sides in zip(document["faces_vertices"], document["faces_edges"], strict=True):
        corners = [places[v] for v in cycle]
        turns = zip(corners, corners[1:] + corners[:1], strict=True)
        assert sum(p[0] * q[1] - p[1] * q[0] for p, q in turns) > 0
        for i, edge in enumerate(sides):
            assert set(document["edges_vertices"][edge]) == {cycle[i], cycle[(i + 1) % len(cycle)]}
    for (u, v), beside, letter, angle in zip(
        *(document[f"edges_{name}"] for name in ("vertices", "faces", "assignment", "foldAngle")), strict=True
    ):
        assert (len(beside) == 1) == (letter == "B")
        assert angle == {"V": 180, "M": -180}.get(letter, 0)
        first = document["faces_vertices"][beside[0]]
        if len(beside) == 2:
            assert first[(first.index(u) + 1) % len(first)] == v


def test_face_orders_are_relative_to_the_normal_of_the_second_face() -> None:
    paper = fold(new_paper(), (4, 2), 1)
    lower, upper = (list(paper.faces).index(face) for face in paper.order)
    assert fold_document(paper)["faceOrders"] == [[upper, lower, 1]]
    turned = flip(paper, "x")
    assert fold_document(turned)["faceOrders"] == [[lower, upper, 1]]
    behind = flip(fold(flip(new_paper(), "x"), (4, 2), 1), "x")
    assert [order[2] for order in fold_document(behind)["faceOrders"]] == [-1]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, 7), st.sampled_from([(1.0, 1.0), (1.0, 1.414), (2.35, 1.0)]))
def test_export_then_import_is_the_identity(seed: int, folds: int, sheet: tuple[float, float]) -> None:
    paper = random_paper(seed, folds, sheet)
    again = read_fold(fold_text(fold_document(paper)))
    assert again == paper
    assert list(again.faces) == list(paper.faces)
    assert list(again.creases) == list(paper.creases)


def test_what_was_folded_can_be_unfolded_after_import() -> None:
    paper = quarter()
    again = read_fold(fold_text(fold_document(paper)))
    assert unfold(unfold(again)) == unfold(unfold(paper))


@pytest.mark.parametrize("path", FIGURES + RECORDED, ids=lambda path: path.stem)
def test_published_models_come_back_exactly(path: Any) -> None:
    paper = recorded_paper(path) if path in RECORDED else states(figure(path))[-1]
    assert read_fold(fold_text(fold_document(paper))) == paper


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, 6), st.sampled_from(["both", "folded form", "crease pattern"]))
def test_standard_properties_alone_tell_the_folded_state(seed: int, folds: int, frames: str) -> None:
    paper = random_paper(seed, folds)
    document = without_record(fold_document(paper))
    (pattern,) = document["file_frames"]
    if frames != "both":
        del document["file_frames"]
    if frames == "crease pattern":
        document |= {"vertices_coords": pattern["vertices_coords"], "frame_classes": ["creasePattern"]}
    again = read_fold(document)
    if frames == "crease pattern" and paper.back_up(next(iter(paper.faces))):
        again = flip(again, "x")
    assert not stacking(again) & {(high, low) for low, high in stacking(paper)}
    assert letters(again) == letters(paper)
    if frames != "crease pattern":
        for ours, theirs in zip(sorted(paper.positions), sorted(again.positions), strict=True):
            assert again.positions[theirs] == pytest.approx(paper.positions[ours], abs=4 * TOLERANCE)


def test_an_imported_fold_can_be_unfolded() -> None:
    again = read_fold(without_record(fold_document(fold(new_paper(), (4, 2), 1))))
    flat = unfold(again)
    assert set(letters(flat)) == {"B", "F"}


@pytest.mark.parametrize("convention", FaceOrders)
def test_other_conventions_for_face_orders_are_read_when_asked_for(convention: FaceOrders) -> None:
    paper = states(figure(FIGURES[0]))[-1]
    document = without_record(fold_document(paper))
    ids = list(paper.faces)
    document["faceOrders"] = [
        [upper, lower, sign(convention, paper, ids[upper], ids[lower])] for lower, upper in stacking(paper)
    ]
    assert stacking(read_fold(document, convention)) == stacking(paper)


def sign(convention: FaceOrders, paper: Paper, upper: int, lower: int) -> int:
    """How a convention writes that the first face lies above the second."""
    return {
        FaceOrders.SPEC: -1 if paper.back_up(lower) else 1,
        FaceOrders.FIRST: -1 if paper.back_up(upper) else 1,
        FaceOrders.VIEWER: 1,
        FaceOrders.REVERSED: -1,
    }[convention]


def test_letters_order_neighbours_where_face_orders_are_left_out() -> None:
    paper = fold(new_paper(), (4, 2), -1)
    document = without_record(fold_document(paper))
    del document["faceOrders"]
    assert stacking(read_fold(document)) == stacking(paper)


def test_overlapping_faces_without_an_order_are_refused() -> None:
    document = without_record(fold_document(gate()))
    assert stacking(read_fold(document)) == stacking(gate())
    del document["faceOrders"]
    with pytest.raises(ProgramError, match="overlap when folded, but neither faceOrders nor the letters"):
        read_fold(document)


def test_face_orders_in_a_circle_are_refused() -> None:
    document = without_record(fold_document(quarter()))
    low, high = min(stacking(quarter()))
    document["faceOrders"] += [[low, high, 1], [low, high, -1]]
    with pytest.raises(ProgramError, match="circle"):
        read_fold(document)


def test_fold_angles_stand_in_for_letters() -> None:
    document = without_record(fold_document(quarter()))
    del document["edges_assignment"]
    assert stacking(read_fold(document)) == stacking(quarter())


def test_a_pattern_in_other_units_is_scaled_to_the_sheet() -> None:
    paper = states(figure(FIGURES[0]))[-1]
    document = without_record(fold_document(paper))
    for frame in (document, document["file_frames"][0]):
        frame["vertices_coords"] = [[400 * x - 200, 400 * y - 200] for x, y in frame["vertices_coords"]]
    again = read_fold(document)
    assert again.sheet == pytest.approx((1.0, 1.0))
    assert stacking(again) == stacking(paper)


@pytest.mark.parametrize("path", PATTERNS, ids=lambda path: path.stem)
def test_faces_are_found_from_the_edges(path: Any) -> None:
    document = json.loads(path.read_text(encoding="utf-8"))
    given = read_crease_pattern(document)
    del document["faces_vertices"]
    found = read_crease_pattern(document)
    assert sorted(map(sorted, found.faces)) == sorted(map(sorted, given.faces))
    assert found.letters == given.letters


def test_unassigned_creases_stay_unassigned_and_the_boundary_is_recognised() -> None:
    document = crease_pattern_document(quarter())
    del document["edges_assignment"]
    del document["edges_foldAngle"]
    pattern = read_crease_pattern(document)
    assert [letter == "B" for letter in pattern.letters] == [letter == "B" for letter in letters(quarter())]
    assert set(pattern.letters) == {"B", "U"}
    with pytest.raises(ProgramError, match="unassigned creases"):
        read_fold(document)


def test_a_bare_crease_pattern_goes_to_the_foldability_check() -> None:
    pattern = read_crease_pattern(fold_text(crease_pattern_document(quarter())))
    assert pattern == crease_pattern_of(quarter())
    assert check_pattern(pattern).foldable


def test_a_folded_form_alone_unfolds_to_its_crease_pattern() -> None:
    paper = quarter()
    document = without_record(fold_document(paper))
    del document["file_frames"]
    pattern = read_crease_pattern(document)
    assert pattern.letters == crease_pattern_of(paper).letters
    assert check_pattern(pattern).foldable


GOLDEN = [json.loads(line) for line in (SHARED / "flatfold" / "golden.jsonl").read_text().splitlines()]
SMALL = [
    entry["name"]
    for entry in GOLDEN
    if entry["valid"] and entry["faces"] <= 30 and "twist" not in entry["name"]
]


@pytest.mark.parametrize("name", SMALL)
def test_a_foldable_pattern_is_folded_and_keeps_its_letters(name: str) -> None:
    pattern = read_crease_pattern(
        (SHARED / "flatfold" / "patterns" / f"{name}.fold").read_text(encoding="utf-8")
    )
    paper = fold_flat(pattern)
    names = sorted(paper.places)
    ours = {frozenset(edge): letter for edge, letter in paper.edges()}
    for (u, v), letter in zip(pattern.edges, pattern.letters, strict=True):
        found = ours[frozenset((names[u], names[v]))]
        assert found in ("M", "V") if letter == "U" else found == letter


def test_a_twist_whose_layers_go_round_in_a_circle_has_no_stack() -> None:
    twist = SHARED / "flatfold" / "patterns" / "c_twist6_b40.fold"
    with pytest.raises(ProgramError, match="its layers go round in a circle"):
        fold_flat(read_crease_pattern(twist.read_text(encoding="utf-8")))


def test_a_pattern_that_does_not_fold_is_refused_with_the_reason() -> None:
    document = crease_pattern_document(quarter())
    swap = {"M": "V", "V": "M"}
    first = next(i for i, letter in enumerate(document["edges_assignment"]) if letter in swap)
    document["edges_assignment"][first] = swap[document["edges_assignment"][first]]
    with pytest.raises(ProgramError, match="cannot be folded flat into a stack: Maekawa fails"):
        fold_flat(read_crease_pattern(document))


SQUARE = {
    "vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1]],
    "edges_vertices": [[0, 1], [1, 2], [2, 3], [0, 3], [0, 2]],
    "edges_assignment": ["B", "B", "B", "B", "V"],
}

BROKEN = {
    "not JSON": ("{", "not JSON (line 1"),
    "a list": ("[]", "JSON list"),
    "not a number": ('{"vertices_coords": [[NaN, 0]]}', "not JSON"),
    "no vertices": ("{}", "no vertices_coords"),
    "a missing vertex": (SQUARE | {"edges_vertices": [[0, 9]], "edges_assignment": ["B"]}, "number 9"),
    "an unknown letter": (SQUARE | {"edges_assignment": ["B", "B", "B", "B", "X"]}, "edges_assignment.4"),
    "too few letters": (SQUARE | {"edges_assignment": ["B"]}, "1 entries where 5"),
    "crossing edges": (
        SQUARE
        | {"edges_vertices": [*SQUARE["edges_vertices"], [1, 3]], "edges_assignment": ["B"] * 4 + ["V"] * 2},
        "cross where there is no vertex",
    ),
    "a cut": (SQUARE | {"edges_assignment": ["B", "B", "B", "B", "C"]}, "cut edges"),
    "three dimensions": (
        SQUARE | {"vertices_coords": [[0, 0], [1, 0], [1, 1, 0.5], [0, 1]]},
        "three-dimensional",
    ),
    "a part of a sheet": (SQUARE | {"faces_vertices": [[0, 1, 2]]}, "whole rectangular sheets"),
    "a frame that inherits from nowhere": (
        SQUARE | {"file_frames": [{"frame_inherit": True, "frame_parent": 7}]},
        "frame 7",
    ),
    "frames that inherit in a circle": (
        SQUARE | {"file_frames": [{"frame_inherit": True, "frame_parent": 1}]},
        "inherits from itself",
    ),
    "a folded form of another shape": (
        SQUARE
        | {
            "frame_classes": ["creasePattern"],
            "file_frames": [
                {
                    "frame_inherit": True,
                    "frame_parent": 0,
                    "frame_classes": ["foldedForm"],
                    "vertices_coords": [[0, 0], [1, 0], [1, 1], [0.7, 0.1]],
                }
            ],
        },
        "another shape when folded",
    ),
    "letters that do not fold flat": (
        {
            "vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.4]],
            "edges_vertices": [[0, 1], [1, 2], [2, 3], [0, 3], [0, 4], [1, 4], [2, 4], [3, 4]],
            "edges_assignment": ["B", "B", "B", "B", "V", "V", "V", "M"],
        },
        "do not close up",
    ),
}


@pytest.mark.parametrize(("source", "reason"), BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_file_is_refused_in_one_sentence(source: str | dict[str, Any], reason: str) -> None:
    with pytest.raises(ProgramError) as refused:
        read_fold(source if isinstance(source, str) else json.dumps(source))
    assert reason in str(refused.value)
    assert "\n" not in str(refused.value)


def test_our_own_file_changed_by_another_program_is_refused() -> None:
    document = fold_document(quarter())
    document["vertices_coords"][0] = [5.0, 5.0]
    with pytest.raises(ProgramError, match="another program has moved it"):
        read_fold(document)
    document = fold_document(quarter())
    document["folding:record"]["order"].append(99)
    with pytest.raises(ProgramError, match="does not fit"):
        read_fold(document)
