"""Gemini's generateContent: function calls with thought signatures, images in function responses.

Requests use the field names that litellm sends, which are the protocol's own; the service takes either
spelling.
"""

import base64
from typing import Any

from providers.base import Body, Fails, Provider, Says
from providers.images import check_base64
from providers.schemas import check_schema


class Gemini(Provider):
    """Checks that every function call comes back with its signature, answered, and that images are images."""

    def __init__(self, *turns: Any) -> None:
        super().__init__(*turns)
        self.signatures: list[str] = []

    def check(self, path: str, body: Body) -> None:
        """Raise AssertionError if the request breaks generateContent's rules, or loses a signature."""
        assert ":generateContent" in path, path
        for tool in body.get("tools", []):
            for declared in tool["function_declarations"]:
                check_schema(declared.get("parameters", {"type": "object"}))
        sent = [
            part["thoughtSignature"]
            for content in body["contents"]
            if content["role"] == "model"
            for part in content["parts"]
            if "function_call" in part and "thoughtSignature" in part
        ]
        calling = sum(
            any("function_call" in part for part in content["parts"]) for content in body["contents"]
        )
        assert len(sent) == calling and sent == self.signatures[len(self.signatures) - len(sent) :], sent
        _check_responses(body["contents"])

    def answer(self, turn: Says, number: int) -> Body:
        """A candidate with its parts; the first function call carries the signature."""
        parts: list[Body] = []
        if turn.thinking:
            parts.append({"text": turn.thinking, "thought": True})
        if turn.text:
            parts.append({"text": turn.text})
        for index, (name, given) in enumerate(turn.calls):
            part: Body = {"functionCall": {"name": name, "args": given}}
            if index == 0:
                part["thoughtSignature"] = base64.b64encode(f"signature-{number}".encode()).decode()
                self.signatures.append(part["thoughtSignature"])
            parts.append(part)
        usage = {
            "promptTokenCount": 800,
            "candidatesTokenCount": 40,
            "totalTokenCount": 860,
            "thoughtsTokenCount": 20,
            "cachedContentTokenCount": turn.cached,
        }
        return {
            "candidates": [
                {
                    "content": {"role": "model", "parts": parts},
                    "index": 0,
                    "finishReason": turn.finish or "STOP",
                }
            ],
            "usageMetadata": usage,
            "modelVersion": "gemini-2.5-pro",
        }

    def error(self, turn: Fails) -> Body:
        """Google's form of an error."""
        return {"error": {"code": turn.status, "message": turn.message, "status": "UNAVAILABLE"}}


def _check_responses(contents: list[Body]) -> None:
    called: list[str] = []
    for content in contents:
        parts = content["parts"]
        answers = [part["function_response"]["name"] for part in parts if "function_response" in part]
        assert answers == called, f"{answers} answers {called}"
        called = [part["function_call"]["name"] for part in parts if "function_call" in part]
        for part in parts:
            _check_images(part)


def _check_images(part: Body) -> None:
    if blob := part.get("inline_data"):
        check_base64(blob["data"], blob["mime_type"])
    for inner in part.get("function_response", {}).get("parts", []):
        _check_images(inner)
