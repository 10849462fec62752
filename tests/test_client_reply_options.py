"""How long a reply may be, and how patient a run is with its provider: options, in the record, other ones on resume."""

import json
from pathlib import Path
from typing import Any

import pytest
from client_runs import PLANTED_KEY, act, events, resume, run, save, sequence, server_url
from folding_client.settings import Settings
from providers.base import Fails, Hangs
from providers.openai import OpenAI
from pydantic import ValidationError
from test_client_commands import command

MODEL = "litellm/openai/gpt-4o"
TURN = {"action": "rotate", "angle": 45.0}


def test_the_options_of_replies_reach_the_provider_and_the_record_and_change_on_resume(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", PLANTED_KEY)
    patience = ["--max-tokens", 1000, "--timeout", 30, "--retries", 0, "--max-wait", 5]
    with OpenAI(save(1), Fails(500)) as provider:
        where = ["--api-base", provider.url, "--server-url", server_url()]
        begun = command("run", sequence(2), "--model", MODEL, "--out", tmp_path / "run", *where, *patience)
    assert begun.returncode == 3, begun.stderr
    assert [body["max_tokens"] for body in provider.received] == [1000, 1000]
    about = json.loads((tmp_path / "run" / "run.json").read_text())
    given = about["settings"]["given"]
    assert (given["max_tokens"], given["timeout"], given["max_wait"]) == (1000, 30.0, 5.0)
    assert given["retries"]["tries"] == 1
    with OpenAI(act(TURN), save(2)) as provider:
        again = ["--api-base", provider.url, "--max-tokens", 2000, "--thinking-budget", 0]
        resumed = command("run", "--resume", tmp_path / "run", *again)
    assert resumed.returncode == 0, resumed.stderr
    assert {body["max_tokens"] for body in provider.received} == {2000}
    about = json.loads((tmp_path / "run" / "run.json").read_text())
    assert about["settings"]["given"]["timeout"] == 30.0
    assert about["requests"]["agent"] == {"timeout": 30.0, "max_tokens": 2000}
    sent = [event["options"]["max_tokens"] for event in events(tmp_path / "run", "request_options")]
    assert sorted(set(sent)) == [1000, 2000]


def test_a_reply_is_waited_for_as_long_as_the_timeout_says(tmp_path: Path) -> None:
    with OpenAI(Hangs(1.0)) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, timeout=0.3, retries=0)
    assert stopped.status == "stopped"
    assert "failed once" in stopped.reason
    with OpenAI(save(1), act(TURN), save(2)) as provider:
        assert resume(tmp_path / "run", api_base=provider.url, timeout=30).status == "complete"


def test_a_longer_wait_may_be_allowed_on_resume(tmp_path: Path) -> None:
    busy = Fails(429, headers={"retry-after": "0.4"})
    with OpenAI(busy) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, max_wait=0.2)
    assert "resume after that" in stopped.reason
    with OpenAI(busy, save(1), act(TURN), save(2)) as provider:
        assert resume(tmp_path / "run", api_base=provider.url, max_wait=1).status == "complete"


@pytest.mark.parametrize(
    ("given", "tries", "longest"),
    [
        ({}, 6, 120),
        ({"retries": 2}, 3, 120),
        ({"retries": 0, "max_wait": 600}, 1, 600),
        ({"retries": {"tries": 4, "longest_wait": 7}}, 4, 7),
    ],
)
def test_retries_are_counted_after_the_first_try(given: dict[str, Any], tries: int, longest: float) -> None:
    policy = Settings(**given).retry_policy
    assert (policy.tries, policy.longest_wait) == (tries, longest)


def test_a_thinking_budget_that_was_asked_for_has_to_fit_and_the_default_makes_room() -> None:
    assert Settings(max_tokens=4096).thinking_budget == 8192
    with pytest.raises(ValidationError, match="leaves nothing of the 4096"):
        Settings(max_tokens=4096, thinking_budget=8192)
