"""The local providers refuse what the real ones refuse, so that a conversation they take is one to rely on."""

import asyncio
from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest
from providers.anthropic import Anthropic
from providers.base import Provider, Says
from providers.gemini import Gemini
from providers.openai import OpenAI
from test_agent_providers import LOOK_AGAIN, LOOK_TWICE, PROVIDERS, converse, keys

__all__ = ["keys"]
Body = dict[str, Any]
PATHS = {
    OpenAI: "/v1/chat/completions",
    Anthropic: "/v1/messages",
    Gemini: "/v1beta/models/{model}:generateContent",
}


def conversation(kind: type[Provider], model: str) -> tuple[Provider, str, Body]:
    """A provider after a conversation with tools, pictures and thinking: its path, and the last request."""
    with kind(LOOK_TWICE, LOOK_AGAIN, Says("A corner was folded.")) as provider:
        asyncio.run(converse(provider, model, 3))
    return provider, PATHS[kind].format(model=model.partition("/")[2]), deepcopy(provider.received[-1])


@pytest.mark.parametrize(("kind", "model"), PROVIDERS)
def test_a_conversation_that_was_taken_is_taken_again(kind: type[Provider], model: str) -> None:
    provider, path, body = conversation(kind, model)
    provider.check(path, body)


def moved(items: list[Any], index: int, to: int) -> None:
    """Move an entry of a list."""
    items.insert(to, items.pop(index))


OPENAI: dict[str, Callable[[Body], object]] = {
    "a result without its call": lambda body: body["messages"].pop(2),
    "a call without its result": lambda body: body["messages"].pop(4),
    "results out of order": lambda body: moved(body["messages"], 3, 4),
    "something between call and result": lambda body: moved(body["messages"], 1, 2),
    "a picture in a result": lambda body: body["messages"][3].update(content=body["messages"][5]["content"]),
    "a picture in a reply": lambda body: body["messages"][2].update(content=body["messages"][5]["content"]),
    "arguments that are no object": lambda body: body["messages"][2]["tool_calls"][0]["function"].update(
        arguments="[]"
    ),
    "an empty message": lambda body: body["messages"][1].update(content=""),
    "a field it does not know": lambda body: body["messages"][2].update(thinking_blocks=[]),
    "a tuple in a schema": lambda body: body["tools"][0]["function"]["parameters"]["properties"][
        "frame"
    ].update(prefixItems=[]),
    "effort for a model that does not reason": lambda body: body.update(reasoning_effort="medium"),
}
ANTHROPIC: dict[str, Callable[[Body], object]] = {
    "thinking left out": lambda body: body["messages"][1]["content"].pop(0),
    "thinking with another signature": lambda body: body["messages"][1]["content"][0].update(
        signature="mine"
    ),
    "thinking that was edited": lambda body: body["messages"][3]["content"][0].update(thinking="Shorter."),
    "a call that the model never made": lambda body: body["messages"][3].update(
        content=[{"type": "tool_use", "id": "mine", "name": "view_frame", "input": {}}]
    ),
    "a result left out": lambda body: body["messages"][2]["content"].pop(),
    "text before results": lambda body: body["messages"][2]["content"].insert(
        0, {"type": "text", "text": "Look."}
    ),
    "a fifth cache mark": lambda body: [
        block.update(cache_control={"type": "ephemeral"})
        for block in (*body["tools"], *body["messages"][2]["content"])
    ],
    "a cache mark on thinking": lambda body: body["messages"][1]["content"][0].update(
        cache_control={"type": "ephemeral"}
    ),
    "an empty text": lambda body: body["messages"][0]["content"][0].update(text=" "),
    "a budget below the least": lambda body: body["thinking"].update(budget_tokens=1000),
    "a budget above the limit": lambda body: body.update(max_tokens=8192),
    "a temperature while thinking": lambda body: body.update(temperature=0.2),
    "words put into its mouth": lambda body: body["messages"].append(body["messages"][1]),
    "a picture in a result that is an error": lambda body: body["messages"][2]["content"][0].update(
        is_error=True
    ),
}
GEMINI: dict[str, Callable[[Body], object]] = {
    "a call without its signature": lambda body: body["contents"][1]["parts"][1].pop("thoughtSignature"),
    "a signature from elsewhere": lambda body: body["contents"][3]["parts"][1].update(
        thoughtSignature="bWluZQ=="
    ),
    "a signature on the second of two calls": lambda body: body["contents"][1]["parts"][2].update(
        thoughtSignature=body["contents"][1]["parts"][1]["thoughtSignature"]
    ),
    "a response left out": lambda body: body["contents"][2]["parts"].pop(),
    "responses out of place": lambda body: moved(body["contents"], 2, 3),
    "an empty text": lambda body: body["contents"][0]["parts"][0].update(text=""),
    "a message of the model first": lambda body: body["contents"].pop(0),
    "no parts": lambda body: body["contents"][0].update(parts=[]),
    "a budget and a level": lambda body: body["generationConfig"]["thinkingConfig"].update(
        thinkingBudget=8192, thinkingLevel="high"
    ),
}


def refused(kind: type[Provider], model: str, spoil: Callable[[Body], object]) -> None:
    """A conversation that is spoilt is refused, by the check that the server makes."""
    provider, path, body = conversation(kind, model)
    spoil(body)
    with pytest.raises((AssertionError, KeyError, TypeError)):
        provider.check(path, body)


@pytest.mark.parametrize("what", OPENAI)
def test_openai_refuses(what: str) -> None:
    refused(OpenAI, "openai/gpt-4o", OPENAI[what])


@pytest.mark.parametrize("what", ANTHROPIC)
def test_anthropic_refuses(what: str) -> None:
    refused(Anthropic, "anthropic/claude-sonnet-4-5", ANTHROPIC[what])


@pytest.mark.parametrize("what", GEMINI)
def test_gemini_refuses(what: str) -> None:
    refused(Gemini, "gemini/gemini-3-pro-preview", GEMINI[what])


def test_older_geminis_refuse_pictures_in_responses() -> None:
    provider, path, body = conversation(Gemini, "gemini/gemini-3-pro-preview")
    with pytest.raises(AssertionError, match="takes no pictures in responses"):
        provider.check(path.replace("gemini-3-pro-preview", "gemini-2.5-pro"), body)


def test_a_request_that_is_refused_is_answered_so_and_is_a_problem() -> None:
    with OpenAI(Says("fine")) as provider:
        turn = provider.next_turn(PATHS[OpenAI], {"model": "gpt-4o", "messages": [{"role": "tool"}]}, {})
        problems = provider.problems.copy()
        provider.problems.clear()
    assert getattr(turn, "status", None) == 400
    assert len(problems) == 1
    assert provider.turns == [Says("fine")]
