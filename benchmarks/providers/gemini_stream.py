"""Gemini's generateContent as Gemini CLI speaks it: the protocol's JSON names, whole or as server-sent events.

What it refuses is what the service refuses (ai.google.dev, "Function calling").
"""

import json
from collections.abc import Iterator
from typing import Any

from providers.base import Body, Provider, Says, Turn
from providers.images import check_base64

ASIDE = '{"reasoning": "", "model_choice": "pro", "next_speaker": "user", "complexity_score": 1}'
"""What requests without tools are answered: a host asks which model to take, or whether the model is done."""


class GeminiStream(Provider):
    """Checks that every call has its response and that images are images. Calls name our tools without a host's prefix."""

    def next_turn(self, path: str, body: Body, headers: dict[str, str]) -> Turn:
        """The next turn of the script for the conversation itself; a fixed reply for what the host asks beside it."""
        if body.get("tools") and "countTokens" not in path:
            return super().next_turn(path, body, headers)
        return Says(ASIDE)

    def check(self, path: str, body: Body) -> None:
        """Raise AssertionError if the request breaks the API's rules."""
        assert path.partition("?")[0].endswith((":generateContent", ":streamGenerateContent")), path
        called: list[str] = []
        for content in body["contents"]:
            answers = [part["functionResponse"] for part in content["parts"] if "functionResponse" in part]
            assert [answer["name"] for answer in answers] == called, "each call is followed by its response"
            called = [part["functionCall"]["name"] for part in content["parts"] if "functionCall" in part]
        for part in parts_of(body):
            if blob := part.get("inlineData"):
                check_base64(blob["data"], blob["mimeType"])

    def answer(self, turn: Says, number: int) -> Body:
        """A candidate with its parts."""
        declared = dict(declared_functions(self.received[-1])) if turn.calls else {}
        parts: list[Body] = [{"text": turn.text}] if turn.text else []
        parts += [
            {
                "functionCall": {"name": declared.get(name, name), "args": given},
                "thoughtSignature": "c2lnbmVk",
            }
            for name, given in turn.calls
        ]
        return {
            "candidates": [
                {"content": {"role": "model", "parts": parts}, "index": 0, "finishReason": "STOP"}
            ],
            "usageMetadata": {"promptTokenCount": 800, "candidatesTokenCount": 40, "totalTokenCount": 840},
            "modelVersion": "gemini-2.5-pro",
            "responseId": f"response-{number}",
            "totalTokens": 840,
        }

    def encoded(self, path: str, body: Body, answer: Body) -> tuple[str, bytes]:
        """The answer as one event, if the request asks for a stream."""
        if ":streamGenerateContent" not in path:
            return super().encoded(path, body, answer)
        return "text/event-stream", f"data: {json.dumps(answer)}\n\n".encode()


def declared_functions(body: Body) -> Iterator[tuple[str, str]]:
    """For each function that is declared: its name without a host's prefix, and the name itself."""
    for tool in body.get("tools", ()):
        for function in tool.get("functionDeclarations", ()):
            yield function["name"].removeprefix("mcp_folding_"), function["name"]


def parts_of(body: Body) -> Iterator[Any]:
    """Every part of a conversation, those within function responses too."""
    for content in body["contents"]:
        for part in content["parts"]:
            yield part
            yield from part.get("functionResponse", {}).get("parts", ())
