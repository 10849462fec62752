"""Conversations with tools and pictures keep what each provider needs: images in results, thinking,
signatures.
"""

import asyncio
import io
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest
from client_runs import HASTY, PLANTED_KEY
from folding_client.interrupts import ProviderDown, ProviderRefused, ReplyUnreadable
from folding_client.messages import (
    Message,
    Picture,
    Reply,
    ToolResult,
    ToolSpec,
    answered,
    system,
    tool_answer,
    user,
)
from folding_client.models.litellm_model import LitellmModel
from folding_client.settings import Settings
from PIL import Image
from providers.anthropic import REDACTED, Anthropic
from providers.base import Fails, Hangs, Provider, Resets, Says, Truncates, Turn
from providers.gemini import Gemini
from providers.openai import OpenAI

if TYPE_CHECKING:
    from collections.abc import Sequence

VIEW = ToolSpec(
    "view_frame",
    "Show a photo.",
    {"type": "object", "properties": {"frame": {"type": "integer"}}, "required": ["frame"]},
)
LOOK_TWICE = Says(
    "I look.", [("view_frame", {"frame": 1}), ("view_frame", {"frame": 2})], thinking="What changed?"
)
LOOK_AGAIN = Says("Once more.", [("view_frame", {"frame": 2})], thinking="The corner.", cached=300)
PROVIDERS = [
    (OpenAI, "openai/gpt-4o"),
    (Anthropic, "anthropic/claude-sonnet-4-5"),
    (Gemini, "gemini/gemini-3-pro-preview"),
    (Gemini, "gemini/gemini-2.5-pro"),
]
IDS = ["OpenAI", "Anthropic", "Gemini 3", "Gemini 2.5"]


@pytest.fixture(autouse=True)
def keys(monkeypatch: pytest.MonkeyPatch) -> None:
    """A key for every provider."""
    for name in ("OPENAI_API_KEY", "ANTHROPIC_API_KEY", "GEMINI_API_KEY"):
        monkeypatch.setenv(name, PLANTED_KEY)


def photo(frame: int) -> Picture:
    """A picture that differs by frame."""
    data = io.BytesIO()
    Image.new("RGB", (8, 8), (frame * 20, 0, 0)).save(data, "PNG")
    return Picture(data.getvalue(), "image/png", f"photo of frame {frame}")


async def converse(
    provider: Provider, model: str, replies: int, **given: Any
) -> tuple[list[Reply], list[Message]]:
    """A conversation in which every call is answered with a picture."""
    settings = Settings(**{"api_base": provider.url, "retries": HASTY, "timeout": 1, **given})
    partner = LitellmModel(f"litellm/{model}", settings, lambda *_: None)
    messages = [system("You fold."), user("Look at frames 1 and 2.")]
    said = []
    for _ in range(replies):
        reply = await partner.query(messages, [VIEW])
        said.append(reply)
        messages.append(answered(reply))
        for number, call in enumerate(reply.tool_calls, start=1):
            messages.append(tool_answer(call, ToolResult(f"Frame {number}.", None, (photo(number),))))
    return said, messages


def pictures_in(body: object) -> int:
    """How many pictures a request holds, whatever its form."""
    if isinstance(body, dict):
        here = body.get("type") in ("image", "image_url") or "inline_data" in body
        return here + sum(pictures_in(value) for value in body.values() if not here)
    return sum(map(pictures_in, body)) if isinstance(body, list) else 0


@pytest.mark.parametrize(("kind", "model"), PROVIDERS, ids=IDS)
def test_a_tool_conversation_survives_several_turns(kind: type[Provider], model: str) -> None:
    with kind(LOOK_TWICE, LOOK_AGAIN, Says("A corner was folded.")) as provider:
        said, _ = asyncio.run(converse(provider, model, 3))
    assert [len(reply.tool_calls) for reply in said] == [2, 1, 0]
    assert said[2].text == "A corner was folded."
    assert [pictures_in(body) for body in provider.received] == [0, 2, 3]


def test_thinking_that_is_kept_from_the_client_comes_back_too() -> None:
    sealed = replace(LOOK_TWICE, thinking=REDACTED)
    with Anthropic(sealed, LOOK_AGAIN, Says("A corner was folded.")) as provider:
        said, _ = asyncio.run(converse(provider, "anthropic/claude-sonnet-4-5", 3))
    assert said[2].text == "A corner was folded."
    assert {"type": "redacted_thinking", "data": "sealed-1"} in provider.received[2]["messages"][1]["content"]


@pytest.mark.parametrize(("kind", "model"), PROVIDERS[1:], ids=IDS[1:])
def test_thinking_is_reported_and_asked_for_within_its_budget(kind: type[Provider], model: str) -> None:
    with kind(LOOK_TWICE) as provider:
        said, _ = asyncio.run(converse(provider, model, 1))
    assert said[0].thinking == "What changed?"
    assert "8192" in str(provider.received[0]) or "includeThoughts" in str(provider.received[0])


@pytest.mark.parametrize(("kind", "model"), PROVIDERS[:3], ids=IDS[:3])
def test_cached_tokens_lower_the_price(kind: type[Provider], model: str) -> None:
    with kind(LOOK_TWICE, LOOK_AGAIN) as provider:
        (first, second), _ = asyncio.run(converse(provider, model, 2))
    assert (first.usage.cached_tokens, second.usage.cached_tokens) == (0, 300)
    assert first.usage.cost is not None
    per_token = [reply.usage.cost / reply.usage.input_tokens for reply in (first, second) if reply.usage.cost]
    assert per_token[1] < per_token[0]


@pytest.mark.parametrize(
    ("model", "key"), [("openai/gpt-5", "OPENAI_API_KEY"), ("gemini/gemini-2.5-pro", "GEMINI_API_KEY")]
)
def test_without_a_key_a_query_is_refused_at_once_and_says_which_to_set(
    monkeypatch: pytest.MonkeyPatch, model: str, key: str
) -> None:
    monkeypatch.delenv(key)
    waits: list[str] = []
    partner = LitellmModel(f"litellm/{model}", Settings(), lambda reason, _: waits.append(reason))
    with pytest.raises(ProviderRefused, match=key):
        asyncio.run(partner.query([user("Fold.")], []))
    assert waits == []


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "model"), PROVIDERS[:3], ids=IDS[:3])
@pytest.mark.parametrize(
    "trouble",
    [Fails(429, headers={"retry-after": "0.1"}), Fails(500), Resets(), Truncates(), Hangs(1.5)],
    ids=["rate limit", "error", "reset", "truncated", "silence"],
)
def test_every_provider_s_trouble_is_tried_again(kind: type[Provider], model: str, trouble: Turn) -> None:
    with kind(trouble, Says("fine")) as provider:
        said, _ = asyncio.run(converse(provider, model, 1))
    assert said[0].text == "fine"


def test_trouble_that_lasts_ends_after_the_tries_allowed() -> None:
    turns: Sequence[Turn] = [Fails(500)] * HASTY.tries
    with OpenAI(*turns) as provider, pytest.raises(ProviderDown, match="failed 3 times"):
        asyncio.run(converse(provider, "openai/gpt-4o", 1))
    assert len(provider.received) == HASTY.tries


def test_a_call_that_gemini_could_not_read_is_an_unreadable_reply() -> None:
    with Gemini(Says(finish="MALFORMED_FUNCTION_CALL")) as provider, pytest.raises(ReplyUnreadable):
        asyncio.run(converse(provider, "gemini/gemini-3-pro-preview", 1))


def test_malformed_arguments_do_not_spoil_the_rest_of_the_conversation() -> None:
    with OpenAI(Says(calls=[("view_frame", '{"frame": ')]), Says("I see.")) as provider:
        said, _ = asyncio.run(converse(provider, "openai/gpt-4o", 2))
    assert said[0].tool_calls[0].arguments == '{"frame": '
    assert provider.received[1]["messages"][2]["tool_calls"][0]["function"]["arguments"] == "{}"
