"""Anthropic's messages API: thinking blocks with signatures, images in tool results, cache control."""

from typing import Any

from providers.base import Body, Fails, Provider, Says
from providers.images import check_base64
from providers.schemas import check_schema

MOST_CACHE_MARKS = 4


class Anthropic(Provider):
    """Checks that thinking comes back as it was signed, that results follow their calls, and the
    cache marks.
    """

    def __init__(self, *turns: Any) -> None:
        super().__init__(*turns)
        self.said: list[list[Body]] = []

    def check(self, path: str, body: Body) -> None:
        """Raise AssertionError if the request breaks the messages API's rules, or alters what the
        model said.
        """
        assert path == "/v1/messages", path
        for tool in body.get("tools", []):
            check_schema(tool["input_schema"])
        assert body["max_tokens"] > body.get("thinking", {}).get("budget_tokens", 0)
        replies = [message["content"] for message in body["messages"] if message["role"] == "assistant"]
        for sent in replies:
            assert [_plain(block) for block in sent] in self.said, "a reply comes back as it was"
        _check_results(body["messages"])
        marks = str(body["messages"]).count("cache_control") + str(body.get("system")).count("cache_control")
        assert 1 <= marks <= MOST_CACHE_MARKS, f"{marks} cache marks"

    def answer(self, turn: Says, number: int) -> Body:
        """A message with its blocks: thinking, text, tool uses."""
        content: list[Body] = []
        if turn.thinking:
            content.append({"type": "thinking", "thinking": turn.thinking, "signature": f"signed-{number}"})
        if turn.text:
            content.append({"type": "text", "text": turn.text})
        content += [
            {"type": "tool_use", "id": f"toolu_{number}_{index}", "name": name, "input": given}
            for index, (name, given) in enumerate(turn.calls)
        ]
        self.said.append(content)
        usage = {
            "input_tokens": 900,
            "output_tokens": 60,
            "cache_read_input_tokens": turn.cached,
            "cache_creation_input_tokens": 0,
        }
        return {
            "id": f"msg_{number}",
            "type": "message",
            "role": "assistant",
            "model": "claude-sonnet-4-5",
            "content": content,
            "stop_reason": turn.finish or ("tool_use" if turn.calls else "end_turn"),
            "stop_sequence": None,
            "usage": usage,
        }

    def error(self, turn: Fails) -> Body:
        """Anthropic's form of an error."""
        return {"type": "error", "error": {"type": "api_error", "message": turn.message}}


def _plain(block: Body) -> Body:
    return {key: value for key, value in block.items() if key != "cache_control"}


def _check_results(messages: list[Body]) -> None:
    waiting: list[str] = []
    for message in messages:
        if message["role"] == "assistant":
            waiting = [block["id"] for block in message["content"] if block["type"] == "tool_use"]
            continue
        blocks = message["content"] if isinstance(message["content"], list) else []
        answered = [block["tool_use_id"] for block in blocks if block["type"] == "tool_result"]
        assert answered == waiting, f"{answered} answers {waiting}"
        waiting = []
        for block in blocks:
            _check_images(block)


def _check_images(block: Body) -> None:
    if block["type"] == "image":
        check_base64(block["source"]["data"], block["source"]["media_type"])
    for inner in block.get("content", []) if block["type"] == "tool_result" else []:
        if isinstance(inner, dict):
            _check_images(inner)
