"""PurelandFold's files, made from programs of ours as that data set has them, become sequences with truth."""

import json
import sys
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest
from data_set_states import data_set_states
from evaluated import example_program, write_run
from folding_client.cli import main
from folding_client.data_sets.importing import write_imported
from folding_client.data_sets.purelandfold import purelandfold_sequences, with_folded_form
from folding_client.evaluation.sequence_truth import truths_in
from folding_client.interrupts import UsageError
from folding_schemas.actions import Fold, Program, Unfold
from folding_server.frames.sequences import load_sequence
from paths import ROOT
from pyarrow import parquet

PHOTO = (ROOT / "examples" / "cat" / "frames" / "000001.jpg").read_bytes()
DIAGONAL = Fold(edge=(4, 2), direction=1)
MARKED = Program(
    steps=(
        (DIAGONAL, Unfold(), Fold(edge=(1, 3), direction=1), Unfold()),
        (Fold(edge=(4, 2), direction=-1),),
    )
)


def rows(name: str, states: list[dict[str, Any]], *, first: int = 1) -> list[dict[str, Any]]:
    """The rows of a sequence, last step first: files need not be in order."""
    return [
        {
            "sequence": name,
            "step": step,
            "image": {"bytes": PHOTO, "path": f"{step}.jpg"},
            "cp.svg": "<svg/>",
            "cp.fold": json.dumps(state),
            "flat_folder": "ok",
        }
        for step, state in enumerate(states, start=first)
    ][::-1]


def write(file: Path, listed: list[dict[str, Any]]) -> Path:
    parquet.write_table(pa.Table.from_pylist(listed), file)
    return file


def command(*words: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    return int(ended.value.code or 0)


def test_rows_are_keyframes_in_the_order_of_their_steps(tmp_path: Path) -> None:
    states = data_set_states(Program(steps=((DIAGONAL,),)))
    file = write(tmp_path / "data.parquet", [*rows("b", states), *rows("a", states, first=0)])
    found = purelandfold_sequences(file)
    assert list(found) == ["a", "b"]
    assert [frame.step for frame in found["a"]] == [0, 1]
    assert [json.loads(frame.fold or "") for frame in found["b"]] == states
    assert found["b"][0].photo == PHOTO


def test_a_written_sequence_is_one_that_the_server_reads(tmp_path: Path) -> None:
    states = data_set_states(Program(steps=((DIAGONAL,),)))
    (frames,) = purelandfold_sequences(write(tmp_path / "data.parquet", rows("bird", states))).values()
    write_imported("bird", frames, tmp_path / "bird")
    assert load_sequence(tmp_path / "bird").name == "bird"
    assert len(list((tmp_path / "bird" / "given").glob("*.fold"))) == 2


def test_a_folded_form_may_stand_in_the_other_column() -> None:
    whole = data_set_states(Program(steps=((DIAGONAL,),)))[1]
    folded = whole["file_frames"][0]
    joined = json.loads(with_folded_form(json.dumps({**whole, "file_frames": []}), json.dumps(folded)))
    assert joined["file_frames"][0]["vertices_coords"] == folded["vertices_coords"]
    assert json.loads(with_folded_form(json.dumps(whole), "no JSON")) == whole


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"sequence": "../elsewhere"}, "cannot be the name of a folder"),
        ({"step": "first"}, "steps are whole numbers"),
        (None, "has no column 'cp.fold'"),
    ],
    ids=["path", "word", "column"],
)
def test_what_is_no_such_file_is_refused(tmp_path: Path, change: dict[str, Any] | None, said: str) -> None:
    (row, *_) = rows("a", data_set_states(Program(steps=())))
    if change is None:
        del row["cp.fold"]
    with pytest.raises(UsageError, match=said):
        purelandfold_sequences(write(tmp_path / "data.parquet", [{**row, **(change or {})}]))


def test_what_is_no_parquet_is_refused(tmp_path: Path) -> None:
    (tmp_path / "data.parquet").write_text("no")
    for file in (tmp_path / "data.parquet", tmp_path / "nowhere.parquet"):
        with pytest.raises(UsageError) as refusal:
            purelandfold_sequences(file)
        assert "\n" not in str(refusal.value)


def test_without_pyarrow_one_sentence_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(UsageError, match=r"pip install 'foldingagent-mcp\[datasets\]'"):
        purelandfold_sequences(tmp_path / "data.parquet")


@pytest.mark.slow
def test_a_data_set_becomes_truth_that_a_run_can_be_scored_against(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A whole program with flips, a start with creases, and a sequence without states."""
    cat = example_program("cat")
    lost = rows("lost", data_set_states(Program(steps=((DIAGONAL,),))))
    lost[0]["cp.fold"] = None
    file = write(
        tmp_path / "data.parquet",
        [*rows("cat", data_set_states(cat)), *rows("marked", data_set_states(MARKED)[1:]), *lost],
    )
    assert command("import-purelandfold", file, "-o", tmp_path / "truth", "--json") == 1
    told = {each["name"]: each for each in json.loads(capsys.readouterr().out)}
    assert (told["cat"]["derived"], told["cat"]["program"]) == (len(cat.steps), True)
    assert (told["marked"]["derived"], told["marked"]["program"]) == (1, True)
    assert "has no cp.fold" in told["lost"]["problem"]
    truths = truths_in(tmp_path / "truth")
    assert truths["cat"].classes[2] == "rotate"
    steps = cat.model_dump(mode="json", exclude_none=True)["steps"]
    write_run(tmp_path / "run", "cat", steps, frames=len(steps) + 1)
    given = "--truth", tmp_path / "truth", "--sequence", "cat", "--json", "-q"
    assert command("evaluate", tmp_path / "run", *given) == 0
    (group,) = json.loads(capsys.readouterr().out)["groups"]
    assert group["last"]["TSS"]["mean"] == 1
    assert group["last"]["SIM"]["mean"] > 0.99
    assert group["last"]["CPD"]["mean"] < 2
    assert command("import-purelandfold", file, "-o", tmp_path / "truth") == 2
    assert "is there already" in capsys.readouterr().err
