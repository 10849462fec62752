"""Programs, exports, pictures of the crease pattern, .cp and OBJ, and running a program step by step."""

import itertools
import json
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest
import shapely
from folding_schemas.actions import AddVertex, Flip, Fold, Program, Rotate, Unfold
from folding_schemas.state import FoldedState
from folding_server.diagram import Colors
from folding_server.errors import FoldingError, ProgramError
from folding_server.interchange.crease_pattern import crease_pattern_of
from folding_server.interchange.crease_pattern_svg import crease_pattern_svg
from folding_server.interchange.export import EXPORT_FILES, export
from folding_server.interchange.fold_reading import read_crease_pattern, read_fold
from folding_server.interchange.obj import obj_text
from folding_server.interchange.oripa import oripa_text
from folding_server.interchange.program_files import program_in
from folding_server.interchange.programs import (
    load_commented_program,
    load_program,
    load_published,
    load_recorded,
    program_text,
    resolved,
)
from folding_server.simulate import run_steps, simulate
from folding_server.simulator import apply, folded_state, moved_faces, new_paper
from folding_server.simulator.plane_layers import layers_of_planes
from hypothesis import given, settings
from hypothesis import strategies as st
from papers import CAT, FIGURES, RESULTS, figure, random_paper, result, states

actions = st.one_of(
    st.builds(AddVertex, edge=st.tuples(st.integers(), st.integers()), position=st.floats(0, 1)),
    st.builds(Fold, edge=st.tuples(st.integers(), st.integers()), direction=st.sampled_from([1, -1])),
    st.builds(Unfold, edge=st.none() | st.tuples(st.integers(), st.integers())),
    st.builds(Rotate, angle=st.floats(-360, 360)),
    st.builds(Flip, axis=st.sampled_from(["x", "y", "y=x", "y=-x"])),
)
programs = st.builds(
    Program,
    name=st.text(),
    front_color=st.none() | st.text(),
    comment=st.none() | st.text(),
    sheet=st.tuples(st.floats(0.01, 100), st.floats(0.01, 100)) | st.just((1.0, 1.0)),
    steps=st.lists(st.lists(actions, max_size=3).map(tuple), max_size=4).map(tuple),
)


@given(programs, st.data())
def test_a_program_and_its_comments_survive_a_file(program: Program, data: Any) -> None:
    places = [(i, j) for i, step in enumerate(program.steps) for j in range(len(step))]
    comments = data.draw(st.dictionaries(st.sampled_from(places), st.text())) if places else {}
    again = load_commented_program(program_text(program, comments))
    assert again.program == program
    assert again.comments == comments


def test_published_programs_keep_their_extra_keys() -> None:
    published = load_published(CAT.read_text(encoding="utf-8"))
    assert published.new_vertices[4] == (6, 7)
    assert published.source.startswith("figures of the paper")
    with pytest.raises(ProgramError, match="source"):
        load_program(CAT.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", RESULTS)
def test_recorded_programs_are_resolved_by_place(path: Path) -> None:
    recorded = load_recorded(path.read_text(encoding="utf-8"))
    paper = new_paper()
    for action in recorded.actions:
        paper = apply(paper, resolved(paper, action))
    assert len(paper.vertices_coords) == len(recorded.final["vertices"])


@pytest.mark.parametrize("path", RESULTS)
def test_a_recorded_result_is_read_as_a_program_of_a_step_for_each_action(path: Path) -> None:
    program = program_in(path.read_text(encoding="utf-8"))
    assert all(len(step) == 1 for step in program.steps)
    assert states(program)[-1] == result(path)


def test_an_action_of_a_recorded_result_that_cannot_be_folded_is_named() -> None:
    flip = {"action": "flip", "axis": "x"}
    with pytest.raises(ProgramError, match="Action 2 of the recorded program cannot be folded: "):
        program_in(json.dumps({"license": "any", "actions": [flip, {"action": "unfold"}], "final": {}}))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("nonsense", "The program is not JSON (line 1, column 1)"),
        ("3", "JSON int"),
        ('{"steps": 3}', "The list of steps is wrong"),
        ('{"frames": "f"}', "has a key 'frames' that is not known; a program has the keys name"),
        (
            '{"steps": [[{"action": "unfold", "why": 1}]]}',
            "step 1 of the program has a key 'why' that is not known; remove it",
        ),
        ('{"steps": [3]}', "Step 1 of the program is wrong"),
        ('{"steps": [[], [{"action": "crumple"}]]}', "Action 1 of step 2 of the program is wrong"),
        ('{"steps": [[{"action": "fold", "edge": [1, 2], "direction": 0}]]}', "fold.direction"),
        ('{"steps": [[{"action": "rotate", "angle": NaN}]]}', "not JSON"),
        ('{"steps": [[{"action": "rotate", "angle": 1e999}]]}', "has the angle inf"),
        ('{"steps": [], "sheet": [0, 1]}', "sheet is 0 by 1"),
        ('{"steps": [], "colour": "red"}', "colour"),
    ],
)
def test_a_broken_program_is_refused_in_one_sentence(text: str, reason: str) -> None:
    with pytest.raises(ProgramError) as refused:
        load_program(text)
    assert reason in str(refused.value)
    assert "\n" not in str(refused.value)


def test_every_format_has_a_file_named_after_the_program() -> None:
    program = figure(CAT).model_copy(update={"name": "my / cat"})
    paper = states(program)[-1]
    files = {name: export(paper, name, Colors("red", "white"), program) for name in EXPORT_FILES}
    assert files["fold"].filename == "my-cat.fold"
    assert files["png"].content[:4] == b"\x89PNG"
    assert read_fold(files["fold"].content) == paper
    assert read_crease_pattern(files["crease-pattern"].content) == crease_pattern_of(paper)
    assert load_program(files["program"].content) == program
    assert all(file.media_type and file.content for file in files.values())


def test_a_paper_without_a_program_has_none_to_export() -> None:
    with pytest.raises(ProgramError, match="not made by a program"):
        export(new_paper(), "program")


def test_the_crease_pattern_picture_has_a_style_for_each_letter() -> None:
    pattern = crease_pattern_of(states(figure(FIGURES[0]))[-1])
    root = ET.fromstring(crease_pattern_svg(pattern, legend=True))
    drawn = {e.get("class"): e for e in root.iter() if e.get("class")}
    assert set(drawn) == {"edge", "mountain", "valley", "mark"}
    assert (drawn["mountain"].get("stroke"), drawn["valley"].get("stroke")) == ("#d02a2a", "#1f5fd0")
    assert len(drawn["mountain"].get("stroke-dasharray").split()) == 4
    assert len(drawn["valley"].get("stroke-dasharray").split()) == 2
    assert sum(e.get("d").count("M") for e in drawn.values()) == len(pattern.edges_vertices)
    assert {e.text for e in root.iter() if e.tag.endswith("text")} == {"edge", "mountain", "valley", "mark"}


def test_cp_lines_have_the_type_of_the_crease_and_span_the_page() -> None:
    pattern = crease_pattern_of(states(figure(CAT))[-1])
    rows = [line.split() for line in oripa_text(pattern).splitlines()]
    assert [row[0] for row in rows] == [
        {"B": "1", "M": "2", "V": "3", "F": "4"}[x] for x in pattern.edges_assignment
    ]
    numbers = [float(number) for row in rows for number in row[1:]]
    assert (min(numbers), max(numbers)) == (-200.0, 200.0)
    u, v = pattern.edges_vertices[0]
    (x1, y1), (x2, y2) = pattern.vertices_coords[u], pattern.vertices_coords[v]
    expected = [400 * x1 - 200, 200 - 400 * y1, 400 * x2 - 200, 200 - 400 * y2]
    assert [float(number) for number in rows[0][1:]] == pytest.approx(expected)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_obj_has_a_group_a_face_lifted_by_its_layer(seed: int) -> None:
    paper = random_paper(seed, 4)
    lines = [line.split() for line in obj_text(paper, 0.5).splitlines()]
    corners = [tuple(map(float, line[1:])) for line in lines if line[0] == "v"]
    groups = [line[1] for line in lines if line[0] == "g"]
    faces = [[corners[int(i.partition("/")[0]) - 1] for i in line[1:]] for line in lines if line[0] == "f"]
    assert groups == [f"face_{face}" for face in paper.order]
    depth = {f: i for i, layer in enumerate(layers_of_planes(paper)) for plane in layer for f in plane}
    for face, outline in zip(paper.order, faces, strict=True):
        assert {z for _, _, z in outline} == {0.5 * depth[face]}
        ring = shapely.LinearRing([(x, y) for x, y, _ in outline])
        assert ring.is_ccw != paper.back_up(face)
        assert shapely.Polygon(ring).area == pytest.approx(
            shapely.Polygon(paper.polygon(face)).area, abs=1e-6
        )


def test_simulating_writes_every_step_and_says_a_line_for_each(tmp_path: Path) -> None:
    said: list[str] = []
    program = figure(CAT)
    paper = simulate(program, tmp_path / "steps", said.append)
    assert paper == states(program)[-1]
    assert said[1] == "step 2: fold 4-2, - side; 1 of 2 faces moved; 2 layers"
    assert len(said) == len(program.steps)
    written = sorted(path.name for path in (tmp_path / "steps").iterdir())
    assert written == [f"step_{i:03d}.{kind}" for i in range(9) for kind in ("json", "png", "svg")]
    last = (tmp_path / "steps" / "step_008.json").read_text(encoding="utf-8")
    assert FoldedState.model_validate(json.loads(last)) == folded_state(paper)


def test_a_bad_action_is_named_and_the_steps_before_it_are_written(tmp_path: Path) -> None:
    fold = {"action": "fold", "edge": [4, 2], "direction": 1}
    bad = {"action": "fold", "edge": [4, 77], "direction": 1}
    program = load_program(json.dumps({"steps": [[fold], [{"action": "flip", "axis": "x"}, bad], [fold]]}))
    with pytest.raises(
        ProgramError, match=r"^Step 2, action 2 \(fold 4-77, \+ side\): There is no vertex 77"
    ):
        simulate(program, tmp_path)
    assert sorted({path.stem for path in tmp_path.iterdir()}) == ["step_000", "step_001"]


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FoldingError, match="cannot be written"):
        simulate(figure(CAT), tmp_path / "file")


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: path.stem)
def test_moved_faces_are_those_that_changed_place(path: Path) -> None:
    results = list(run_steps(figure(path)))
    for before, after in itertools.pairwise(results):
        for face in after.paper.faces:
            middle = shapely.Polygon(after.paper.sheet_polygon(face)).centroid
            point = (middle.x, middle.y)
            (origin,) = (
                f
                for f in before.paper.faces
                if shapely.Polygon(before.paper.sheet_polygon(f)).contains(middle)
            )
            apart = shapely.Point(before.paper.isometries[origin](point)).distance(
                shapely.Point(after.paper.isometries[face](point))
            )
            turned = before.paper.back_up(origin) != after.paper.back_up(face)
            if face in after.moved:
                assert apart > 1e-9 or turned or any("rotate" in a.action for a in after.actions)
            else:
                assert apart < 1e-9
                assert not turned
    assert moved_faces(results[0].paper, results[0].paper) == ()
