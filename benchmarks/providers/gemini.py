"""Gemini's generateContent: function calls with thought signatures, images in function responses.

Requests use the field names that litellm sends, which are the protocol's own; the service takes either
spelling. What it refuses is what the service refuses (ai.google.dev, "Thought signatures", "Function calling").
"""

import base64
from typing import Any

from providers.base import Body, Fails, Provider, Says
from providers.images import check_base64
from providers.schemas import check_tool

_PARTS = {"text", "thought", "inline_data", "function_call", "function_response", "media_resolution"}


class Gemini(Provider):
    """Checks that every function call comes back with its signature, answered, and that images are images."""

    def __init__(self, *turns: Any) -> None:
        super().__init__(*turns)
        self.signed: dict[str, str] = {}
        """By signature, the name of the function whose call it signs."""

    def check(self, path: str, body: Body) -> None:
        """Raise AssertionError if the request breaks generateContent's rules, or loses a signature."""
        model = path.partition("/models/")[2].partition(":")[0]
        assert path.partition("?")[0].endswith(":generateContent"), path
        for tool in body.get("tools", []):
            for declared in tool["function_declarations"]:
                check_tool(
                    declared["name"], declared["description"], declared.get("parameters", {"type": "object"})
                )
        thinking = body.get("generationConfig", {}).get("thinkingConfig", {})
        assert not {"thinkingBudget", "thinkingLevel"} <= thinking.keys(), "either a budget or a level"
        assert body["contents"][0]["role"] == "user", "a conversation begins with the user"
        for content in body["contents"]:
            assert content["role"] in ("user", "model"), content["role"]
            assert content["parts"], "contents are not empty"
            for part in content["parts"]:
                _check_part(part, model)
        self._check_signatures(body["contents"])
        _check_responses(body["contents"])

    def _check_signatures(self, contents: list[Body]) -> None:
        """The first call of every reply carries the signature that came with it; no signature is made up."""
        for content in contents:
            calls = [part for part in content["parts"] if "function_call" in part]
            for index, part in enumerate(calls):
                signature = part.get("thoughtSignature")
                if index == 0:
                    name = part["function_call"]["name"]
                    assert signature, f"function call {name} is missing a thought_signature"
                    assert self.signed.get(signature) == name, f"thought signature of {name} is not valid"
                else:
                    assert signature is None, "only the first of parallel calls is signed"

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
                self.signed[part["thoughtSignature"]] = name
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
    """Each turn of calls is followed at once by as many responses, in order, and no response comes elsewhere."""
    called: list[str] = []
    for content in contents:
        parts = content["parts"]
        answers = [part["function_response"]["name"] for part in parts if "function_response" in part]
        assert answers == called, f"{answers} answers {called}"
        called = [part["function_call"]["name"] for part in parts if "function_call" in part]
    assert not called, f"calls without a response: {called}"


def _check_part(part: Body, model: str) -> None:
    """A part holds something, of a kind that it may hold for the model."""
    assert set(part) - {"thoughtSignature"} <= _PARTS, sorted(part)
    assert part.get("text", "x"), "texts are not empty"
    if blob := part.get("inline_data"):
        check_base64(blob["data"], blob["mime_type"])
    response = part.get("function_response", {})
    assert isinstance(response.get("response", {}), dict), "a response is an object"
    for inner in response.get("parts", []):
        assert model.startswith("gemini-3"), f"{model} takes no pictures in responses"
        _check_part(inner, model)
