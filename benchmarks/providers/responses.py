"""OpenAI's Responses API of a model that reasons: its reasoning items have to come back before what they led to.

What it refuses is what the service refuses (developers.openai.com, "Reasoning models").
"""

from typing import Any

from providers.base import Body, Says
from providers.openai_responses import OpenAIResponses, check_outputs
from providers.schemas import check_tool

EFFORTS = ("none", "minimal", "low", "medium", "high", "xhigh")


class Responses(OpenAIResponses):
    """Checks the effort, and that reasoning items come back as they were; at OpenAI's address or Azure's."""

    def __init__(self, *turns: Any) -> None:
        super().__init__(*turns)
        self.thought: dict[str, Body] = {}
        """By the id of a call, the reasoning item of its reply."""

    def check(self, path: str, body: Body) -> None:
        """Raise AssertionError if the request breaks the API's rules, or loses a reasoning item."""
        assert path.partition("?")[0].endswith("/responses"), path
        for tool in body.get("tools", []):
            check_tool(tool["name"], tool["description"], tool["parameters"])
        assert body.get("reasoning", {"effort": "none"})["effort"] in EFFORTS, body["reasoning"]
        check_outputs(body["input"])
        since_output: list[Body] = []
        for item in body["input"]:
            if item.get("type") == "function_call_output":
                since_output = []
            elif thought := self.thought.get(item.get("call_id", "")):
                assert thought in since_output, f"the reasoning item of {item['call_id']} is not before it"
            since_output.append(item)

    def answer(self, turn: Says, number: int) -> Body:
        """A response whose first item is the reasoning."""
        response = super().answer(turn, number)
        if turn.thinking:
            reasoning = {
                "id": f"rs_{number}",
                "type": "reasoning",
                "summary": [{"type": "summary_text", "text": turn.thinking}],
                "encrypted_content": f"sealed-{number}",
            }
            self.thought[f"fc_{number}_0"] = reasoning
            response["output"].insert(0, reasoning)
        return response
