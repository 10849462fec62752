"""Recorded runs against the truth: what is planned, how runs end, the same bytes for the same inputs."""

import csv
import json
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import folding_schemas
import jsonschema
import pytest
from evaluated import example_program, write_run
from folding_client.cli import main
from folding_client.evaluation.evaluating_runs import require_scipy
from folding_client.evaluation.evaluation_constants import CONSTANTS
from folding_client.evaluation.grouping import progress_curve
from folding_client.evaluation.progress_curves import Curve, curves_svg
from folding_client.evaluation.recorded_states import runs_in
from folding_client.evaluation.sequence_truth import step_class, truths_in
from folding_client.interrupts import UsageError
from folding_schemas.actions import AddVertex, Flip, Fold, Rotate
from folding_schemas.evaluation import METRICS, ProgressPoint, RunEvaluation, StepScores
from paths import ROOT

EXAMPLES = ROOT / "examples"


def steps_of(name: str) -> list[list[dict[str, Any]]]:
    document = example_program(name).model_dump(mode="json", exclude_none=True)
    steps: list[list[dict[str, Any]]] = document["steps"]
    return steps


def short_truth(folder: Path, *names: str, steps: int = 2) -> Path:
    """Sequences with the first steps of the cat's program."""
    for name in names:
        (folder / name).mkdir(parents=True)
        program = {"name": name, "steps": steps_of("cat")[:steps]}
        (folder / name / "program.json").write_text(json.dumps(program))
    return folder


def command(*words: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    return int(ended.value.code or 0)


class TestTruth:
    def test_examples_are_sequences_with_programs(self) -> None:
        found = truths_in(EXAMPLES)
        assert list(found) == ["cat", "cup", "heart"]
        assert [truth.frames for truth in found.values()] == [9, 8, 16]

    def test_a_folder_of_programs_is_truth_too(self) -> None:
        assert list(truths_in(EXAMPLES / "programs")) == ["cat", "cup", "heart"]

    @pytest.mark.reference("programs")
    def test_published_programs_are_read(self) -> None:
        from reference_data import REFERENCE

        assert len(truths_in(REFERENCE / "programs")) == 4

    def test_only_named_sequences_are_planned(self) -> None:
        assert list(truths_in(EXAMPLES, ["cup"])) == ["cup"]

    @pytest.mark.parametrize(
        ("names", "said"), [(["dog"], "holds no sequence 'dog'; it holds cat, cup, heart")], ids=["dog"]
    )
    def test_an_unknown_sequence_is_refused(self, names: list[str], said: str) -> None:
        with pytest.raises(UsageError, match=said):
            truths_in(EXAMPLES, names)

    def test_a_folder_without_truth_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(UsageError, match="holds no truth"):
            truths_in(tmp_path)
        with pytest.raises(UsageError, match="There is no folder"):
            truths_in(tmp_path / "nowhere")

    def test_states_go_before_a_program(self, tmp_path: Path) -> None:
        folder = short_truth(tmp_path, "cat") / "cat"
        (folder / "states").mkdir()
        for frame in (1, 2, 3):
            (folder / "states" / f"{frame:06}.fold").write_text("{}")
        derived = [
            {"frame": 2, "actions": [{"action": "rotate", "angle": 45}]},
            {"frame": 3, "actions": None},
        ]
        (folder / "derivation.json").write_text(json.dumps({"steps": derived}))
        truth = truths_in(tmp_path)["cat"]
        assert len(truth.state_files) == 3
        assert truth.classes == {2: "rotate", 3: "unknown"}

    def test_steps_are_classed_by_what_they_do(self) -> None:
        vertex, fold = AddVertex(edge=(1, 2), position=0.5), Fold(edge=(1, 3), direction=1)
        assert step_class((vertex, fold)) == "fold"
        assert step_class((fold, Flip(axis="x"))) == "compound"
        assert step_class((Rotate(angle=3), Rotate(angle=4))) == "rotate"
        assert step_class(()) == "none"
        assert step_class(None) == "unknown"


class TestRuns:
    def test_runs_are_found_below_a_folder(self, tmp_path: Path) -> None:
        write_run(tmp_path / "a" / "cat", "cat", steps_of("cat")[:2], frames=3)
        write_run(tmp_path / "b" / "cat", "cat", [], frames=3, model="litellm/x", variant="vlm-s")
        found = runs_in([tmp_path])
        assert [(run.path, run.label, run.frames_saved) for run in found] == [
            ("a/cat", "geometric", 3),
            ("b/cat", "litellm/x vlm-s", 1),
        ]
        assert (found[0].queries, found[0].cost) == (4, 0.25)

    def test_a_folder_without_runs_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(UsageError, match="There is no run in"):
            runs_in([tmp_path])

    def test_a_run_that_was_cut_short_is_read_from_its_log(self, tmp_path: Path) -> None:
        folder = write_run(tmp_path / "cat", "cat", [], frames=9, status="interrupted", reason="Ctrl-C")
        (folder / "checkpoints.json").unlink()
        first, second = steps_of("cat")[:2]
        saved = [(1, []), (2, first), (3, second), (3, first)]
        lines = [
            {
                "kind": "result",
                "name": "save_checkpoint",
                "is_error": False,
                "structured": {"frame": frame, "actions": actions},
            }
            for frame, actions in saved
        ]
        stamps = {"time": "2026-01-01T00:00:00+00:00", "elapsed": 0.0}
        text = "".join(json.dumps({"seq": n, **stamps, **line}) + "\n" for n, line in enumerate(lines, 1))
        (folder / "events.jsonl").write_text(text)
        (run,) = runs_in([folder])
        assert [[action.action for action in step] for step in run.steps] == [["rotate"], ["rotate"]]

    def test_without_scipy_one_sentence_says_what_to_install(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setitem(sys.modules, "scipy", None)
        with pytest.raises(UsageError) as refusal:
            require_scipy()
        assert "pip install 'foldingagent-mcp[evaluate]'" in str(refusal.value)


def evaluated_run(values: list[float]) -> RunEvaluation:
    """A run whose scores at its steps are these."""
    steps = [
        StepScores(
            frame=frame,
            action_class="fold",
            saved=True,
            equal=False,
            problem="",
            scores=dict.fromkeys(METRICS, value),
            parts={},
        )
        for frame, value in enumerate(values, start=2)
    ]
    return RunEvaluation(
        sequence="s",
        run="s",
        status="complete",
        reason="",
        frames=len(values) + 1,
        frames_saved=len(values) + 1,
        complete=True,
        queries=0,
        input_tokens=0,
        output_tokens=0,
        cost=None,
        seconds=0,
        steps=steps,
    )


class TestCurves:
    def test_every_sequence_counts_at_every_point(self) -> None:
        short, long = evaluated_run([1.0, 0.0]), evaluated_run([1.0] * 8 + [0.5] * 2)
        curve = [point.means["SIM"] for point in progress_curve([short, long], 10)]
        assert curve == [1.0] * 5 + [0.5] * 3 + [0.25] * 2

    def test_a_drawing_has_a_panel_for_each_metric_and_a_line_for_each_model(self) -> None:
        points = [ProgressPoint(progress=share, means=dict.fromkeys(METRICS, 0.5)) for share in (0.5, 1.0)]
        drawn = curves_svg([Curve("geometric", points), Curve("<script>", points)])
        tree = ET.fromstring(drawn)
        assert len([e for e in tree.iter() if e.tag.endswith("polyline")]) == 2 * 6
        assert "&lt;script&gt;" in drawn


def test_the_constants_are_all_in_the_results_and_cannot_be_changed() -> None:
    assert CONSTANTS.described()["topology"] == {"vertices": 0.2, "edges": 0.3, "faces": 0.3, "letters": 0.2}
    with pytest.raises(AttributeError):
        CONSTANTS.resamples = 3  # type: ignore[misc]


@pytest.mark.slow
def test_a_table_has_what_was_planned_and_the_same_inputs_give_the_same_bytes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = short_truth(tmp_path / "truth", "done", "half", "never")
    right = steps_of("cat")[:2]
    write_run(tmp_path / "runs" / "done", "done", right, frames=3)
    write_run(
        tmp_path / "runs" / "half", "half", right[:1], frames=3, status="stopped", reason="no attempt is left"
    )
    write_run(tmp_path / "runs" / "other", "other", right, frames=3)
    outputs = []
    for name in ("one", "two"):
        out = tmp_path / name
        assert command("evaluate", tmp_path / "runs", "--truth", truth, "-o", out, "--json") == 0
        told = capsys.readouterr()
        assert "Left out, since the truth does not have them: other." in told.err
        assert told.out == (out / "evaluation.json").read_text()
        outputs.append([file.read_bytes() for file in sorted(out.iterdir())])
    assert outputs[0] == outputs[1]
    schema = json.loads((Path(folding_schemas.__file__).parent / "evaluation.schema.json").read_text())
    jsonschema.validate(json.loads(outputs[0][1]), schema)
    (group,) = json.loads(outputs[0][1])["groups"]
    assert (group["planned"], group["completed"]) == (3, 1)
    assert group["last"]["CV"]["mean"] == pytest.approx(1 / 3, abs=1e-6)
    assert group["last_completed"]["TSS"]["mean"] == 1
    assert {(each["status"], each["reason"]) for each in group["endings"]} == {
        ("complete", ""),
        ("stopped", "no attempt is left"),
        ("not run", ""),
    }
    assert [step["equal"] for step in group["runs"][1]["steps"]] == [True, False]
    with (tmp_path / "one" / "steps.csv").open(newline="") as file:
        assert len(list(csv.DictReader(file))) == 6
    assert command("evaluate", tmp_path / "runs", "--truth", truth, "-q") == 0
    assert "completed sequences" in capsys.readouterr().out


@pytest.mark.slow
def test_the_truth_is_folded_of_the_sheet_that_its_program_gives(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A sheet that is not quite square has a vertex more after step 2, so that its step 3 is refused on the square."""

    def folded(first: int) -> list[list[dict[str, Any]]]:
        return [
            [{"action": "fold", "edge": [2, 4], "direction": 1}],
            [
                {"action": "add_vertex", "edge": [4, 2], "position": 0.5},
                {"action": "fold", "edge": [5, 3], "direction": -1},
            ],
            [
                {"action": "add_vertex", "edge": [4, 1], "position": 0.9},
                {"action": "add_vertex", "edge": [5, 4], "position": 0.2},
                {"action": "fold", "edge": [first, first + 1], "direction": -1},
            ],
        ]

    truth = tmp_path / "truth" / "a"
    truth.mkdir(parents=True)
    (truth / "program.json").write_text(json.dumps({"sheet": [1.0, 0.995], "steps": folded(7)}))
    folder = write_run(tmp_path / "run", "a", folded(6), frames=4)
    assert command("evaluate", folder, "--truth", truth, "--json", "-q") == 0
    (group,) = json.loads(capsys.readouterr().out)["groups"]
    steps = group["runs"][0]["steps"]
    assert [step["problem"] for step in steps] == ["", "", ""]
    assert [step["equal"] for step in steps] == [False] * 3, "they are of another sheet, by 0.005"
    for step in steps:
        assert step["scores"]["CV"] == 1
        assert step["scores"]["GS"] > 0.95 and step["scores"]["FFS"] > 0.95, step["scores"]


@pytest.mark.slow
def test_crease_patterns_without_a_simulator_are_scored(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One that folds as the truth does, and one that is torn."""
    truth = short_truth(tmp_path / "truth", "a", steps=2)
    folder = write_run(tmp_path / "run", "a", [], frames=3, variant="vlm-cp", model="litellm/x")
    flat = {
        "frame_classes": ["creasePattern"],
        "vertices_coords": [[0, 1], [1, 1], [1, 0], [0, 0]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0]],
        "edges_assignment": ["B", "B", "B", "B"],
    }
    torn = {**flat, "edges_vertices": [[0, 1], [1, 2], [2, 3]], "edges_assignment": ["B"] * 3}
    (folder / "patterns.json").write_text(json.dumps({"sequence": "a", "patterns": [flat, flat, torn]}))
    assert command("evaluate", folder, "--truth", truth, "--json", "-q") == 0
    (group,) = json.loads(capsys.readouterr().out)["groups"]
    first, second = group["runs"][0]["steps"]
    assert (first["scores"]["CV"], first["scores"]["TSS"], first["equal"]) == (1, 1, False)
    assert (second["scores"]["CV"], second["scores"]["FFS"]) == (0, 0.3)
    assert group["completed"] == 1
