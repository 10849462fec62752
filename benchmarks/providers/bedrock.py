"""Amazon Bedrock's Converse: reasoning with signatures, images in tool results, cache points.

What it refuses is what the service refuses (docs.aws.amazon.com, "Converse", "Claude extended thinking", "Prompt caching").
"""

from typing import Any

from providers.anthropic import LEAST_BUDGET, MOST_CACHE_MARKS
from providers.base import Body, Fails, Provider, Says
from providers.images import check_base64
from providers.schemas import check_tool

STOP_REASONS = {True: "tool_use", False: "end_turn"}
_EFFORTS = ("low", "medium", "high", "xhigh", "max")


class Bedrock(Provider):
    """Checks that reasoning comes back as it was signed, that results follow their calls, and the cache points."""

    def __init__(self, *turns: Any) -> None:
        super().__init__(*turns)
        self.said: list[list[Body]] = []

    def check(self, path: str, body: Body) -> None:
        """Raise AssertionError if the request breaks Converse's rules, or alters what the model said."""
        assert path.startswith("/model/"), path
        assert path.endswith("/converse"), path
        for tool in body.get("toolConfig", {}).get("tools", []):
            if spec := tool.get("toolSpec"):
                check_tool(spec["name"], spec["description"], spec["inputSchema"]["json"])
        thinks = _check_reasoning(body)
        replies = [
            _plain(message["content"]) for message in body["messages"] if message["role"] == "assistant"
        ]
        for reply in replies:
            told = reply if thinks else [block for block in reply if "reasoningContent" not in block]
            assert told in self.said, "a reply comes back as it was, with its reasoning"
        _check_tool_results(body["messages"])
        points = str(body).count("'cachePoint'")
        assert 1 <= points <= MOST_CACHE_MARKS, f"{points} cache points"

    def answer(self, turn: Says, number: int) -> Body:
        """A message with its blocks: reasoning, text, tool uses."""
        content: list[Body] = []
        if turn.thinking:
            text = {"text": turn.thinking, "signature": f"signed-{number}"}
            content.append({"reasoningContent": {"reasoningText": text}})
        if turn.text:
            content.append({"text": turn.text})
        content += [
            {"toolUse": {"toolUseId": f"tooluse_{number}_{index}", "name": name, "input": given}}
            for index, (name, given) in enumerate(turn.calls)
        ]
        self.said.append(content)
        usage = {
            "inputTokens": 900,
            "outputTokens": 60,
            "totalTokens": 960,
            "cacheReadInputTokens": turn.cached,
        }
        return {
            "output": {"message": {"role": "assistant", "content": content}},
            "stopReason": turn.finish or STOP_REASONS[bool(turn.calls)],
            "usage": usage,
            "metrics": {"latencyMs": 1},
        }

    def error(self, turn: Fails) -> Body:
        """Amazon's form of an error."""
        return {"message": turn.message}


def _plain(content: list[Body]) -> list[Body]:
    return [block for block in content if "cachePoint" not in block]


def _check_reasoning(body: Body) -> bool:
    """Whether the model is asked to think, within its limits."""
    extra = body.get("additionalModelRequestFields", {})
    thinking = extra.get("thinking", {"type": "disabled"})
    if thinking["type"] == "enabled":
        most = body["inferenceConfig"]["maxTokens"]
        assert LEAST_BUDGET <= thinking["budget_tokens"] < most, thinking
    if thinking["type"] == "adaptive":
        assert extra["output_config"]["effort"] in _EFFORTS, extra
    return bool(thinking["type"] != "disabled")


def _check_tool_results(messages: list[Body]) -> None:
    waiting: list[str] = []
    for message in messages:
        content = message["content"]
        if message["role"] == "assistant":
            waiting = [block["toolUse"]["toolUseId"] for block in content if "toolUse" in block]
            continue
        results = [block["toolResult"] for block in content if "toolResult" in block]
        assert [result["toolUseId"] for result in results] == waiting, f"results answer {waiting}"
        waiting = []
        for result in results:
            for inner in result["content"]:
                if picture := inner.get("image"):
                    check_base64(picture["source"]["bytes"], f"image/{picture['format']}")
    assert not waiting, f"tool uses without results: {waiting}"
