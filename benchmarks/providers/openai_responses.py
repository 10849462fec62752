"""OpenAI's Responses API, whole or as server-sent events: function calls, images in their outputs.

What it refuses is what the service refuses (developers.openai.com, "Responses" and "Function calling").
"""

import json
from collections.abc import Iterator
from typing import Any

from providers.base import Body, Provider, Says
from providers.images import check_data_url

USAGE = {
    "input_tokens": 1000,
    "input_tokens_details": {"cached_tokens": 0},
    "output_tokens": 50,
    "output_tokens_details": {"reasoning_tokens": 0},
    "total_tokens": 1050,
}


class OpenAIResponses(Provider):
    """Checks that every call has its output and that images are images. Calls name our tools without a host's prefix."""

    @property
    def url(self) -> str:
        """The address with the version that OpenAI's clients expect in it."""
        return super().url + "/v1"

    def check(self, path: str, body: Body) -> None:
        """Raise AssertionError if the request breaks the API's rules."""
        assert path == "/v1/responses", path
        check_outputs(body["input"])

    def answer(self, turn: Says, number: int) -> Body:
        """A response with its items."""
        declared = dict(declared_tools(self.received[-1].get("tools", []))) if turn.calls else {}
        items = [
            {
                "type": "function_call",
                "id": f"fc_{number}_{index}",
                "call_id": f"call_{number}_{index}",
                "status": "completed",
                "arguments": json.dumps(given),
                **declared.get(name, {"name": name}),
            }
            for index, (name, given) in enumerate(turn.calls)
        ]
        if turn.text:
            content = [{"type": "output_text", "text": turn.text, "annotations": []}]
            message: Body = {
                "type": "message",
                "id": f"msg_{number}",
                "role": "assistant",
                "status": "completed",
            }
            items.insert(0, {**message, "content": content})
        return {
            "id": f"resp_{number}",
            "object": "response",
            "created_at": 0,
            "model": "gpt-5",
            "status": "completed",
            "output": items,
            "usage": USAGE,
            "parallel_tool_calls": False,
            "tool_choice": "auto",
            "tools": [],
        }

    def encoded(self, path: str, body: Body, answer: Body) -> tuple[str, bytes]:
        """The answer as events, if the request asks for a stream."""
        if not body.get("stream"):
            return super().encoded(path, body, answer)
        lines = [f"event: {event['type']}\ndata: {json.dumps(event)}\n\n" for event in _events(answer)]
        return "text/event-stream", "".join(lines).encode()


def _events(answer: Body) -> Iterator[Body]:
    """The events of a stream: what clients need of them."""
    started = {**answer, "status": "in_progress", "output": []}
    yield {"type": "response.created", "response": started}
    for index, item in enumerate(answer["output"]):
        yield {"type": "response.output_item.added", "output_index": index, "item": item}
        for part in item.get("content", ()):
            place = {"item_id": item["id"], "output_index": index, "content_index": 0}
            yield {"type": "response.output_text.delta", "delta": part["text"], **place}
        yield {"type": "response.output_item.done", "output_index": index, "item": item}
    yield {"type": "response.completed", "response": answer}


def declared_tools(tools: list[Body]) -> Iterator[tuple[str, Body]]:
    """For each function that is declared, alone or in a namespace: its name without a host's prefix, and how a call names it."""
    for tool in tools:
        if tool["type"] == "function":
            yield tool["name"].rpartition("__")[2].removeprefix("folding_"), {"name": tool["name"]}
        for inner in tool.get("tools", ()) if tool["type"] == "namespace" else ():
            yield inner["name"], {"name": inner["name"], "namespace": tool["name"]}


def check_outputs(items: Any) -> None:
    """Raise AssertionError unless every call has one output, in which images are images."""
    called = [item["call_id"] for item in items if item.get("type") == "function_call"]
    outputs = [item for item in items if item.get("type") == "function_call_output"]
    assert [item["call_id"] for item in outputs] == called, "each call is followed by its output"
    for item in outputs:
        for part in item["output"] if isinstance(item["output"], list) else ():
            assert part["type"] in ("input_text", "input_image", "input_file"), part["type"]
            if part["type"] == "input_image":
                check_data_url(part["image_url"])


def outputs_of(body: Body) -> dict[str, list[Body]]:
    """What the calls of a conversation came to: by call id the parts of the output, text as one part."""
    return {
        item["call_id"]: item["output"]
        if isinstance(item["output"], list)
        else [{"type": "input_text", "text": item["output"]}]
        for item in body["input"]
        if item.get("type") == "function_call_output"
    }
