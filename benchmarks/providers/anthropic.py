"""Anthropic's messages API: thinking blocks with signatures, images in tool results, cache control.

What it refuses is what the service refuses (docs.claude.com, "Extended thinking", "Prompt caching", "Tool use").
"""

import re
from collections.abc import Iterator
from typing import Any

from providers.base import Body, Fails, Provider, Says
from providers.images import check_base64
from providers.schemas import check_tool

MOST_CACHE_MARKS = 4
LEAST_BUDGET = 1024
REDACTED = "(redacted)"
"""Thinking that the service keeps to itself: a block of data stands for it, which has to come back too."""
_THINKING = ("thinking", "redacted_thinking")
_PATH = re.compile(r"(/anthropic)?/v1/messages|/v1/projects/.*/publishers/anthropic/models/.*:rawPredict")
"""Anthropic's own path, Azure's, and Vertex AI's."""
_ADAPTIVE = re.compile(r"claude-(opus-4-[6-9]|sonnet-4-6|[a-z]+-5)")
_LEGACY_TOO = re.compile(r"claude-(opus|sonnet)-4-6")
_EFFORTS = ("low", "medium", "high", "xhigh", "max")
_ID = re.compile(r"[a-zA-Z0-9_-]+")


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
        assert _PATH.fullmatch(path.partition("?")[0]), path
        for tool in body.get("tools", []):
            check_tool(tool["name"], tool["description"], tool["input_schema"])
        thinks = _check_thinking(body, body.get("model") or path.rpartition("/")[2])
        messages = body["messages"]
        assert messages[0]["role"] == "user", "a conversation begins with the user"
        assert messages[-1]["role"] == "user", "thinking does not go on from words put into the model's mouth"
        for message in messages:
            if message["role"] == "assistant":
                plain = [_plain(block) for block in message["content"]]
                assert plain in self.said, "a reply comes back as it was"
        if thinks:
            _check_thought(messages, self.said)
        _check_results(messages)
        _check_texts(body)
        _check_marks(body)

    def answer(self, turn: Says, number: int) -> Body:
        """A message with its blocks: thinking, text, tool uses."""
        content: list[Body] = []
        if turn.thinking == REDACTED:
            content.append({"type": "redacted_thinking", "data": f"sealed-{number}"})
        elif turn.thinking:
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


def _check_thinking(body: Body, model: str) -> bool:
    """Whether the model is asked to think; within its limits, and without what thinking rules out."""
    thinking = body.get("thinking", {"type": "disabled"})
    if thinking["type"] == "adaptive":
        assert _ADAPTIVE.match(model), f"{model} does not think adaptively"
        assert body["output_config"]["effort"] in _EFFORTS, body["output_config"]
    if thinking["type"] == "enabled":
        assert not _ADAPTIVE.match(model) or _LEGACY_TOO.match(model), f"{model} takes no budget"
        assert LEAST_BUDGET <= thinking["budget_tokens"] < body["max_tokens"], thinking
        assert body.get("temperature", 1) == 1, "thinking rules out a temperature"
        assert body.get("tool_choice", {"type": "auto"})["type"] in ("auto", "none"), (
            "nor may a tool be forced"
        )
    return bool(thinking["type"] != "disabled")


def _check_thought(messages: list[Body], said: list[list[Body]]) -> None:
    """In a round of tool use that goes on, what the model thought first is still there."""
    asked = max(i for i, each in enumerate(messages) if each["role"] == "user" and not _results(each))
    round_of_use = [each for each in messages[asked:] if each["role"] == "assistant"]
    thought = [reply for reply in said if reply and reply[0]["type"] in _THINKING]
    if round_of_use and thought:
        assert round_of_use[0]["content"][0]["type"] in _THINKING, (
            "expected thinking, but found something else"
        )


def _results(message: Body) -> list[Body]:
    content = message["content"]
    return [block for block in content if block["type"] == "tool_result"] if isinstance(content, list) else []


def _check_results(messages: list[Body]) -> None:
    waiting: list[str] = []
    for message in messages:
        if message["role"] == "assistant":
            assert not waiting, f"tool uses without results right after them: {waiting}"
            waiting = [block["id"] for block in message["content"] if block["type"] == "tool_use"]
            assert all(_ID.fullmatch(each) for each in waiting), waiting
            assert len(set(waiting)) == len(waiting), "ids of tool uses are unique"
            continue
        blocks = message["content"] if isinstance(message["content"], list) else []
        results = _results(message)
        assert blocks[: len(results)] == results, "results come first, then text"
        answered = [block["tool_use_id"] for block in results]
        assert answered == waiting, f"{answered} answers {waiting}"
        waiting = []
        for block in blocks:
            _check_images(block)
    assert not waiting, f"tool uses without results: {waiting}"


def _check_images(block: Body) -> None:
    if block["type"] == "image":
        check_base64(block["source"]["data"], block["source"]["media_type"])
    for inner in _blocks(block.get("content", [])) if block["type"] == "tool_result" else []:
        assert inner["type"] in ("text", "image"), inner["type"]
        assert inner["type"] == "text" or not block.get("is_error"), "a result that is an error is text alone"
        _check_images(inner)


def _blocks(content: Any) -> Iterator[Body]:
    yield from [{"type": "text", "text": content}] if isinstance(content, str) else content


def _all_blocks(body: Body) -> Iterator[Body]:
    yield from _blocks(body.get("system", []))
    for message in body["messages"]:
        for block in _blocks(message["content"]):
            yield block
            yield from _blocks(block.get("content", [])) if block["type"] == "tool_result" else ()


def _check_texts(body: Body) -> None:
    for block in _all_blocks(body):
        assert block["type"] != "text" or block["text"].strip(), "texts are not empty"


def _check_marks(body: Body) -> None:
    marked = [block for block in (*body.get("tools", []), *_all_blocks(body)) if "cache_control" in block]
    assert 1 <= len(marked) <= MOST_CACHE_MARKS, f"{len(marked)} cache marks"
    assert not any(block.get("type") in _THINKING for block in marked), "thinking cannot be marked"
