"""OpenAI's chat API: tool calls, images in user messages, usage; streaming off."""

import json
from typing import Any

from providers.base import Body, Provider, Says
from providers.images import check_data_url
from providers.schemas import check_schema


class OpenAI(Provider):
    """Checks the order of results, where images are, and that every schema and argument is an object."""

    @property
    def url(self) -> str:
        """The address with the version that OpenAI's clients expect in it."""
        return super().url + "/v1"

    def check(self, path: str, body: Body) -> None:
        """Raise AssertionError if the request breaks the chat API's rules."""
        assert path == "/v1/chat/completions", path
        assert not body.get("stream"), "streaming is off"
        for tool in body.get("tools", []):
            check_schema(tool["function"]["parameters"])
        _check_messages(body["messages"])

    def answer(self, turn: Says, number: int) -> Body:
        """A chat completion."""
        message: Body = {"role": "assistant", "content": turn.text or None}
        if turn.calls:
            message["tool_calls"] = [
                {
                    "id": f"call_{number}_{index}",
                    "type": "function",
                    "function": {
                        "name": name,
                        "arguments": given if isinstance(given, str) else json.dumps(given),
                    },
                }
                for index, (name, given) in enumerate(turn.calls)
            ]
        finish = turn.finish or ("tool_calls" if turn.calls else "stop")
        usage = {
            "prompt_tokens": 1000,
            "completion_tokens": 50,
            "total_tokens": 1050,
            "prompt_tokens_details": {"cached_tokens": turn.cached},
        }
        return {
            "id": f"chatcmpl-{number}",
            "object": "chat.completion",
            "created": 0,
            "model": "gpt-4o",
            "choices": [{"index": 0, "message": message, "finish_reason": finish}],
            "usage": usage,
        }


def _check_messages(messages: list[Body]) -> None:
    expected: list[str] = []
    for message in messages:
        if message["role"] == "tool":
            assert message["tool_call_id"] == expected.pop(0), "results come in the order of the calls"
            assert isinstance(message["content"], str) and message["content"], "a result is text"
            continue
        assert not expected, f"calls without a result: {expected}"
        if message["role"] == "assistant":
            assert set(message) <= {"role", "content", "tool_calls"}, f"unknown fields in {sorted(message)}"
            expected = [_checked_call(call) for call in message.get("tool_calls", [])]
            assert message.get("content") or expected, "a reply is not empty"
        elif message["role"] == "user":
            _check_parts(message["content"])
    assert not expected, f"calls without a result: {expected}"


def _checked_call(call: Body) -> str:
    assert isinstance(json.loads(call["function"]["arguments"]), dict), call
    return str(call["id"])


def _check_parts(content: Any) -> None:
    for part in content if isinstance(content, list) else []:
        if part["type"] == "image_url":
            check_data_url(part["image_url"]["url"])
