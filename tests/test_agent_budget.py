"""The agent's budget of attempts, by a scripted provider: through litellm, real HTTP, and the real folding server."""

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest
from client_runs import (
    MATCH,
    MISMATCH,
    act,
    ask,
    events,
    program,
    restore,
    resume,
    run,
    save,
    sequence,
    settings,
)
from folding_client.interrupts import UsageError
from folding_client.progress import Silent
from folding_client.reconstruct import new_job, reconstruct, resumed_job
from folding_client.record.replay import replay_run
from providers.base import Fails, Says
from providers.openai import OpenAI

MODEL = "litellm/openai/gpt-4o"
UNDO = Says(calls=[("undo", {})])
CUT_OFF = Says("I think", finish="length")
UNREADABLE = Says(silent=True)


def turn(angle: float) -> dict[str, Any]:
    """An action that rotates."""
    return {"action": "rotate", "angle": float(angle)}


def shown_to_the_selector(provider: OpenAI, query: int = -1) -> list[str]:
    """The names of the pictures that a query showed."""
    parts = provider.received[query]["messages"][1]["content"]
    return [part["text"] for part in parts[1:] if part["type"] == "text"]


@pytest.mark.slow
def test_undone_attempts_are_used_up_like_restored_ones(tmp_path: Path) -> None:
    rounds = [part for k in range(1, 6) for part in (act(turn(k)), ask(2, "rotate"), MISMATCH, UNDO)]
    with OpenAI(save(1), *rounds, Says("B3")) as provider:
        outcome = run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    assert program(tmp_path / "run") == [[turn(3)]]
    told = [event["structured"]["summary"] for event in events(tmp_path / "run", "result") if _acted(event)]
    assert [text.partition("Attempt ")[2] for text in told] == [f"{k} of 5 at frame 2." for k in range(1, 6)]


def _acted(event: dict[str, Any]) -> bool:
    return event["name"] == "rotate"


@pytest.mark.slow
def test_an_undo_within_an_attempt_goes_on_with_it(tmp_path: Path) -> None:
    on_the_way = [part for k in range(2, 9) for part in (act(turn(k)), UNDO)]
    with OpenAI(save(1), act(turn(1)), *on_the_way, save(2)) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    assert program(tmp_path / "run") == [[turn(1)]]


@pytest.mark.slow
def test_the_selector_sees_every_state_a_verdict_was_asked_about_and_can_choose_it(tmp_path: Path) -> None:
    flip = {"action": "flip", "axis": "x"}
    first = [act(turn(1)), ask(2, "rotate"), MISMATCH, act(flip), ask(2, "flip"), MISMATCH, restore(1)]
    rest = [part for k in range(2, 6) for part in (act(turn(k)), restore(1))]
    with OpenAI(save(1), *first, *rest, Says("B6")) as provider:
        outcome = run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    assert shown_to_the_selector(provider) == ["A: photo of frame 2", *(f"B{k}:" for k in range(1, 7))]
    assert program(tmp_path / "run") == [[turn(1)]]
    (selected,) = events(tmp_path / "run", "selected")
    assert (selected["attempt"], selected["state"], selected["rewrites"]) == (1, 1, [])


def test_replies_that_are_cut_off_or_unreadable_cost_no_attempt(tmp_path: Path) -> None:
    cut = [part for k in range(1, 7) for part in (act(turn(k)), CUT_OFF if k % 2 else UNREADABLE)]
    with OpenAI(save(1), *cut, act(turn(45)), ask(2, "rotate"), MATCH, save(2)) as provider:
        outcome = run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    assert events(tmp_path / "run", "selected") == []
    assert program(tmp_path / "run") == [[turn(45)]]
    assert len(events(tmp_path / "run", "rolled_back")) == 6
    assert "has had" not in provider.received[-3]["messages"][1]["content"][0]["text"]


@pytest.mark.slow
def test_a_technical_return_is_recorded_and_replayed_as_one(tmp_path: Path) -> None:
    cut = [part for k in range(1, 7) for part in (act(turn(k)), CUT_OFF)]
    with OpenAI(save(1), *cut, act(turn(45)), save(2)) as provider:
        run(2, tmp_path / "run", model=MODEL, api_base=provider.url, server_url=None)
    technical = [event for event in events(tmp_path / "run", "call") if event.get("technical")]
    assert [event["name"] for event in technical] == ["restore_checkpoint"] * 6
    assert asyncio.run(replay_run(tmp_path / "run")).differences == ()


def test_a_run_that_was_cut_short_goes_on_with_all_its_attempts(tmp_path: Path) -> None:
    with OpenAI(save(1), act(turn(1)), Fails(401)) as provider:
        run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    for _ in range(5):
        with OpenAI(act(turn(2)), Fails(401)) as provider:
            resume(tmp_path / "run", api_base=provider.url)
    with OpenAI(act(turn(45)), save(2)) as provider:
        assert resume(tmp_path / "run", api_base=provider.url).status == "complete"
    assert program(tmp_path / "run") == [[turn(45)]]


def test_the_model_cannot_claim_a_technical_reason(tmp_path: Path) -> None:
    claim = Says(calls=[("restore_checkpoint", {"frame": 1, "foldingagent/technical-return": True})])
    with OpenAI(save(1), act(turn(1)), claim, act(turn(2)), save(2)) as provider:
        run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert "its arguments are: frame" in provider.received[3]["messages"][-1]["content"]


def test_a_frame_is_tried_anew_after_an_earlier_one_was_mended(tmp_path: Path) -> None:
    """Five attempts at frame 3 are used up in part by going back; the mended frame 2 is not overwritten."""
    failing = [part for k in range(1, 5) for part in (act(turn(k)), restore(2))]
    mended = [act(turn(5)), restore(1), act(turn(90)), save(2)]
    with OpenAI(save(1), act(turn(45)), save(2), *failing, *mended, act(turn(7)), save(3)) as provider:
        outcome = run(3, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    assert events(tmp_path / "run", "selected") == []
    assert program(tmp_path / "run") == [[turn(90)], [turn(7)]]


def test_candidates_from_other_frames_are_shown_as_such_and_the_choice_says_what_it_rewrites(
    tmp_path: Path,
) -> None:
    before = [act(turn(1)), restore(1), act(turn(90)), save(2)]
    spent = [part for k in range(2, 7) for part in (act(turn(k)), restore(2))]
    with OpenAI(save(1), act(turn(45)), save(2), *before, *spent, Says("B6")) as provider:
        outcome = run(3, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    assert shown_to_the_selector(provider)[-2:] == [
        "B5:",
        "B6: (from other frames; choosing it rewrites frames 2)",
    ]
    assert "B6 grew from other earlier frames" in provider.received[-1]["messages"][1]["content"][0]["text"]
    assert program(tmp_path / "run") == [[turn(45)], [turn(1)]]
    (committed,) = [each for each in events(tmp_path / "run", "result") if each["name"] == "commit_attempt"]
    assert committed["structured"]["rewritten"] == [2]


def test_three_mended_states_are_all_that_a_frame_is_tried_from(tmp_path: Path) -> None:
    def tried(angle: int) -> list[Says]:
        return [act(turn(angle)), save(2), act(turn(1)), restore(1)]

    with OpenAI(save(1), *tried(10), *tried(20), *tried(30), act(turn(40)), save(2), Says("B2")) as provider:
        outcome = run(3, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    assert program(tmp_path / "run") == [[turn(20)], [turn(1)]]


@pytest.mark.parametrize("attempts", [1, 2])
def test_the_number_of_attempts_is_an_option_that_the_run_keeps(tmp_path: Path, attempts: int) -> None:
    rounds = [part for k in range(1, attempts + 1) for part in (act(turn(k)), restore(1))]
    with OpenAI(save(1), *rounds, Says("B1")) as provider:
        outcome = run(
            3,
            tmp_path / "run",
            model=MODEL,
            api_base=provider.url,
            attempts=attempts,
            max_queries=1 + 2 * attempts,
        )
    assert outcome.status == "stopped"
    assert f"You have {attempts} attempts at each frame" in provider.received[0]["messages"][0]["content"]
    assert [event["attempt"] for event in events(tmp_path / "run", "selected")] == [1]
    with pytest.raises(UsageError, match=f"was made with attempts {attempts}, not 7"):
        resumed_job(tmp_path / "run", None, settings(attempts=7))
    rounds = [part for k in range(1, attempts + 1) for part in (act(turn(k)), restore(2))]
    with OpenAI(*rounds, Says("B1")) as provider:
        assert resume(tmp_path / "run", api_base=provider.url, max_queries=20).status == "complete"
    assert program(tmp_path / "run") == [[turn(1)], [turn(1)]]


@pytest.mark.slow
def test_the_number_of_attempts_reaches_a_server_of_the_client_s_own_too(tmp_path: Path) -> None:
    with OpenAI(save(1), act(turn(1)), restore(1), Says("B1")) as provider:
        job = new_job(
            sequence(2),
            tmp_path / "run",
            settings(model=MODEL, api_base=provider.url, attempts=1, server_url=None),
        )
        assert asyncio.run(reconstruct(job, Silent())).status == "complete"
    assert json.loads((tmp_path / "run" / "run.json").read_text())["settings"]["given"]["attempts"] == 1


def test_saving_against_the_critic_is_allowed_and_said(tmp_path: Path) -> None:
    refused = [act(turn(45)), ask(2, "rotate"), MISMATCH, save(2)]
    with OpenAI(
        save(1), *refused, act(turn(10)), ask(3, "rotate"), MISMATCH, UNDO, act(turn(11)), save(3)
    ) as provider:
        outcome = run(3, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    assert [(each["frame"], each["verdict"]) for each in events(tmp_path / "run", "saved_against")] == [
        (2, "MISMATCH")
    ]
    opening = provider.received[5]["messages"][1]["content"][0]["text"]
    assert "Frame 2: rotate(45.0). Saved against the critic's MISMATCH." in opening
