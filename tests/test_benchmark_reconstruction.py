"""The reconstruction benchmark: what counts as exact, how errors are measured, the programs, a small run."""

import json
from collections.abc import Mapping
from math import dist
from pathlib import Path
from typing import Any

import corpus
import pytest
import run
import studio
from corpus import Subject
from exactness import exactness
from folding_schemas.actions import Action, AddVertex, Flip, Fold, Program, Rotate, Unfold
from folding_server.photographer.replaying import keyframe_papers
from folding_server.simulator import Paper, replay, rotate
from hypothesis import given
from hypothesis import strategies as st
from papers import RESULTS
from reconstructing import Reconstruction, run_agent, solve, step_seconds
from report import in_words
from scoring import action_class, overall, score
from sheet import folded_between, line_error, turned
from silhouette import silhouette_iou

DIAGONAL: tuple[Action, ...] = (Fold(edge=(1, 3), direction=1),)
SMALL = Program(name="small", steps=(DIAGONAL, (Flip(axis="x"),)))


def halved(position: float = 0.5, direction: int = 1) -> list[Action]:
    """A sheet folded across, the crease a part of the way down."""
    fold = Fold(edge=(5, 6), direction=1 if direction > 0 else -1)
    return [AddVertex(edge=(1, 4), position=position), AddVertex(edge=(2, 3), position=position), fold]


def made(*steps: tuple[Action, ...], completed: bool = True) -> Reconstruction:
    return Reconstruction(
        steps, (1.0,) * len(steps), 0.5, 100.0, completed, "" if completed else "lost sight"
    )


def subject(*steps: tuple[Action, ...]) -> Subject:
    return Subject("paper", Path("paper"), Program(name="paper", steps=steps), 0.02)


# Exactness


@given(st.floats(0.2, 0.8))
def test_a_paper_is_exactly_itself(position: float) -> None:
    paper = replay(halved(position))
    assert exactness(paper, paper).holds()


def test_a_crease_may_be_off_by_less_than_the_tolerance() -> None:
    assert exactness(replay(halved(0.4)), replay(halved(0.415))).holds()
    assert not exactness(replay(halved(0.4)), replay(halved(0.43))).holds()
    assert exactness(replay(halved(0.4)), replay(halved(0.425)), 0.03).holds(0.03)


def test_which_corner_is_called_the_first_does_not_matter() -> None:
    other: list[Action] = [
        AddVertex(edge=(1, 2), position=0.4),
        AddVertex(edge=(4, 3), position=0.4),
        Fold(edge=(5, 6), direction=-1),
    ]
    assert exactness(replay(halved(0.4)), replay(other)).holds()


def test_the_same_creases_with_other_layers_on_top_are_not_exact() -> None:
    over: list[Action] = [*halved(0.4), Flip(axis="y")]
    found = exactness(replay(halved(0.4)), replay(over))
    assert (found.farthest, found.creases, found.order) == (0.0, 1.0, 0.0)


def test_a_crease_left_flat_is_not_a_folded_one() -> None:
    assert exactness(replay(halved()), replay([*halved(), Unfold()])).creases == 0.0


def test_a_crease_too_many_is_not_exact() -> None:
    marked = [*DIAGONAL, Unfold(), Fold(edge=(2, 4), direction=1)]
    found = exactness(replay(DIAGONAL), replay(marked))
    assert found.farthest < 1e-9
    assert found.creases < 1.0


# Fold lines


def creases(*actions: Action) -> list[Any]:
    *before, last = actions
    return folded_between(replay(before), replay([*before, last]))


@given(st.floats(0.2, 0.8), st.floats(-0.1, 0.1))
def test_the_error_of_a_parallel_fold_line_is_its_distance(position: float, off: float) -> None:
    assert line_error(creases(*halved(position)), creases(*halved(position + off))) == pytest.approx(
        abs(off), abs=1e-9
    )


def test_a_fold_of_two_layers_makes_a_crease_on_each() -> None:
    across: list[Action] = [
        AddVertex(edge=(5, 6), position=0.5),
        AddVertex(edge=(1, 2), position=0.5),
        Fold(edge=(7, 8), direction=1),
    ]
    assert len(creases(*halved(), *across)) == 2


def test_nothing_folded_has_no_error() -> None:
    assert line_error(creases(*halved()), []) is None


def test_four_quarters_bring_a_place_back() -> None:
    place = (0.2, 0.9)
    assert dist(turned(place, 4), place) < 1e-12
    assert turned(place, 1) != place


# Classes, silhouettes, seconds


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ((*halved(),), (Fold(edge=(1, 3), direction=-1),)),
        ((Flip(axis="y=x"),), (Flip(axis="x"), Rotate(angle=90))),
        ((Flip(axis="x"), Flip(axis="y")), (Rotate(angle=180),)),
        ((), (Rotate(angle=360),)),
        ((Rotate(angle=45), *DIAGONAL), (*DIAGONAL, Rotate(angle=-45))),
    ],
)
def test_different_ways_to_say_the_same_are_of_one_class(
    one: tuple[Action, ...], other: tuple[Action, ...]
) -> None:
    assert action_class(one) == action_class(other)


def test_two_folds_are_not_one_fold_and_an_unfold_is_neither() -> None:
    steps: list[tuple[Action, ...]] = [
        DIAGONAL,
        DIAGONAL * 2,
        (Unfold(),),
        (Flip(axis="x"),),
        (Rotate(angle=5),),
        (),
    ]
    assert len({action_class(step) for step in steps}) == len(steps)


def test_silhouettes_are_compared_without_the_drift_of_the_sheet() -> None:
    paper = replay(DIAGONAL)
    assert silhouette_iou(paper, rotate(paper, 8.3)) > 0.99
    assert silhouette_iou(paper, replay([])) < 0.75
    assert silhouette_iou(paper, rotate(paper, 180)) < 0.75


def test_seconds_of_a_run_are_told_by_frame(tmp_path: Path) -> None:
    told = [("step_started", 1, 2.0), ("step_over", 1, 2.5), ("step_started", 2, 2.5), ("step_over", 2, 4.0)]
    told += [("step_started", 3, 4.0), ("step_over", 3, 5.0), ("step_started", 2, 5.0), ("step_over", 2, 8.0)]
    events = [{"kind": kind, "frame": frame, "elapsed": elapsed} for kind, frame, elapsed in told]
    file = tmp_path / "events.jsonl"
    file.write_text("".join(json.dumps(event) + "\n" for event in [*events, {"kind": "call"}]))
    assert step_seconds(file) == (2.5, (4.5, 1.0))
    assert step_seconds(tmp_path / "missing") == (0.0, ())


# Scores


def test_the_true_program_scores_full_marks() -> None:
    full = score(subject(*SMALL.steps), made(*SMALL.steps))
    assert full.completed and full.final_exact and full.lost_at is None
    assert (full.class_right, full.fold_line_error) == (1.0, 0.0)
    assert full.silhouette_iou > 0.99
    assert in_words(full) == "paper: exact in all 3 frames"


def test_what_is_lacking_counts_as_wrong() -> None:
    short = score(subject(*SMALL.steps), made(SMALL.steps[0], completed=False))
    assert (short.completed, short.final_exact, short.lost_at) == (False, False, 3)
    assert (short.class_right, short.silhouette_iou) == (0.5, 0.0)
    assert "lost sight" in in_words(short)


def test_the_first_frame_that_is_not_exact_is_told() -> None:
    wrong: tuple[Action, ...] = (Fold(edge=(1, 3), direction=-1), Flip(axis="y"))
    lost = score(subject(DIAGONAL, (Flip(axis="x"),)), made((Rotate(angle=45),), wrong))
    assert lost.lost_at == 2
    assert lost.class_right == 0.0


def test_a_fold_that_was_not_found_pulls_the_median_error_up() -> None:
    true = subject(DIAGONAL, (Unfold(),), DIAGONAL)
    assert score(true, made(DIAGONAL, (Unfold(),), ())).fold_line_error is None
    assert score(true, made(DIAGONAL, (Unfold(),), DIAGONAL)).fold_line_error == 0.0


def test_the_overall_figures_take_all_sequences_together() -> None:
    right = score(subject(*SMALL.steps), made(*SMALL.steps))
    wrong = score(subject(*SMALL.steps), made((), ()))
    total = overall([right, wrong])
    assert (total.sequences, total.transitions) == (2, 4)
    assert (total.final_exact, total.class_right) == (0.5, 0.5)


# The programs


@pytest.fixture(scope="module")
def programs() -> Mapping[str, Program]:
    return corpus.programs()


def test_there_are_thirty_programs_of_five_to_twenty_one_keyframes(programs: Mapping[str, Program]) -> None:
    lengths = [len(program.steps) + 1 for program in programs.values()]
    assert len(programs) >= 30
    assert min(lengths) >= 5
    assert max(lengths) <= 21
    assert 10 <= sum(lengths) / len(lengths) <= 14


def test_every_program_can_be_folded_and_together_they_do_everything(programs: Mapping[str, Program]) -> None:
    done = {kinds for program in programs.values() for kinds in map(action_class, program.steps)}
    assert {("fold",), ("unfold",), ("rotate",), ("flip",), ("fold", "fold")} <= done
    assert all(len(keyframe_papers(program)) == len(program.steps) + 1 for program in programs.values())


@pytest.mark.parametrize("path", RESULTS)
def test_recorded_actions_become_one_step_for_each_motion(path: Path) -> None:
    recorded = corpus.recorded(path.read_text(encoding="utf-8"))
    assert len(recorded.steps) > 1
    assert all(
        [a.action == "add_vertex" for a in step] == [True] * (len(step) - 1) + [False]
        for step in recorded.steps
    )


def test_a_sequence_with_its_truth_tells_the_program_that_makes_its_papers(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    place = studio.photographed(SMALL, 1, 1, tmp_path)
    monkeypatch.setattr(corpus, "RENDERED", tmp_path)
    (item,) = corpus.rendered().values()
    assert item.folder == place
    assert [len(step) for step in item.truth.steps] == [len(step) for step in SMALL.steps]
    _agrees(keyframe_papers(item.truth)[-1], json.loads((place / "truth.json").read_text())["frames"][-1])


@pytest.mark.reference("photos/rendered")
def test_rendered_programs_make_the_papers_of_their_truth() -> None:
    subjects = corpus.rendered()
    assert len(subjects) == 2
    for item in subjects.values():
        _agrees(
            keyframe_papers(item.truth)[-1],
            json.loads((item.folder / "truth.json").read_text())["frames"][-1],
        )


def _agrees(paper: Paper, frame: dict[str, Any]) -> None:
    for vertex in frame["vertices"].values():
        near = min(paper.vertices_coords, key=lambda v: dist(paper.vertices_coords[v], vertex["sheet"]))
        assert dist(paper.vertices_coords[near], vertex["sheet"]) < 2e-3
        assert dist(paper.folded_vertices_coords[near], vertex["folded"]) < 2e-3


# Running


def test_photographs_are_taken_once_for_a_program_seed_and_level(tmp_path: Path) -> None:
    first = studio.photographed(SMALL, 1, 1, tmp_path)
    stamp = (first / "truth.json").stat().st_mtime_ns
    assert studio.photographed(SMALL, 1, 1, tmp_path) == first
    assert (first / "truth.json").stat().st_mtime_ns == stamp
    assert studio.folded_truth(first).steps == SMALL.steps
    assert studio.seed_of("small", 1) != studio.seed_of("small", 2) != studio.seed_of("large", 2)


@pytest.mark.slow
def test_the_solver_finds_the_same_again(tmp_path: Path) -> None:
    place = studio.photographed(SMALL, 1, 1, tmp_path)
    once, again = solve(place), solve(place)
    assert once.completed and once.steps == again.steps
    assert once.memory_mb > 10


def test_a_folder_without_photos_is_not_completed(tmp_path: Path) -> None:
    for attempt in (solve(tmp_path), run_agent(tmp_path)):
        assert not attempt.completed
        assert "keyframes.json" in attempt.reason


@pytest.mark.slow
@pytest.mark.parametrize("between", [0, 1])
def test_a_run_prints_one_json_document(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, between: int
) -> None:
    monkeypatch.setattr(corpus, "programs", lambda: {"small": SMALL})
    cache, found = tmp_path / "cache", tmp_path / "found"
    run.main(["--json", "--cache", str(cache), "--between", str(between), "-o", str(found)])
    printed = json.loads(capsys.readouterr().out)
    assert printed["between"] == between
    (folder,) = cache.iterdir()
    assert len(list((folder / "frames").iterdir())) == 3 + 2 * between
    assert len(json.loads((found / "small.json").read_text())["steps"]) == 2
    assert printed["overall"]["completed"] == printed["overall"]["final_exact"] == 1.0
    assert [s["sequence"] for s in printed["sequences"]] == ["small"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--programs", "unicorn"], "there is no program 'unicorn'"),
        (["--between", "40"], "there cannot be 40 images in between; give 0 to 30"),
    ],
)
def test_what_cannot_be_run_is_refused_in_one_line(
    capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    with pytest.raises(SystemExit) as stopped:
        run.main(arguments)
    assert stopped.value.code == 2
    assert words in capsys.readouterr().err.splitlines()[-1]
