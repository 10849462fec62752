"""Providers that speak OpenAI's chat API with fields of their own: OpenRouter, Gemini's compatible endpoint, DeepSeek's way.

What they refuse is what the services refuse (openrouter.ai, "Reasoning tokens", "Prompt caching"; ai.google.dev, "OpenAI
compatibility", "Thought signatures"; api-docs.deepseek.com, "Thinking mode").
"""

from collections.abc import Mapping
from typing import Any

from providers.base import Body, Says
from providers.openai import ASSISTANT_FIELDS, OpenAI


class WithOwnFields(OpenAI):
    """Takes ``fields`` in the model's messages and ``call_fields`` in its calls, and checks that they come back as it
    sent them; in the contents of messages it takes cache marks if ``marks`` says so.
    """

    fields: frozenset[str] = frozenset()
    call_fields: frozenset[str] = frozenset()

    def __init__(self, *turns: Any) -> None:
        super().__init__(*turns)
        self.said: list[Body] = []

    def check(self, path: str, body: Body) -> None:
        """Raise AssertionError if the request breaks the chat API's rules, or loses a field of the provider's."""
        returned = [message for message in body["messages"] if message["role"] == "assistant"]
        for message in returned:
            assert self._own(message) in [self._own(each) for each in self.said], (
                f"lost or altered: {message}"
            )
        plain = {name: value for name, value in body.items() if name != "reasoning_effort"}
        super().check(path, {**plain, "messages": [self._plain(message) for message in body["messages"]]})

    def answer(self, turn: Says, number: int) -> Body:
        """A chat completion with the provider's own fields."""
        completion = super().answer(turn, number)
        for choice in completion["choices"]:
            choice["message"] |= self.own_fields(turn, number)
            for index, call in enumerate(choice["message"].get("tool_calls", [])):
                call.update(self.own_call_fields(number, index))
            self.said.append(choice["message"])
        return completion

    def own_fields(self, turn: Says, number: int) -> Body:  # noqa: ARG002
        """What the provider adds to a message."""
        return {}

    def own_call_fields(self, number: int, index: int) -> Body:  # noqa: ARG002
        """What the provider adds to a call."""
        return {}

    def _own(self, message: Mapping[str, Any]) -> list[Any]:
        """The provider's own fields of a message and its calls."""
        calls = message.get("tool_calls") or []
        own = {name: message[name] for name in self.fields if message.get(name)}
        return [own, *({name: call.get(name) for name in self.call_fields} for call in calls)]

    def _plain(self, message: Body) -> Body:
        """A message without the provider's own fields and cache marks."""
        plain = {name: value for name, value in message.items() if name not in self.fields}
        if isinstance(plain.get("content"), list):
            if message["role"] == "tool":
                return {**plain, "content": "".join(part["text"] for part in plain["content"])}
            plain["content"] = [
                {name: value for name, value in part.items() if name != "cache_control"}
                for part in plain["content"]
            ]
        if "tool_calls" in plain:
            plain["tool_calls"] = [
                {name: value for name, value in call.items() if name not in self.call_fields}
                for call in plain["tool_calls"]
            ]
        assert message["role"] != "assistant" or set(plain) <= ASSISTANT_FIELDS, sorted(plain)
        return plain


class OpenRouter(WithOwnFields):
    """Sends ``reasoning_details`` and wants them back; takes cache marks."""

    fields = frozenset({"reasoning_details"})

    def own_fields(self, turn: Says, number: int) -> Body:
        """The thinking twice, as text and as it is to come back."""
        if not turn.thinking:
            return {}
        detail = {
            "type": "reasoning.text",
            "text": turn.thinking,
            "signature": f"signed-{number}",
            "index": 0,
        }
        return {"reasoning": turn.thinking, "reasoning_details": [detail]}


class CompatibleGemini(WithOwnFields):
    """Signs calls in ``extra_content``."""

    fields = frozenset({"extra_content"})
    call_fields = frozenset({"extra_content"})

    def own_call_fields(self, number: int, index: int) -> Body:
        """The signature of the first of parallel calls."""
        return {} if index else {"extra_content": {"google": {"thought_signature": f"c2lnbmVk{number}"}}}


class ThinkingAloud(WithOwnFields):
    """Sends thinking as ``reasoning_content`` and refuses a conversation without it."""

    fields = frozenset({"reasoning_content"})

    def own_fields(self, turn: Says, number: int) -> Body:  # noqa: ARG002
        """The thinking as text."""
        return {"reasoning_content": turn.thinking} if turn.thinking else {}
