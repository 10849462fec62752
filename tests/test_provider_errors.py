"""What a provider's error leads to: a wait, another try in another form, or a stop with one sentence; never equal tries
without end.
"""

import asyncio
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from email.utils import format_datetime
from pathlib import Path
from typing import Any

import pytest
from case_names import case_name
from client_runs import HASTY, act, events, run, save
from folding_client.interrupts import ContextExceeded, ProviderDown, ProviderRefused
from folding_client.messages import Message, Reply, system, user
from folding_client.models.litellm_model import LitellmModel
from folding_client.models.provider_errors import meaning
from folding_client.models.retry_after import seconds_asked
from folding_client.settings import Settings
from providers.anthropic import Anthropic
from providers.base import Fails, Provider, Says
from providers.bedrock import Bedrock
from providers.gemini import Gemini
from providers.openai import OpenAI
from test_agent_providers import VIEW, keys, photo
from test_provider_families import google_account, more_keys

__all__ = ["google_account", "keys", "more_keys"]
TURN = {"action": "rotate", "angle": 45.0}
KINDS: list[tuple[type[Provider], str]] = [
    (OpenAI, "openai/gpt-4o"),
    (Anthropic, "anthropic/claude-sonnet-4-5"),
    (Gemini, "gemini/gemini-3.1-pro-preview"),
]
EVERYWHERE = pytest.mark.parametrize(("kind", "model"), KINDS, ids=["OpenAI", "Anthropic", "Gemini"])
ASKED = [system("You fold."), user("What do you see?", (photo(1), photo(2)))]


class Asked:
    """One query: its reply or what it raised, and what was noted on the way."""

    def __init__(
        self, provider: Provider, model: str, messages: Sequence[Message] = ASKED, **given: Any
    ) -> None:
        self.notes: list[tuple[str, float]] = []
        self.reply = Reply()
        self.raised: Exception | None = None
        settings = Settings(**{"api_base": provider.url, "retries": HASTY, "timeout": 30, **given})
        self.partner = LitellmModel(
            f"litellm/{model}", settings, lambda why, wait: self.notes.append((why, wait))
        )
        self.again(messages)

    def again(self, messages: Sequence[Message]) -> None:
        """The same model is asked once more."""
        try:
            self.reply = asyncio.run(self.partner.query(messages, [VIEW]))
        except (ProviderDown, ProviderRefused, ContextExceeded) as error:
            self.raised = error


@pytest.mark.parametrize(
    ("headers", "words", "seconds"),
    [
        ({}, "", None),
        ({"retry-after": "7"}, "", 7),
        ({"retry-after": "0.25"}, "", 0.25),
        ({"retry-after-ms": "1500", "retry-after": "2"}, "", 1.5),
        ({"retry-after": "-3"}, "", 0),
        ({"retry-after": "soon"}, "", None),
        ({"retry-after": "nan"}, "Please try again in 6s.", 6),
        ({}, "Please try again in 1m26.4s.", 86.4),
        ({}, "Please try again in 20ms.", 0.02),
        ({}, "Please retry in 35.2s.", 35.2),
        ({}, '{"@type": "RetryInfo", "retryDelay": "46s"}', 46),
        ({}, "Try again later.", None),
    ],
)
def test_how_long_a_provider_asks_to_wait_is_read_wherever_it_says_so(
    headers: dict[str, str], words: str, seconds: float | None
) -> None:
    assert seconds_asked(headers, words) == (None if seconds is None else pytest.approx(seconds))


@pytest.mark.parametrize("zone", [UTC, None])
def test_a_date_to_wait_for_is_read(zone: Any) -> None:
    soon = datetime.now(UTC) + timedelta(seconds=90)
    asked = seconds_asked({"retry-after": format_datetime(soon.replace(tzinfo=zone))}, "")
    assert asked == pytest.approx(90, abs=5)


def test_a_date_that_is_past_asks_for_no_wait() -> None:
    assert seconds_asked({"retry-after": "Wed, 21 Oct 2015 07:28:00 GMT"}, "") == 0


@pytest.mark.slow
@EVERYWHERE
def test_the_wait_that_a_provider_asks_for_is_kept(kind: type[Provider], model: str) -> None:
    with kind(Fails(429, headers={"retry-after-ms": "300"}), Says("fine")) as provider:
        asked = Asked(provider, model)
    assert asked.reply.text == "fine"
    assert [wait >= 0.3 for _, wait in asked.notes] == [True]
    assert provider.times[1] - provider.times[0] >= 0.3


@EVERYWHERE
def test_a_wait_until_a_date_beyond_the_longest_is_a_stop(kind: type[Provider], model: str) -> None:
    later = format_datetime(datetime.now(UTC) + timedelta(minutes=5), usegmt=True)
    with kind(Fails(429, headers={"retry-after": later})) as provider:
        asked = Asked(provider, model, max_wait=60)
    assert isinstance(asked.raised, ProviderDown)
    assert "resume after that" in str(asked.raised)
    assert asked.notes == []


@pytest.mark.parametrize(
    ("kind", "model", "spent"),
    [
        (OpenAI, "openai/gpt-4o", Fails(402, "Insufficient credits.")),
        (OpenAI, "openai/gpt-4o", Fails(429, "You exceeded your current quota.", code="insufficient_quota")),
        (OpenAI, "openrouter/openai/gpt-4o", Fails(402, "This request requires more credits.")),
        (Anthropic, "anthropic/claude-sonnet-4-5", Fails(400, "Your credit balance is too low.")),
        (Anthropic, "anthropic/claude-sonnet-4-5", Fails(402, "Billing problem.")),
        (Gemini, "gemini/gemini-3.1-pro-preview", Fails(402, "Prepay.")),
        (
            Gemini,
            "gemini/gemini-3.1-pro-preview",
            Fails(429, "Quota exceeded: GenerateRequestsPerDayPerProject"),
        ),
        (Bedrock, "bedrock/us.anthropic.claude-opus-4-7", Fails(402, "Pay.")),
    ],
    ids=case_name,
)
def test_a_quota_that_is_used_up_is_a_stop_at_once(kind: type[Provider], model: str, spent: Fails) -> None:
    with kind(spent) as provider:
        asked = Asked(provider, model)
    assert isinstance(asked.raised, ProviderRefused)
    assert "used up" in str(asked.raised)
    assert len(provider.received) == 1


def test_a_quota_of_a_minute_is_waited_for() -> None:
    busy = Fails(429, "You exceeded your current quota, please check your plan. Please retry in 0.2s.")
    with Gemini(busy, Says("fine")) as provider:
        asked = Asked(provider, "gemini/gemini-3.1-pro-preview")
    assert asked.reply.text == "fine"


FILTERED = [
    (OpenAI, "openai/gpt-4o", Says(finish="content_filter")),
    (
        OpenAI,
        "openai/gpt-4o",
        Fails(400, "The response was filtered: content management policy.", "content_filter"),
    ),
    (OpenAI, "openrouter/openai/gpt-4o", Fails(403, "Your input was flagged.")),
    (Anthropic, "anthropic/claude-sonnet-4-5", Says("I", finish="refusal")),
    (Gemini, "gemini/gemini-3.1-pro-preview", Says(finish="SAFETY")),
    (Bedrock, "bedrock/us.anthropic.claude-opus-4-7", Says("Sorry", finish="content_filtered")),
]


@pytest.mark.parametrize(("kind", "model", "refusal"), FILTERED, ids=case_name)
def test_a_content_filter_gets_two_tries(kind: type[Provider], model: str, refusal: Any) -> None:
    with kind(refusal, Says("A square.")) as provider:
        assert Asked(provider, model).reply.text == "A square."
    with kind(refusal, refusal) as provider:
        asked = Asked(provider, model)
    assert isinstance(asked.raised, ProviderRefused)
    assert "content filter" in str(asked.raised)
    assert "refused twice" in str(asked.raised)


def test_what_is_wrong_with_a_request_all_the_same_is_told_and_not_sent_again() -> None:
    with OpenAI(Fails(400, "The seed is a fruit.")) as provider:
        asked = Asked(provider, "openai/gpt-4o")
    assert isinstance(asked.raised, ProviderRefused)
    assert "The seed is a fruit" in str(asked.raised)


@pytest.mark.parametrize(
    "words",
    ["No module named 'boto3'", "Google Cloud SDK not found. Install it with: pip install 'litellm[google]'"],
)
def test_a_package_that_litellm_lacks_is_named_at_once(words: str) -> None:
    said = meaning("vertex_ai/gemini-3.1-pro-preview", ImportError(words))
    assert isinstance(said, ProviderRefused)
    assert "Install it, then resume" in str(said)


@pytest.mark.parametrize("status", [500, 502, 503, 504, 529, 408, 409, 425])
def test_what_may_pass_is_tried_again(status: int) -> None:
    with OpenAI(Fails(status), Says("fine")) as provider:
        assert Asked(provider, "openai/gpt-4o").reply.text == "fine"


@pytest.mark.slow
def test_what_was_sent_is_in_the_record(tmp_path: Path) -> None:
    refusal = Fails(400, "max_tokens is too large. This model supports at most 4096 completion tokens.")
    with OpenAI(save(1), refusal, act(TURN), save(2)) as provider:
        done = run(
            2, tmp_path / "run", model="litellm/openai/gpt-5", api_base=provider.url, thinking_budget=1024
        )
    assert done.run["requests"]["agent"] == {"timeout": 600.0, "max_tokens": 32768, "reasoning_effort": "low"}
    options = {event["role"]: event["options"] for event in events(tmp_path / "run", "request_options")}
    assert options["critic"] == done.run["requests"]["critic"]
    (changed,) = events(tmp_path / "run", "retry")
    assert "4096 tokens at most" in changed["reason"]
