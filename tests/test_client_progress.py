"""What a person sees of a run: progress on the way, a summary at the end that says which steps do not fit."""

import asyncio
import io
import json
import time
from pathlib import Path

import pytest
from client_runs import (
    MATCH,
    MISMATCH,
    PLANTED_KEY,
    act,
    ask,
    restore,
    save,
    sequence,
    server_url,
    settings,
    shortened,
)
from folding_client.agent.toolbox import saved_against
from folding_client.messages import Usage
from folding_client.progress import Shown, spent
from folding_client.reconstruct import new_job, reconstruct
from folding_client.record.fits import Fit, FitRecord, FitSummary, fit_summary
from folding_client.record.totals import Totals
from paths import ROOT
from providers.base import Says
from providers.openai import OpenAI
from rich.console import Console
from test_client_commands import command

MODEL = "litellm/openai/gpt-4o"
TURN = {"action": "rotate", "angle": 45.0}


@pytest.fixture(autouse=True)
def key(monkeypatch: pytest.MonkeyPatch) -> None:
    """A key for the provider."""
    monkeypatch.setenv("OPENAI_API_KEY", PLANTED_KEY)


def shown(out: Path, *, verbose: bool = False) -> str:
    """What is printed of a run with one failed attempt, in which the model says something with brackets in it."""
    said = Says("I fold [red]the flap[/nope].", calls=[("rotate", {"angle": 45.0})], thinking="")
    text = io.StringIO()
    console = Console(file=text, force_terminal=False, width=400, color_system=None)
    turns = (
        save(1),
        act(TURN),
        ask(2, "rotate"),
        MISMATCH,
        restore(1),
        said,
        ask(2, "rotate"),
        MATCH,
        save(2),
    )
    with OpenAI(*turns) as provider, Shown(console, verbose=verbose) as progress:
        job = new_job(sequence(2), out, settings(model=MODEL, api_base=provider.url))
        assert asyncio.run(reconstruct(job, progress)).status == "complete"
    return text.getvalue()


def test_off_a_terminal_each_step_and_attempt_is_a_line_with_what_it_took(tmp_path: Path) -> None:
    lines = shown(tmp_path / "run").splitlines()
    assert [line.partition(" (0:")[0] for line in lines] == [
        "0 of 2 frames done, working on frame 1",
        "1 of 2 frames done, working on frame 2; 1 query, 1,050 tokens, $0.0030",
        "1 of 2 frames done, working on frame 2, attempt 2; 5 queries, 5,250 tokens, $0.0150; last verdict MISMATCH",
    ]


def test_on_a_terminal_the_line_says_what_the_model_says() -> None:
    text = io.StringIO()
    console = Console(file=text, force_terminal=True, width=400, color_system=None)
    said = {"role": "agent", "text": "I fold [red]the\n flap[/nope].", "thinking": "", "calls": []}
    with Shown(console) as progress:
        progress.step(2, 9, 1)
        progress.told("reply", said, {"agent": Totals().plus(Usage(900, 100, cost=0.25), 1.0)})
        time.sleep(0.5)  # the line is drawn anew several times a second
    assert (
        "1 of 9 frames done, working on frame 2; 1 query, 1,000 tokens, $0.2500: thinking" in text.getvalue()
    )
    assert '"I fold [red]the flap[/nope]."' in text.getvalue()


def test_verbose_prints_all_that_models_say_and_call(tmp_path: Path) -> None:
    text = shown(tmp_path / "run", verbose=True)
    assert "agent: I fold [red]the flap[/nope].\n" in text
    assert 'agent calls rotate({"angle": 45.0})\n' in text
    assert "critic on frame 2: MISMATCH. The flap is too long.\n" in text


def test_the_summary_names_the_steps_that_do_not_fit_and_what_the_run_took(tmp_path: Path) -> None:
    turns = (
        save(1),
        act(TURN),
        ask(2, "rotate"),
        MATCH,
        save(2),
        act(TURN),
        ask(3, "rotate"),
        MISMATCH,
        save(3),
    )
    with OpenAI(*turns) as provider:
        words = ("--model", MODEL, "--api-base", provider.url, "--server-url", server_url(), "-q")
        done = command("run", sequence(3), "--out", tmp_path / "run", *words)
    assert done.returncode == 0
    assert done.stderr == ""
    assert "1 of 2 steps match; doubtful frames: 3 (MISMATCH).\n" in done.stdout
    assert "9 queries, 9,450 tokens, $0.0270.\n" in done.stdout
    assert "  2 -> 3  rotate(45.0)  (not a match)\n" in done.stdout
    assert "Most steps" not in done.stdout


def test_a_run_whose_steps_mostly_do_not_fit_is_no_success(tmp_path: Path) -> None:
    turns = (save(1), act(TURN), ask(2, "rotate"), MISMATCH, save(2))
    with OpenAI(*turns, *turns) as provider:
        words = ("--model", MODEL, "--api-base", provider.url, "--server-url", server_url())
        done = command("run", sequence(2), "--out", tmp_path / "run", *words)
        (tmp_path / "list.txt").write_text(str(sequence(2)))
        batch = command("batch", tmp_path / "list.txt", "--out", tmp_path / "runs", *words, "--json")
    assert (done.returncode, batch.returncode) == (4, 4)
    assert "Most steps of this program do not fit their photos." in done.stdout
    assert "complete, 2 of 2 frames, 0 of 1 steps match" in batch.stderr
    (line,) = json.loads(batch.stdout)
    assert (line["steps"], line["matching"], line["doubtful"], line["tokens"]) == (1, 0, [2], 5250)


@pytest.mark.slow
def test_the_geometric_model_says_how_well_each_step_fits(tmp_path: Path) -> None:
    cat = shortened(ROOT / "examples" / "cat", tmp_path / "cat", 3)
    done = command("run", cat, "--out", tmp_path / "run", "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert (document["steps"], document["matching"], document["doubtful"]) == (2, 2, [])
    fits = document["fits"]
    assert [fits[frame]["by"] for frame in ("2", "3")] == ["comparison"] * 2
    assert all(0.9 < fits[frame]["agreement"] <= 1 for frame in fits)
    assert json.loads((tmp_path / "run" / "run.json").read_text())["fits"] == fits


def test_a_summary_is_one_line() -> None:
    fits = {str(frame): {"verdict": "MATCH", "agreement": 0.97, "by": "comparison"} for frame in range(2, 9)}
    doubt = {"verdict": "MISMATCH", "by": "comparison"}
    found = fit_summary(
        fits
        | {"4": doubt | {"agreement": 0.81}, "7": doubt | {"agreement": 0.77}}
        | {"9": {"verdict": None, "agreement": None, "by": None}}
    )
    assert found.text == "5 of 8 steps match; doubtful frames: 4 (0.81), 7 (0.77); not compared: 9"
    assert not found.mostly_doubtful
    assert FitSummary(1, 0, {2: Fit(None, None, "selector")}, ()).text == (
        "0 of 1 steps match; doubtful frames: 2 (chosen among the attempts)"
    )


def test_an_undo_that_ends_an_attempt_begins_another_on_the_line(tmp_path: Path) -> None:
    undo = Says(calls=[("undo", {})])
    text = io.StringIO()
    console = Console(file=text, force_terminal=False, width=400, color_system=None)
    turns = (save(1), act(TURN), undo, act(TURN), save(2))
    with OpenAI(*turns) as provider, Shown(console) as progress:
        job = new_job(sequence(2), tmp_path / "run", settings(model=MODEL, api_base=provider.url))
        assert asyncio.run(reconstruct(job, progress)).status == "complete"
    assert [line.partition(";")[0].partition(" (0:")[0] for line in text.getvalue().splitlines()] == [
        "0 of 2 frames done, working on frame 1",
        "1 of 2 frames done, working on frame 2",
        "1 of 2 frames done, working on frame 2, attempt 2",
    ]


def test_a_model_that_asks_nobody_has_no_queries_to_tell_of() -> None:
    assert spent({"agent": Totals(queries=7)}) == ""
    assert spent({"agent": Totals(queries=1, input_tokens=9)}).startswith("1 query, 9 tokens")


def test_what_was_saved_against_the_critic_is_read_back_from_the_record() -> None:
    def saved(frame: int) -> dict[str, object]:
        return {
            "kind": "result",
            "name": "save_checkpoint",
            "is_error": False,
            "structured": {"frame": frame},
        }

    said = [{"kind": "saved_against", "frame": frame, "verdict": "MISMATCH"} for frame in (2, 3, 4)]
    events = [
        saved(2),
        said[0],
        saved(3),
        said[1],
        saved(4),
        said[2],
        saved(3),
        {"kind": "selected", "frame": 4},
    ]
    assert saved_against(events) == {2: "MISMATCH"}


def called(
    name: str, arguments: dict[str, object], answer: dict[str, object]
) -> list[tuple[str, dict[str, object]]]:
    """The events of a call that was answered."""
    result = {"name": name, "is_error": False, "structured": answer}
    return [("call", {"arguments": {"run_id": "r1", **arguments}}), ("result", result)]


def fit_after(proposed: dict[str, object], done: dict[str, object], confidence: float) -> Fit:
    """What is on record of frame 2 after a proposal and another action or the same, compared and saved."""
    first = {"actions": [proposed], "agreement": 0.99}
    record = FitRecord()
    for kind, data in [
        ("result", {"name": "open_run", "is_error": False, "structured": {"run_id": "r1"}}),
        *called(
            "propose_actions", {"frame": 2}, {"frame": 2, "proposals": [first], "confidence": confidence}
        ),
        *called(str(done["action"]), {k: v for k, v in done.items() if k != "action"}, {}),
        *called("compare_to_frame", {"frame": 2}, {"frame": 2, "verdict": "MATCH", "agreement": 0.99}),
        *called("save_checkpoint", {"frame": 2}, {"frame": 2}),
    ]:
        record.add(kind, data)
    return record.by_frame[2]


def test_a_match_that_the_server_is_not_sure_of_is_doubtful() -> None:
    turn, flip = {"action": "rotate", "angle": 45.0}, {"action": "flip", "axis": "x"}
    unsure, sure = fit_after(turn, turn, 0.4), fit_after(turn, turn, 0.95)
    assert (unsure.matches, unsure.is_doubtful, sure.is_doubtful) == (True, True, False)
    summary = FitSummary(1, 1, {2: unsure}, ())
    assert summary.text == "1 of 1 steps match; doubtful frames: 2 (confidence 0.40)"
    other = fit_after(turn, flip, 0.4)
    assert (other.confidence, other.is_doubtful) == (None, False)
