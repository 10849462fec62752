"""Measuring a critic: the figures, the wrong states by kind, and whole measurements with geometry and with a script."""

import json
from pathlib import Path
from typing import Any

import pytest
from client_runs import events, sequence, shortened
from folding_client.critic_accuracy.accuracy import TrueSequence, sequences_with_truth, states_to_judge
from folding_client.critic_accuracy.intervals import share_of
from folding_client.critic_accuracy.wrong_steps import KINDS
from folding_client.interrupts import UsageError
from folding_schemas.actions import Fold, Program, Rotate
from paths import ROOT
from test_client_commands import command

EXAMPLES = ROOT / "examples"


def cat(folder: Path, frames: int) -> Path:
    """The first frames of the cat with their program, alone in a folder."""
    folder.mkdir()
    short = shortened(EXAMPLES / "cat", folder / "cat", frames)
    program = json.loads((EXAMPLES / "cat" / "program.json").read_text())
    (short / "program.json").write_text(json.dumps(program | {"steps": program["steps"][: frames - 1]}))
    return folder


def verdicts(folder: Path, *words: str) -> str:
    """A script of a critic that says these verdicts."""
    entries = [
        {
            "role": "critic",
            "text": json.dumps(
                {
                    "verdict": word,
                    "analysis": "Seen.",
                    "anchor_check": "no anchor provided",
                    "discrepancies": [],
                }
            ),
        }
        for word in words
    ]
    (folder / "critic.json").write_text(json.dumps(entries))
    return f"scripted:{folder / 'critic.json'}"


@pytest.mark.parametrize(
    ("count", "of", "low", "high"),
    [(22, 25, 0.7004, 0.9583), (0, 10, 0.0, 0.2775), (10, 10, 0.7225, 1.0), (1, 2, 0.0945, 0.9055)],
)
def test_intervals_are_wilson_s(count: int, of: int, low: float, high: float) -> None:
    """By R's binom.confint(count, of, methods = "wilson")."""
    share = share_of(count, of)
    assert (share.low, share.high) == (pytest.approx(low, abs=5e-5), pytest.approx(high, abs=5e-5))
    assert share.share == count / of


def test_a_share_of_no_cases_is_not_known() -> None:
    assert share_of(0, 0).share is None
    assert share_of(0, 0).text == "no cases"


def test_every_kind_of_mistake_is_made_of_a_fold_and_a_wrong_flip_of_any_step() -> None:
    steps = ((Rotate(angle=45),), (Fold(edge=(4, 2), direction=-1),))
    found = states_to_judge([TrueSequence(Path("x"), steps)], right=False)
    assert [(state.frame, state.kind) for state in found] == [(2, "flip"), *((3, kind) for kind in KINDS)]


def measured(*words: object) -> dict[str, Any]:
    done = command("critic-accuracy", *words, "--json")
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.mark.slow
def test_geometry_tells_right_states_from_wrong_ones(tmp_path: Path) -> None:
    found = measured(cat(tmp_path / "all", 4), "--out", tmp_path / "out", "--count", 9)
    assert found["critic"] == "geometric"
    assert (found["false_mismatch"]["of"], found["false_match"]["of"]) == (3, 7)
    assert (found["refused"], found["alike"]) == (0, 2), "a triangle turned over, and a flap folded behind it"
    assert [found["false_match_by_kind"][kind]["of"] for kind in KINDS] == [2, 2, 1, 2]
    assert found["accuracy"]["share"] == 1
    assert json.loads((tmp_path / "out" / "accuracy.json").read_text()) == found
    assert len(events(tmp_path / "out", "verdict")) == 10


@pytest.mark.slow
def test_a_model_is_counted_by_what_it_says(tmp_path: Path) -> None:
    says = verdicts(
        tmp_path, "MATCH", "MISMATCH", "perfect", "no idea", "MATCH", "EXTREME DIVERGENCE", "MISMATCH"
    )
    found = measured(
        cat(tmp_path / "all", 4), "--critic", says, "--out", tmp_path / "out", "--count", 3, "--seed", 7
    )
    cases = found["cases"]
    assert [case["kind"] == "right" for case in cases] == [True] * 3 + [False] * 3
    assert [case["verdict"] for case in cases] == [
        "MATCH",
        "MISMATCH",
        None,
        "MATCH",
        "EXTREME DIVERGENCE",
        "MISMATCH",
    ]
    assert (found["accuracy"]["count"], found["accuracy"]["of"]) == (3, 6)
    assert (found["false_match"]["count"], found["false_match"]["of"]) == (1, 3)
    assert (found["false_mismatch"]["count"], found["false_mismatch"]["of"]) == (1, 3)
    assert found["no_verdict"]["count"] == 1
    assert found["cost"] is None


@pytest.mark.slow
def test_what_cuts_a_measurement_short_is_said_and_what_was_measured_is_kept(tmp_path: Path) -> None:
    says = verdicts(tmp_path, "MATCH")
    done = command("critic-accuracy", cat(tmp_path / "all", 4), "--critic", says, "--out", tmp_path / "out")
    assert done.returncode == 3
    assert "accuracy 100.0%" in done.stdout
    assert "has no reply after its 1" in done.stderr


def test_sequences_without_truth_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"None of the sequences holds the true program in a program\.json"):
        sequences_with_truth([sequence(2)])
    folder = cat(tmp_path / "all", 3)
    (folder / "cat" / "program.json").write_text("[")
    with pytest.raises(UsageError, match="cannot be read as a program"):
        sequences_with_truth([folder / "cat"])
    (folder / "cat" / "program.json").write_text('{"sheet": [1, 0.997], "steps": []}')
    with pytest.raises(UsageError, match=r"folds a sheet of 1 by 0\.997, and runs fold a square"):
        sequences_with_truth([folder / "cat"])


def test_the_programs_of_the_examples_are_read() -> None:
    (found,) = sequences_with_truth([EXAMPLES / "heart"])
    assert (
        found.steps == Program.model_validate_json((EXAMPLES / "heart" / "program.json").read_bytes()).steps
    )
