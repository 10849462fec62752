"""FOLD files: what we write, that we read it back exactly, and files from elsewhere."""

import json
from contextlib import suppress
from math import dist
from pathlib import Path
from typing import Any

import pytest
from folding_server.errors import ActionRefused, ProgramError
from folding_server.interchange.crease_pattern import crease_pattern_of
from folding_server.interchange.fold_format import crease_pattern_document, fold_document, fold_text
from folding_server.interchange.fold_reading import FaceOrders, fold_flat, read_crease_pattern, read_fold
from folding_server.simulator import (
    TOLERANCE,
    Paper,
    add_vertex,
    flip,
    fold,
    new_paper,
    overlapping_pairs,
    unfold,
)
from folding_server.simulator.foldability import CreasePattern, check_pattern
from folding_server.simulator.foldability.flat_faces import lay_flat
from hypothesis import given, settings
from hypothesis import strategies as st
from known_patterns import KNOWN, TWISTS, fold_file
from papers import FIGURES, RESULTS, figure, random_paper, result, states
from reference import golden_file, golden_rows, reference_files

PATTERNS = [
    *(pytest.param(fold_file(known.pattern), id=known.name) for known in KNOWN),
    *reference_files("flatfold/patterns", "*.fold"),
]


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


def assignments(paper: Paper) -> list[str]:
    return [assignment for _, assignment in paper.edges()]


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
    assert ids == sorted(paper.vertices_coords)
    assert [tuple(p) for p in document["vertices_coords"]] == [paper.folded_vertices_coords[v] for v in ids]
    assert [tuple(p) for p in pattern["vertices_coords"]] == [paper.vertices_coords[v] for v in ids]


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
    for (u, v), beside, assignment, angle in zip(
        *(document[f"edges_{name}"] for name in ("vertices", "faces", "assignment", "foldAngle")), strict=True
    ):
        assert (len(beside) == 1) == (assignment == "B")
        assert angle == {"V": 180, "M": -180}.get(assignment, 0)
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


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: path.stem)
def test_models_of_the_figures_come_back_exactly(path: Path) -> None:
    paper = states(figure(path))[-1]
    assert read_fold(fold_text(fold_document(paper))) == paper


@pytest.mark.parametrize("path", RESULTS)
def test_known_results_come_back_exactly(path: Path) -> None:
    paper = result(path)
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
    assert assignments(again) == assignments(paper)
    if frames != "crease pattern":
        for ours, theirs in zip(
            sorted(paper.folded_vertices_coords), sorted(again.folded_vertices_coords), strict=True
        ):
            assert again.folded_vertices_coords[theirs] == pytest.approx(
                paper.folded_vertices_coords[ours], abs=4 * TOLERANCE
            )


def test_an_imported_fold_can_be_unfolded() -> None:
    again = read_fold(without_record(fold_document(fold(new_paper(), (4, 2), 1))))
    flat = unfold(again)
    assert set(assignments(flat)) == {"B", "F"}


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


def text_of(file: str | Path) -> str:
    """The text of a FOLD file that is there as a text or as a file."""
    return file if isinstance(file, str) else file.read_text(encoding="utf-8")


@pytest.mark.parametrize("file", PATTERNS)
def test_faces_are_found_from_the_edges(file: str | Path) -> None:
    document = json.loads(text_of(file))
    given = read_crease_pattern(document)
    del document["faces_vertices"]
    found = read_crease_pattern(document)
    assert sorted(map(sorted, found.faces_vertices)) == sorted(map(sorted, given.faces_vertices))
    assert found.edges_assignment == given.edges_assignment


def test_unassigned_creases_stay_unassigned_and_the_boundary_is_recognised() -> None:
    document = crease_pattern_document(quarter())
    del document["edges_assignment"]
    del document["edges_foldAngle"]
    pattern = read_crease_pattern(document)
    assert [assignment == "B" for assignment in pattern.edges_assignment] == [
        assignment == "B" for assignment in assignments(quarter())
    ]
    assert set(pattern.edges_assignment) == {"B", "U"}
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
    assert pattern.edges_assignment == crease_pattern_of(paper).edges_assignment
    assert check_pattern(pattern).foldable


CIRCULAR = [
    *(pytest.param(fold_file(pattern), id=name) for name, pattern in TWISTS.items()),
    *reference_files("flatfold/patterns", "c_twist6_b40.fold"),
]
STACKED = {known.name: known.pattern for known in KNOWN if known.orders and known.name not in TWISTS}


@pytest.mark.parametrize("name", STACKED)
def test_a_foldable_pattern_is_folded_and_keeps_its_letters(name: str) -> None:
    assert_folded(read_crease_pattern(fold_file(STACKED[name])))


@pytest.mark.parametrize(
    "row", golden_rows(lambda row: row["valid"] and row["faces"] <= 30 and "twist" not in row["name"])
)
def test_a_foldable_pattern_from_elsewhere_is_folded_and_keeps_its_letters(row: dict[str, Any]) -> None:
    assert_folded(read_crease_pattern(golden_file(row).read_text(encoding="utf-8")))


def assert_folded(pattern: CreasePattern) -> None:
    paper = fold_flat(pattern)
    names = sorted(paper.vertices_coords)
    ours = {frozenset(edge): assignment for edge, assignment in paper.edges()}
    for (u, v), assignment in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True):
        found = ours[frozenset((names[u], names[v]))]
        assert found in ("M", "V") if assignment == "U" else found == assignment


@pytest.mark.parametrize("file", CIRCULAR)
def test_a_twist_whose_layers_go_round_in_a_circle_has_no_stack(file: str | Path) -> None:
    with pytest.raises(ProgramError, match="its layers go round in a circle"):
        fold_flat(read_crease_pattern(text_of(file)))


def test_a_pattern_that_does_not_fold_is_refused_with_the_reason() -> None:
    document = crease_pattern_document(quarter())
    swap = {"M": "V", "V": "M"}
    first = next(i for i, assignment in enumerate(document["edges_assignment"]) if assignment in swap)
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
    "a mountain on a valley": (
        SQUARE
        | {"edges_vertices": [*SQUARE["edges_vertices"], [2, 0]], "edges_assignment": ["B"] * 4 + ["V", "M"]},
        "A mountain and a valley lie on top of each other",
    ),
    "an edge without ends": (
        SQUARE
        | {"edges_vertices": [*SQUARE["edges_vertices"], [2, 2]], "edges_assignment": ["B"] * 4 + ["V", "F"]},
        "edge 5 joins vertex 2 with itself",
    ),
    "a face without corners": (
        SQUARE | {"faces_vertices": [[0, 1, 2], []]},
        "face 1 has fewer than three corners",
    ),
    "a cut": (SQUARE | {"edges_assignment": ["B", "B", "B", "B", "C"]}, "cut edges"),
    "three dimensions": (
        SQUARE | {"vertices_coords": [[0, 0], [1, 0], [1, 1, 0.5], [0, 1]]},
        "three-dimensional",
    ),
    "a part of a sheet": (SQUARE | {"faces_vertices": [[0, 1, 2]]}, "whole rectangular sheets"),
    "a frame that inherits from nowhere": (
        SQUARE | {"file_frames": [{"frame_inherit": True, "frame_parent": 7}]},
        "Frame 2 of the FOLD file has frame_parent 7, but frame_parent is from 0",
    ),
    "frames that inherit in a circle": (
        SQUARE | {"file_frames": [{"frame_inherit": True, "frame_parent": 1}]},
        "Frame 2 of the FOLD file inherits from itself",
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


def recorded_document(path: Any) -> dict[str, Any]:
    """The final state of a published result as a FOLD file: its vertices, edges, and its pairs as +1 face orders."""
    final = json.loads(path.read_text(encoding="utf-8"))["final"]
    sheet, lies = ([vertex[name] for vertex in final["vertices"]] for name in ("sheet", "folded"))
    pattern = {
        "vertices_coords": sheet,
        "edges_vertices": [[sheet.index(end) for end in edge["sheet"]] for edge in final["edges"]],
        "edges_assignment": [
            {"boundary": "B", "flat": "F", "folded": "U"}[edge["kind"]] for edge in final["edges"]
        ],
    }
    faces = [list(cycle) for cycle in read_crease_pattern(pattern).faces_vertices]
    middles = [mean([sheet[v] for v in cycle]) for cycle in faces]

    def number(middle: list[float]) -> int:
        return min(range(len(faces)), key=lambda i: dist(middles[i], middle))

    orders = [[number(upper), number(lower), 1] for upper, lower in final["over"]]
    flat = {
        "frame_classes": ["creasePattern"],
        "vertices_coords": sheet,
        "frame_inherit": True,
        "frame_parent": 0,
    }
    folded = {
        "frame_classes": ["foldedForm"],
        "vertices_coords": lies,
        "faces_vertices": faces,
        "faceOrders": orders,
    }
    return pattern | folded | {"file_frames": [flat]}


def mean(points: list[list[float]]) -> tuple[float, float]:
    return sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points)


@pytest.mark.parametrize("path", RESULTS)
def test_known_results_name_the_upper_face_first_as_the_model_is_seen(path: Any) -> None:
    """Of the conventions only one makes of their pairs the state that their actions lead to."""
    document, folded = recorded_document(path), result(path)
    places = [
        mean([document["file_frames"][0]["vertices_coords"][v] for v in f])
        for f in document["faces_vertices"]
    ]
    fitting = set()
    for convention in FaceOrders:
        with suppress(ProgramError):
            if by_place(read_fold(document, convention), places) == by_place(folded, places):
                fitting.add(convention)
    assert fitting == {FaceOrders.VIEWER}


def by_place(paper: Paper, places: list[tuple[float, float]]) -> tuple[set[int], set[tuple[int, int]]]:
    """Sides up and layers, each face named by the nearest of the places on the sheet."""
    name = {
        f: min(range(len(places)), key=lambda i: dist(places[i], mean(paper.sheet_polygon(f))))
        for f in paper.faces
    }
    over = {(name[low], name[high]) for low, high in overlapping_pairs(paper)}
    return {name[f] for f in paper.faces if paper.back_up(f)}, over


def test_face_orders_that_contradict_the_letters_are_refused() -> None:
    document = without_record(fold_document(fold(flip(new_paper(), "x"), (4, 2), 1)))
    assert document["edges_assignment"].count("M") == 1
    document["faceOrders"] = [[f, g, -sign] for f, g, sign in document["faceOrders"]]
    with pytest.raises(ProgramError, match=r"Edge \d-\d .* has the letter M, but its face orders make it V"):
        read_fold(document)


def test_layers_that_would_cross_are_refused_and_named() -> None:
    document = without_record(fold_document(quarter()))
    document["edges_assignment"] = [
        "U" if assignment in "MV" else assignment for assignment in document["edges_assignment"]
    ]
    assert stacking(read_fold(document)) == stacking(quarter())
    first, second, third, last = (list(quarter().faces).index(face) for face in quarter().order)
    wrong = [first, third, second, last]
    document["faceOrders"] = [[high, low, 1] for i, low in enumerate(wrong) for high in wrong[i + 1 :]]
    with pytest.raises(ProgramError, match=r"Layers of the FOLD file cross each other: its faces \d, \d"):
        read_fold(document, FaceOrders.VIEWER)


def test_vertices_listed_more_than_once_are_taken_as_one() -> None:
    """As some programs write it: every face with corners of its own, every edge once for each face beside it."""
    paper = quarter()
    document = without_record(fold_document(paper))
    pattern = document["file_frames"][0]
    corners = [v for cycle in document["faces_vertices"] for v in cycle]
    assignment = {
        frozenset(edge): assignment
        for edge, assignment in zip(document["edges_vertices"], document["edges_assignment"], strict=True)
    }
    apart = {"faces_vertices": [], "edges_vertices": [], "edges_assignment": []}
    for cycle in document["faces_vertices"]:
        start = sum(map(len, apart["faces_vertices"]))
        own = list(range(start, start + len(cycle)))
        apart["faces_vertices"].append(own)
        apart["edges_vertices"] += [list(side) for side in zip(own, own[1:] + own[:1], strict=True)]
        apart["edges_assignment"] += [
            assignment[frozenset(side)] for side in zip(cycle, cycle[1:] + cycle[:1], strict=True)
        ]
    soup = apart | {
        "frame_classes": ["foldedForm"],
        "faceOrders": document["faceOrders"],
        "vertices_coords": [
            [c + 1e-9 * i for c in document["vertices_coords"][v]] for i, v in enumerate(corners)
        ],
        "file_frames": [{**pattern, "vertices_coords": [pattern["vertices_coords"][v] for v in corners]}],
    }
    again = read_fold(soup)
    assert len(again.vertices_coords) == len(paper.vertices_coords)
    assert sorted(assignments(again)) == sorted(assignments(paper))
    assert stacking(again) == stacking(paper)
    assert check_pattern(read_crease_pattern(soup)).foldable


def test_vertices_at_one_place_of_the_sheet_that_lie_apart_when_folded_are_a_cut() -> None:
    document = without_record(fold_document(quarter()))
    document["vertices_coords"].append([0.3, 0.3])
    document["file_frames"][0]["vertices_coords"].append(
        list(document["file_frames"][0]["vertices_coords"][0])
    )
    with pytest.raises(
        ProgramError, match="Vertices 0 and 9 .* apart when folded, so the sheet is cut there"
    ):
        read_fold(document)


def test_a_face_whose_corners_fall_together_is_refused() -> None:
    flat = SQUARE | {
        "vertices_coords": [*SQUARE["vertices_coords"], [0, 1e-9]],
        "faces_vertices": [[0, 4, 1], [1, 2, 3]],
    }
    with pytest.raises(ProgramError, match="Face 0 .* no area"):
        read_crease_pattern(flat)


def test_edges_that_cross_or_end_on_others_are_cut_where_no_faces_are_given() -> None:
    loose = {
        "vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0], [0.5, 1], [0, 0.5], [1, 0.5]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [0, 3], [4, 5], [6, 7]],
    }
    pattern = read_crease_pattern(loose)
    assert (len(pattern.vertices_coords), len(pattern.edges_vertices), len(pattern.faces_vertices)) == (
        9,
        12,
        4,
    )
    assert sorted(pattern.edges_assignment) == ["B"] * 8 + ["U"] * 4
    assert check_pattern(pattern).states == 8


def test_edges_that_cross_are_refused_where_a_folded_form_goes_by_their_vertices() -> None:
    crossing = SQUARE | {
        "edges_vertices": [*SQUARE["edges_vertices"], [1, 3]],
        "edges_assignment": ["B"] * 4 + ["V"] * 2,
    }
    folded = {"frame_classes": ["foldedForm"], "frame_inherit": True, "frame_parent": 0}
    with pytest.raises(ProgramError, match="cross where there is no vertex"):
        read_fold(crossing | {"frame_classes": ["creasePattern"], "file_frames": [folded]})


@pytest.mark.parametrize("file", CIRCULAR)
def test_a_folded_form_whose_layers_go_in_a_circle_is_no_paper_but_its_pattern_is_checked(
    file: str | Path,
) -> None:
    pattern = read_crease_pattern(text_of(file))
    report, flat = check_pattern(pattern, cap=1), lay_flat(pattern)
    lies = {
        v: point
        for cycle, outline in zip(pattern.cycles, flat.outlines, strict=True)
        for v, point in zip(cycle, outline.tolist(), strict=True)
    }
    document = {
        "frame_classes": ["foldedForm"],
        "vertices_coords": [lies[v] for v in range(len(pattern.vertices_coords))],
        "edges_vertices": pattern.edges_vertices,
        "edges_assignment": pattern.edges_assignment,
        "faces_vertices": pattern.cycles,
        "faceOrders": [[high, low, 1] for low, high in report.lying],
    }
    with pytest.raises(ProgramError, match="circle"):
        read_fold(document, FaceOrders.VIEWER)
    again = check_pattern(read_crease_pattern(document))
    assert again.foldable
    assert again.stack is None


def rounded_to(value: Any, digits: int) -> Any:
    """A document with every number rounded, without what only our own files have."""
    if isinstance(value, dict):
        return {k: rounded_to(v, digits) for k, v in value.items() if not k.startswith("folding:")}
    if isinstance(value, list):
        return [rounded_to(each, digits) for each in value]
    return round(value, digits) if isinstance(value, float) else value


@pytest.mark.parametrize(("seed", "folds", "edge", "direction"), [(2, 3, (12, 10), -1), (8, 4, (6, 14), 1)])
def test_a_face_that_rounding_takes_off_the_moving_side_ends_in_a_paper_or_in_a_refusal(
    seed: int, folds: int, edge: tuple[int, int], direction: int
) -> None:
    """A corner of it lies beyond the line by the one place of that vertex, and before it by the face's own motion."""
    paper = read_fold(rounded_to(fold_document(random_paper(seed, folds)), 3))
    with suppress(ActionRefused):
        assert len(fold(paper, edge, direction).faces) >= len(paper.faces)
