"""The solver decides the frames that are clear, the model the rest: on photographs, with the real server."""

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest
from client_runs import HASTY, PLANTED_KEY, act, events, program, restore, save, shortened
from folding_client.progress import Silent
from folding_client.reconstruct import Outcome, new_job, reconstruct, resumed_job
from folding_client.record.replay import replay_run
from folding_client.settings import Settings
from paths import ROOT
from PIL import Image
from providers.anthropic import Anthropic
from providers.base import Fails, Provider, Says
from providers.gemini import Gemini
from providers.openai import OpenAI
from pydantic import ValidationError

MODEL = "hybrid:openai/gpt-4o"
BEHIND = "litellm/openai/gpt-4o"
TURN = {"action": "rotate", "angle": 45.0}


@pytest.fixture(autouse=True)
def keys(monkeypatch: pytest.MonkeyPatch) -> None:
    """A key for every provider."""
    for name in ("OPENAI_API_KEY", "ANTHROPIC_API_KEY", "GEMINI_API_KEY"):
        monkeypatch.setenv(name, PLANTED_KEY)


def cat(folder: Path, frames: int) -> Path:
    """The first frames of the cat. How the first turn went its photos leave open; the folds after it are clear."""
    return shortened(ROOT / "examples" / "cat", folder / "cat", frames)


def solve(sequence: Path, out: Path, provider: Provider, **given: Any) -> Outcome:
    """A run of a hybrid."""
    settings = Settings(**{"model": MODEL, "api_base": provider.url, "retries": HASTY, **given})
    return asyncio.run(reconstruct(new_job(sequence, out, settings), Silent()))


@pytest.mark.slow
def test_the_solver_decides_what_is_clear_and_the_model_the_rest(tmp_path: Path) -> None:
    with OpenAI(act(TURN), save(2)) as provider:
        outcome = solve(cat(tmp_path, 3), tmp_path / "run", provider)
    assert outcome.status == "complete"
    assert outcome.run["decided"] == {"1": "geometric", "2": BEHIND, "3": "geometric"}
    assert outcome.run["models"] == {"agent": MODEL, "critic": BEHIND, "overview": BEHIND, "selector": BEHIND}
    assert outcome.run["totals"].keys() == {"agent"}
    assert outcome.run["totals"]["agent"]["queries"] == 2
    assert outcome.run["totals"]["agent"]["cost"] == pytest.approx(2 * 0.003)
    assert [step[-1]["action"] for step in program(tmp_path / "run")] == ["rotate", "fold"]
    (handed,) = events(tmp_path / "run", "handed_over")
    assert handed["frame"] == 2
    first = provider.received[0]
    assert [message["role"] for message in first["messages"]] == ["system", "user", "user"]
    told = first["messages"][2]["content"]
    assert "`propose_actions` for frame 2 answered" in told
    assert "rotate(45.0) explains" in told
    assert "nothing has been done" in told
    assert "propose_actions" in {tool["function"]["name"] for tool in first["tools"]}
    assert "`propose_actions`" in first["messages"][0]["content"]
    (request,) = events(tmp_path / "run", "request")[:1]
    assert request["new"][2]["text"] == told


@pytest.mark.slow
def test_a_result_that_does_not_match_is_taken_back_and_the_model_told_why(tmp_path: Path) -> None:
    wrong = {"action": "rotate", "angle": 20.0}
    with OpenAI(act(wrong), save(2), restore(1), act(TURN), save(2)) as provider:
        outcome = solve(cat(tmp_path, 3), tmp_path / "run", provider)
    assert outcome.status == "complete"
    told = [body["messages"][2]["content"] for body in provider.received]
    assert "was carried out and taken back" in told[2]
    assert "Frame 3 has had 1 of 5 attempts" in provider.received[2]["messages"][1]["content"][0]["text"]
    assert program(tmp_path / "run")[0] == [TURN]
    assert outcome.run["decided"] == {"1": "geometric", "2": BEHIND, "3": "geometric"}


@pytest.mark.slow
def test_a_hybrid_run_that_stopped_goes_on_with_both_and_replays(tmp_path: Path) -> None:
    with OpenAI(act(TURN), Fails(401)) as provider:
        stopped = solve(cat(tmp_path, 2), tmp_path / "run", provider)
    assert stopped.status == "stopped"
    assert stopped.run["decided"] == {"1": "geometric"}
    with OpenAI(act(TURN), save(2)) as provider:
        job = resumed_job(tmp_path / "run", None, Settings(api_base=provider.url))
        resumed = asyncio.run(reconstruct(job, Silent()))
    assert resumed.status == "complete"
    assert resumed.run["decided"] == {"1": "geometric", "2": BEHIND}
    assert resumed.run["totals"]["agent"]["queries"] == 3
    asked = [event["name"] for event in events(tmp_path / "run", "call")]
    assert asked.count("propose_actions") == 1
    assert asyncio.run(replay_run(tmp_path / "run")).differences == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "model"),
    [(Anthropic, "anthropic/claude-sonnet-4-5"), (Gemini, "gemini/gemini-3-pro-preview")],
    ids=["Anthropic", "Gemini"],
)
def test_other_providers_take_the_proposals_too(tmp_path: Path, kind: type[Provider], model: str) -> None:
    turn = Says("", [("rotate", {"angle": 45.0}), ("render_current", {})], thinking="By half a right angle.")
    with kind(turn, save(2)) as provider:
        outcome = solve(cat(tmp_path, 2), tmp_path / "run", provider, model=f"hybrid:{model}")
    assert outcome.status == "complete"
    assert "No clear favourite" in json.dumps(provider.received[0])


@pytest.mark.slow
def test_a_script_may_stand_in_for_the_model(tmp_path: Path) -> None:
    script = tmp_path / "script.json"
    calls = [
        {"tool": "rotate", "arguments": {"angle": 45}},
        {"tool": "save_checkpoint", "arguments": {"frame": 2}},
    ]
    script.write_text(json.dumps([{"calls": calls}]))
    job = new_job(cat(tmp_path, 2), tmp_path / "run", Settings(model=f"hybrid:scripted:{script}"))
    outcome = asyncio.run(reconstruct(job, Silent()))
    assert outcome.status == "complete"
    assert outcome.run["decided"]["2"] == f"scripted:{script}"


@pytest.mark.slow
def test_a_photo_that_cannot_be_measured_leaves_the_frame_to_the_model(tmp_path: Path) -> None:
    sequence = cat(tmp_path, 2)
    first = json.loads((sequence / "keyframes.json").read_text())["keyframes"][0]
    Image.new("RGB", (800, 800), (90, 90, 90)).save(sequence / "frames" / f"{first:06d}.jpg")
    with OpenAI(act(TURN), save(2)) as provider:
        outcome = solve(sequence, tmp_path / "run", provider)
    assert outcome.status == "complete"
    assert outcome.run["decided"] == {"1": "geometric", "2": BEHIND}
    (proposed,) = [
        event for event in events(tmp_path / "run", "result") if event["name"] == "propose_actions"
    ]
    assert proposed["is_error"]
    assert proposed["text"] in provider.received[0]["messages"][2]["content"]


def test_a_hybrid_is_an_agent() -> None:
    with pytest.raises(ValidationError, match="--critic cannot be a hybrid"):
        Settings(critic=MODEL)
    with pytest.raises(ValidationError, match="works as an agent"):
        Settings(model=MODEL, variant="vlm-s")
