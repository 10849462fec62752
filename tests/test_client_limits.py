"""What a run may spend: money, tokens and time, over all roles; keys and prices are asked for before anything starts."""

import json
import time
from pathlib import Path
from typing import Any

import pytest
from client_runs import MATCH, PLANTED_KEY, act, ask, events, resume, run, save, sequence, server_url
from folding_client.interrupts import LimitReached, UsageError
from folding_client.models.prices import listed_price, read_prices
from folding_client.record.totals import Totals, seconds_of
from folding_client.run_limits import SpendingLimits
from folding_client.settings import Settings
from providers.base import Hangs, Says
from providers.openai import OpenAI
from test_client_commands import TURN as TURN_CALL
from test_client_commands import command, script
from test_client_commands import save as saves

MODEL = "litellm/openai/gpt-4o"
UNPRICED = "litellm/openai/a-model-of-our-own"
TURN = {"action": "rotate", "angle": 45.0}
LOOK = Says(calls=[("get_current_state", {})])
REPLY_COST = 0.003
"""Of the local provider's replies, by litellm's list."""


@pytest.fixture(autouse=True)
def key(monkeypatch: pytest.MonkeyPatch) -> None:
    """A key for the provider."""
    monkeypatch.setenv("OPENAI_API_KEY", PLANTED_KEY)


def test_a_limit_of_cost_counts_every_role_and_can_be_raised_on_resume(tmp_path: Path) -> None:
    with OpenAI(save(1), act(TURN), ask(2, "rotate"), MATCH) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, max_cost=3.5 * REPLY_COST)
    assert stopped.status == "stopped"
    assert (
        "The limit of $0.0105 is reached ($0.0120 spent); resume with a higher --max-cost" in stopped.reason
    )
    assert events(tmp_path / "run", "stopped")[0]["cause"] == "LimitReached"
    with OpenAI(act(TURN), save(2)) as provider:
        assert resume(tmp_path / "run", api_base=provider.url, max_cost=1.0).status == "complete"


def test_a_limit_of_tokens_ends_the_command_with_code_3(tmp_path: Path) -> None:
    with OpenAI(save(1), act(TURN)) as provider:
        words = ("--model", MODEL, "--api-base", provider.url, "--server-url", server_url())
        stopped = command("run", sequence(2), "--out", tmp_path / "run", *words, "--max-tokens-total", 1500)
    assert stopped.returncode == 3
    assert "The limit of 1500 tokens is reached" in stopped.stderr
    assert stopped.stderr.strip().splitlines()[-1].endswith("resume with a higher --max-tokens-total.")


@pytest.mark.slow
def test_a_limit_of_time_cuts_a_query_short_and_the_run_resumes(tmp_path: Path) -> None:
    with OpenAI(save(1), act(TURN), Hangs(20)) as provider:
        started = time.monotonic()
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, timeout=60, max_time=4)
    assert time.monotonic() - started < 15
    assert stopped.status == "stopped"
    assert "The limit of 4 seconds is reached" in stopped.reason
    assert 4 <= stopped.run["outcome"]["seconds"] < 15
    again = resume(tmp_path / "run")
    assert "The limit of 4 seconds is reached" in again.reason, "the time before counts"
    with OpenAI(act(TURN), save(2)) as provider:
        assert resume(tmp_path / "run", api_base=provider.url, max_time=600).status == "complete"


@pytest.mark.parametrize(
    ("text", "seconds"), [("90", 90), ("90s", 90), ("1.5m", 90), ("2 h", 7200), (5, 5)], ids=str
)
def test_a_time_has_a_unit(text: Any, seconds: float) -> None:
    assert Settings(max_time=text).max_time == seconds


@pytest.mark.parametrize(("text", "says"), [("soon", "such as 90s, 15m or 2h"), ("0s", "greater than 0")])
def test_what_is_no_time_is_refused_in_one_sentence(text: str, says: str) -> None:
    refused = command("run", sequence(2), "--max-time", text)
    assert refused.returncode == 2
    assert refused.stderr.startswith("--max-time cannot be ")
    assert says in refused.stderr
    assert "Value error" not in refused.stderr


def test_no_limit_of_cost_is_accepted_for_a_price_that_nobody_knows(tmp_path: Path) -> None:
    with OpenAI(save(1), act(TURN), save(2)) as provider:
        words = (
            "run",
            sequence(2),
            "--model",
            UNPRICED,
            "--api-base",
            provider.url,
            "--out",
            tmp_path / "run",
        )
        refused = command(*words, "--max-cost", 1)
        assert refused.returncode == 2
        assert "The price of openai/a-model-of-our-own is not known, so --max-cost 1 cannot" in refused.stderr
        assert not (tmp_path / "run").exists()
        assert provider.received == []
        done = command(
            *words, "--max-cost", 1, "--max-tokens-total", 100_000, "--server-url", server_url(), "--json"
        )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["totals"]["agent"]["cost"] is None


def test_a_price_of_zero_on_the_list_is_one_that_is_not_known() -> None:
    assert listed_price("openrouter/anthropic/claude-sonnet-4.5") is None
    assert listed_price("openai/no-such-model") is None
    known = listed_price("openai/gpt-4o")
    assert known is not None
    assert (known.input, known.cached_input, known.output) == (2.5, 1.25, 10)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("prices.toml", '["litellm/openai/a-model-of-our-own"]\ninput = 2\noutput = 10\n'),
        ("prices.yaml", "openai/a-model-of-our-own: {input: 2, output: 10}\n"),
        ("prices.json", '{"openai/a-model-of-our-own": {"input": 2, "output": 10, "cached_input": 1}}'),
    ],
    ids=["TOML", "YAML", "JSON"],
)
def test_prices_of_one_s_own_models_come_from_a_file(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    price = read_prices(str(tmp_path / name))["openai/a-model-of-our-own"]
    assert (price.input, price.output) == (2, 10)


def test_replies_are_priced_by_the_file_and_the_limit_of_cost_holds(tmp_path: Path) -> None:
    (tmp_path / "prices.toml").write_text('["openai/a-model-of-our-own"]\ninput = 1000\noutput = 0\n')
    prices = {"prices": str(tmp_path / "prices.toml"), "max_cost": 1.5}
    with OpenAI(save(1), act(TURN)) as provider:
        stopped = run(2, tmp_path / "run", model=UNPRICED, api_base=provider.url, **prices)
    assert "--max-cost" in stopped.reason
    assert stopped.run["totals"]["agent"]["cost"] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[m]\ninput = -1\noutput = 1\n", "gives no price at m.input"),
        ("[m]\ninput = 1\n", "gives no price at m.output"),
        ("m = 3\n", "gives no price at m"),
        ("m = \n", "cannot be read as TOML"),
    ],
)
def test_a_file_of_prices_that_is_none_is_refused(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "prices.toml").write_text(text)
    with pytest.raises(UsageError, match=says):
        read_prices(str(tmp_path / "prices.toml"))


def test_a_missing_key_is_told_before_the_server_starts_and_once_for_a_batch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("OPENAI_API_KEY")
    refused = command("run", sequence(2), "--model", MODEL, "--out", tmp_path / "run")
    assert (refused.returncode, refused.stdout) == (2, "")
    assert "needs a key: set OPENAI_API_KEY in the environment" in refused.stderr
    (tmp_path / "list.json").write_text(json.dumps([str(sequence(2)), str(sequence(3))]))
    batch = command("batch", tmp_path / "list.json", "--model", MODEL, "--out", tmp_path / "runs")
    assert batch.returncode == 2
    assert len(batch.stderr.strip().splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["list.json"]


def test_the_models_of_a_video_are_looked_at_before_its_keyframes_are_searched(tmp_path: Path) -> None:
    (tmp_path / "film.mp4").write_text("never read")
    refused = command("run", tmp_path / "film.mp4", "--model", "gpt", "--out", tmp_path / "run")
    assert refused.returncode == 2
    assert refused.stderr.startswith("There is no model 'gpt'")


def test_without_a_price_a_limit_of_cost_cannot_be_reached() -> None:
    unpriced = {"agent": Totals(queries=9, input_tokens=9000)}
    SpendingLimits(cost=0.01).check(unpriced)
    with pytest.raises(LimitReached):
        SpendingLimits(cost=0.01, tokens=9000).check(unpriced)


def test_the_seconds_of_a_record_are_those_of_every_time_that_it_was_open() -> None:
    times = [0.0, 1.5, 4.0, 0.1, 2.0, 0.0]
    assert seconds_of({"elapsed": each} for each in times) == 6.0


def test_a_scripted_run_has_no_price_and_no_tokens(tmp_path: Path) -> None:
    model = script(tmp_path, [saves(1)], [TURN_CALL, saves(2)])
    words = ("--model", model, "--out", tmp_path / "run", "--server-url", server_url())
    done = command("run", sequence(2), *words, "--max-cost", 1)
    assert done.returncode == 0, done.stderr
    assert "queries" not in done.stdout  # a script asks nobody
    assert "$" not in done.stdout
