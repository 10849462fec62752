"""Actions derived between states that are rounded, renumbered and lettered as data sets have them."""

import json
from pathlib import Path
from typing import Any

import pytest
from data_set_states import data_set_document, data_set_states
from evaluated import EXAMPLES, example_program
from folding_schemas.actions import Action, AddVertex, Flip, Fold, Program, Rotate, Unfold, action_text
from folding_server.cli import main
from folding_server.derivation.given_files import documents_of_frames, given_documents
from folding_server.derivation.given_states import given_state
from folding_server.derivation.pose_matching import is_still, pose_between
from folding_server.derivation.sequence_derivation import DerivedSequence, derive_sequence
from folding_server.derivation.turning import snapped_angle
from folding_server.errors import ProgramError
from folding_server.interchange.fold_reading import FaceOrders
from folding_server.interchange.programs import load_program, load_recorded, resolved
from folding_server.simulator import apply, new_paper
from folding_server.simulator.apply import replay
from paths import ROOT
from reference import reference_files

PROGRAMS = ROOT / "benchmarks" / "reconstruction" / "programs"
NOT_DERIVED = {"penguin": 10, "swan": 12, "whale": 8}
"""Programs with one frame that three decimals do not lead to from the steps before."""
DIAGONAL = Fold(edge=(4, 2), direction=1)
AGAIN = AddVertex(edge=(4, 2), position=0.5), Fold(edge=(5, 1), direction=-1)
"""The triangle halved."""


def derived(documents: list[dict[str, Any]]) -> DerivedSequence:
    return derive_sequence(documents, FaceOrders.VIEWER)


def words(sequence: DerivedSequence) -> list[list[str] | None]:
    return [
        None if step.actions is None else [action_text(action) for action in step.actions]
        for step in sequence.steps
    ]


def one_step(*actions: Action) -> list[str] | None:
    """What is derived of a single step from the flat sheet."""
    (found,) = words(derived(data_set_states(Program(steps=(actions,)))))
    return found


def holds(sequence: DerivedSequence, documents: list[dict[str, Any]]) -> bool:
    """Whether the program leads to every state."""
    program = sequence.program("x")
    assert program is not None
    for count, document in enumerate(documents):
        state = given_state(document, FaceOrders.VIEWER)
        paper = replay(action for step in program.steps[:count] for action in step)
        pose = pose_between(paper, state)
        if pose is None or not is_still(pose, paper):
            return False
    return True


class TestSteps:
    def test_nothing(self) -> None:
        assert one_step() == []

    @pytest.mark.parametrize("angle", [45.0, -90.0, 22.5, 10.0, -137.0])
    def test_a_rotation(self, angle: float) -> None:
        assert one_step(Rotate(angle=angle)) == [f"rotate({angle})"]

    @pytest.mark.parametrize("axis", ["x", "y", "y=x", "y=-x"])
    def test_a_flip_about_its_axis(self, axis: Any) -> None:
        program = Program(steps=((DIAGONAL, Rotate(angle=20)), (Flip(axis=axis),)))
        assert words(derived(data_set_states(program)))[1] == [f"flip({axis})"]

    def test_a_fold_and_its_undoing(self) -> None:
        program = Program(steps=((DIAGONAL,), (Unfold(),)))
        assert words(derived(data_set_states(program))) == [["fold([2, 4], 1)"], ["unfold()"]]

    def test_a_vertex_is_put_where_it_was_meant(self) -> None:
        added = AddVertex(edge=(1, 2), position=0.35), AddVertex(edge=(4, 3), position=0.35)
        found = one_step(*added, Fold(edge=(5, 6), direction=1))
        assert found is not None
        assert {text.split(", ")[-1] for text in found[:2]} <= {"0.35)", "0.65)"}

    @pytest.mark.parametrize(
        "actions",
        [
            (DIAGONAL, Unfold()),
            (DIAGONAL, Flip(axis="y")),
            (Rotate(angle=45), DIAGONAL),
            (Flip(axis="x"), DIAGONAL),
            (DIAGONAL, *AGAIN),
            (DIAGONAL, Rotate(angle=135), Flip(axis="x")),
        ],
        ids=lambda actions: " ".join(action.action for action in actions),
    )
    def test_several_at_once(self, actions: tuple[Action, ...]) -> None:
        documents = data_set_states(Program(steps=(actions,)))
        sequence = derived(documents)
        assert sequence.steps[0].actions is not None
        assert len(sequence.steps[0].actions) <= len(actions) + 1
        assert holds(sequence, documents)


@pytest.mark.parametrize("name", EXAMPLES)
def test_whole_programs_are_derived_and_lead_to_every_state(name: str) -> None:
    documents = data_set_states(example_program(name))
    assert holds(derived(documents), documents)


@pytest.mark.slow
@pytest.mark.parametrize("file", sorted(PROGRAMS.glob("*.json")), ids=lambda file: file.stem)
def test_programs_of_books_are_derived(file: Path) -> None:
    documents = data_set_states(load_program(file.read_text(encoding="utf-8")))
    sequence = derived(documents)
    odd = [step.frame for step in sequence.steps if step.actions is None or step.restarted]
    assert odd == [step + 1 for step in [NOT_DERIVED.get(file.stem)] if step]
    assert bool(odd) or holds(sequence, documents)


@pytest.mark.slow
@pytest.mark.parametrize("file", reference_files("programs/recorded", "*.json"))
def test_published_results_are_derived(file: Path) -> None:
    """Each action but an added vertex as a keyframe of its own."""
    paper, flips = new_paper(), 0
    documents = [data_set_document(paper, flipped=False, seed=0)]
    for number, recorded in enumerate(load_recorded(file.read_text(encoding="utf-8")).actions):
        action = resolved(paper, recorded)
        paper, flips = apply(paper, action), flips + (action.action == "flip")
        if action.action != "add_vertex":
            documents.append(data_set_document(paper, flipped=flips % 2 == 1, seed=number))
    assert derived(documents).program(file.stem) is not None


def test_creases_that_are_there_from_the_start_are_made_first() -> None:
    """The first state has both diagonals as marks; the next is folded along one of them."""
    marks = (DIAGONAL, Unfold(), Fold(edge=(1, 3), direction=1), Unfold())
    program = Program(steps=(marks, (Fold(edge=(4, 2), direction=-1),)))
    documents = data_set_states(program)[1:]
    sequence = derived(documents)
    assert sequence.creases > 0
    assert sequence.start is not None
    assert [action.action for action in sequence.start if action.action != "add_vertex"] == [
        "fold",
        "unfold",
    ] * 2
    found = sequence.program("marked")
    assert found is not None
    assert found.comment is not None
    paper = replay(action for step in found.steps for action in step)
    pose = pose_between(paper, given_state(documents[1], FaceOrders.VIEWER))
    assert pose is not None
    assert is_still(pose, paper)


def test_a_mark_that_ends_inside_the_sheet_cannot_have_been_made_first() -> None:
    """It is named, and the steps after it are derived all the same."""
    half = (
        DIAGONAL,
        AddVertex(edge=(4, 2), position=0.5),
        AddVertex(edge=(4, 3), position=0.5),
        Fold(edge=(5, 6), direction=1),
        Unfold(),
        Unfold(),
    )
    documents = data_set_states(Program(steps=(half, (Rotate(angle=45),))))[1:]
    sequence = derived(documents)
    assert words(sequence) == [["rotate(45.0)"]]
    assert (sequence.start is None) == (sequence.program("x") is None)


def test_what_cannot_be_derived_is_named_and_not_guessed() -> None:
    """The second state lies somewhere else than any rotation or flip puts it."""
    documents = data_set_states(Program(steps=((DIAGONAL,), (Flip(axis="x"),))))
    moved = documents[2]["file_frames"][0]
    moved["vertices_coords"] = [[x + 0.2, y] for x, y in moved["vertices_coords"]]
    sequence = derived(documents)
    assert words(sequence)[1] is None
    assert "no rotation or flip puts the model where it is" in sequence.steps[1].reason
    assert sequence.program("x") is None


def test_without_a_folded_form_folds_are_derived_and_turns_are_not() -> None:
    program = Program(steps=((DIAGONAL,), (Rotate(angle=45),), AGAIN))
    sequence = derived(data_set_states(program, posed=False))
    assert words(sequence)[0] == ["fold([2, 4], 1)"]
    assert words(sequence)[1] is None
    assert "does not say where it lies" in sequence.steps[1].reason


def test_letters_follow_from_the_layers_whatever_the_file_calls_them() -> None:
    paper = replay([DIAGONAL, Flip(axis="x")])
    for flipped in (False, True):
        document = data_set_document(paper, flipped=flipped, seed=3)
        found = given_state(document, FaceOrders.VIEWER).paper()
        assert [letter for _, letter in found.edges()].count("V") == 1


def test_a_state_that_cannot_be_read_is_named_by_its_frame() -> None:
    documents = data_set_states(Program(steps=((DIAGONAL,), (Flip(axis="x"),))))
    documents[1]["faces_vertices"] = [[0, 1, 99]]
    sequence = derived(documents)
    assert words(sequence) == [None, None]
    assert "the state cannot be read: In frame 1 (the key frame) of the FOLD file" in sequence.steps[0].reason
    assert [paper is None for paper in sequence.papers] == [False, True, False]
    with pytest.raises(ProgramError, match=r"^Frame 1: "):
        derived(documents[1:])


@pytest.mark.parametrize(
    ("angle", "meant"), [(44.9, 45.0), (-90.1, -90.0), (30.2, 30.0), (10.37, 10.4)], ids=str
)
def test_angles_are_taken_for_what_was_meant(angle: float, meant: float) -> None:
    assert snapped_angle(angle) == pytest.approx(meant, abs=0.4)


def test_slivers_that_rounding_has_closed_are_no_obstacle() -> None:
    """A fold 0.0003 beside a mark: with three decimals both are one crease."""
    mark = (
        AddVertex(edge=(1, 2), position=0.5),
        AddVertex(edge=(4, 3), position=0.5),
        Fold(edge=(5, 6), direction=1),
        Unfold(),
    )
    beside = (
        AddVertex(edge=(1, 5), position=0.9994),
        AddVertex(edge=(4, 6), position=0.9994),
        Fold(edge=(7, 8), direction=1),
    )
    again = AddVertex(edge=(1, 4), position=0.25), AddVertex(edge=(7, 8), position=0.25)
    program = Program(steps=(mark, beside, (*again, Fold(edge=(9, 10), direction=-1)), (Flip(axis="x"),)))
    documents = data_set_states(program)
    corners = [tuple(point) for point in documents[2]["vertices_coords"]]
    assert len(set(corners)) < len(corners)
    assert all(found is not None for found in words(derived(documents)))


class TestFiles:
    def documents(self) -> list[dict[str, Any]]:
        return data_set_states(Program(steps=((DIAGONAL,), (Flip(axis="y"),))))

    def command(self, *given: object) -> int:
        with pytest.raises(SystemExit) as ended:
            main([str(word) for word in given])
        return int(ended.value.code or 0)

    def test_frames_of_one_file_are_states(self) -> None:
        first, *others = self.documents()
        below = [{**frame, "file_frames": None} for frame in others]
        frames = [frame for each in (first, *below) for frame in (each, *(each.get("file_frames") or ()))]
        folded = [each["file_frames"][0] for each in others]
        whole = {**first, "file_frames": [*first["file_frames"], *sum(zip(others, folded, strict=True), ())]}
        assert len(frames) == 4
        found = documents_of_frames(json.loads(json.dumps(whole)))
        assert words(derive_sequence(found, FaceOrders.VIEWER)) == [["fold([2, 4], 1)"], ["flip(y)"]]

    def test_a_folder_for_each_step_is_read_in_order_of_number(self, tmp_path: Path) -> None:
        for number, document in zip((2, 9, 10), self.documents(), strict=True):
            (tmp_path / f"step_{number}").mkdir()
            (tmp_path / f"step_{number}" / "cp.fold").write_text(json.dumps(document))
        assert [document["vertices_coords"] for document in given_documents(tmp_path)] == [
            document["vertices_coords"] for document in self.documents()
        ]

    def test_the_command_writes_states_steps_and_program(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (tmp_path / "given").mkdir()
        for number, document in enumerate(self.documents(), start=1):
            (tmp_path / "given" / f"{number}.fold").write_text(json.dumps(document))
        out = tmp_path / "out"
        assert self.command("derive", tmp_path / "given", "-o", out, "--face-orders", "viewer") == 0
        assert "2 of 2 steps derived" in capsys.readouterr().out
        assert sorted(path.name for path in out.iterdir()) == ["derivation.json", "program.json", "states"]
        assert len(list((out / "states").iterdir())) == 3
        assert load_program((out / "program.json").read_text()).name == "out"

    def test_a_folder_without_states_is_refused(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert self.command("derive", tmp_path, "-o", tmp_path / "out") == 1
        assert "holds no FOLD file" in capsys.readouterr().err
