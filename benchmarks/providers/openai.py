"""OpenAI's chat API: tool calls, images in user messages, usage; streaming off.

What it refuses is what the service refuses (developers.openai.com, "Chat completions" and "Function calling").
"""

import json
from typing import Any

from providers.base import Body, Provider, Says
from providers.images import check_data_url
from providers.schemas import check_tool

ASSISTANT_FIELDS = frozenset({"role", "content", "name", "tool_calls", "refusal", "audio"})
_LONGEST_ID = 40
_FIELDS = {
    "system": {"role", "content", "name"},
    "developer": {"role", "content", "name"},
    "user": {"role", "content", "name"},
    "assistant": ASSISTANT_FIELDS,
    "tool": {"role", "content", "tool_call_id", "name"},
}
_REASONING = ("o1", "o3", "o4", "gpt-5")
_USUAL_EFFORTS = frozenset({"low", "medium", "high"})


class OpenAI(Provider):
    """Checks the order of results, where images are, and that every schema and argument is an object."""

    streams = False
    """Whether the model only streams."""

    @property
    def url(self) -> str:
        """The address with the version that OpenAI's clients expect in it."""
        return super().url + "/v1"

    def check(self, path: str, body: Body) -> None:
        """Raise AssertionError if the request breaks the chat API's rules."""
        assert path == "/v1/chat/completions", path
        assert bool(body.get("stream")) == self.streams, "streaming is as the model needs it"
        for tool in body.get("tools", []):
            check_tool(**tool["function"])
        if body["model"].startswith(_REASONING):
            assert "max_tokens" not in body, "reasoning models take max_completion_tokens"
            effort = body.get("reasoning_effort", "medium")
            assert effort in _efforts_of(body["model"]), f"{body['model']} does not take the effort {effort}"
        else:
            assert "reasoning_effort" not in body, f"{body['model']} does not reason"
        _check_messages(body["messages"])

    def encoded(self, path: str, body: Body, answer: Body) -> tuple[str, bytes]:
        """The chat completion, in chunks if the request asks for a stream."""
        if not body.get("stream"):
            return super().encoded(path, body, answer)
        lines = [*map(json.dumps, chunks(answer)), "[DONE]"]
        return "text/event-stream", "".join(f"data: {line}\n\n" for line in lines).encode()

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
            "choices": [] if turn.silent else [{"index": 0, "message": message, "finish_reason": finish}],
            "usage": usage,
        }


def chunks(completion: Body) -> list[Body]:
    """A chat completion as the chunks of a stream: its message in two pieces, then the end, then the usage."""
    (choice,) = completion["choices"]
    message = choice["message"]
    calls = [{**call, "index": index} for index, call in enumerate(message.get("tool_calls", []))]
    text = message["content"] or ""
    deltas = [{"role": "assistant", "content": text[: len(text) // 2]}, {"content": text[len(text) // 2 :]}]
    deltas += [{"tool_calls": [call]} for call in calls]
    head = {
        "id": completion["id"],
        "object": "chat.completion.chunk",
        "created": 0,
        "model": completion["model"],
    }
    pieces = [{"index": 0, "delta": delta, "finish_reason": None} for delta in deltas]
    pieces.append({"index": 0, "delta": {}, "finish_reason": choice["finish_reason"]})
    return [{**head, "choices": [piece]} for piece in pieces] + [
        {**head, "choices": [], "usage": completion["usage"]}
    ]


def _efforts_of(model: str) -> frozenset[str]:
    """The efforts that a reasoning model takes."""
    if not model.startswith("gpt-5"):
        return _USUAL_EFFORTS
    return _USUAL_EFFORTS | ({"none", "xhigh"} if model.startswith("gpt-5.2") else {"minimal"})


def _check_messages(messages: list[Body]) -> None:
    expected: list[str] = []
    for message in messages:
        role = message["role"]
        assert set(message) <= _FIELDS[role], f"unknown fields in {sorted(message)}"
        if role == "tool":
            assert expected, "a result follows the call that it answers"
            assert message["tool_call_id"] == expected.pop(0), "results come in the order of the calls"
            assert isinstance(message["content"], str), "a result is text"
            assert message["content"], "a result is not empty"
            continue
        assert not expected, f"calls without a result: {expected}"
        if role == "assistant":
            expected = [_checked_call(call) for call in message.get("tool_calls", [])]
            assert message.get("content") or expected, "a reply is not empty"
            assert not isinstance(message.get("content"), list), "a reply holds no pictures"
        else:
            _check_content(role, message["content"])
    assert not expected, f"calls without a result: {expected}"


def _checked_call(call: Body) -> str:
    assert isinstance(json.loads(call["function"]["arguments"]), dict), call
    assert len(call["id"]) <= _LONGEST_ID, f"{call['id']} is too long"
    return str(call["id"])


def _check_content(role: str, content: Any) -> None:
    parts: list[Body] = [{"type": "text", "text": content}] if isinstance(content, str) else content
    assert parts, "a message is not empty"
    for part in parts:
        if part["type"] == "image_url":
            assert role == "user", f"pictures belong in user messages, not in one of the {role}"
            check_data_url(part["image_url"]["url"])
        else:
            assert part["type"] == "text", "a part is a text or a picture"
            assert part["text"], "a text is not empty"
