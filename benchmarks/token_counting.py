"""How many input tokens a provider counts for what it is sent: an estimate by the rules that it publishes.

Text is counted by the tokeniser that litellm carries (tiktoken's cl100k_base), for all providers alike; providers without a
public tokeniser may count some 10 to 20 % more or less. Pictures are counted by these rules:

openai     fit into 2048 x 2048, then the shorter side to 768; 85 tokens, and 170 for each tile of 512 x 512
           (GPT-4o; developers.openai.com, "Images and vision")
anthropic  fit into 1568 x 1568 and about 1.15 megapixels; width x height / 750
           (docs.claude.com, "Vision")
gemini     1120 tokens whatever the size: the most that Gemini 3 spends on a picture, its default resolution
           (ai.google.dev, "Media resolution"); 560 and 280 at medium and low resolution
"""

import base64
import hashlib
import io
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

import tiktoken
from PIL import Image

GEMINI_3 = {"low": 280, "medium": 560, "high": 1120}
OVERHEAD = 4
"""Tokens that frame a message."""

Piece = tuple[str, dict[str, int]]
"""A part of a request: a mark of its content, and its tokens by provider."""


def openai_tokens(width: int, height: int, detail: str = "auto") -> int:
    """Tokens of a picture for GPT-4o."""
    if detail == "low":
        return 85
    width, height = _scaled(width, height, 2048 / max(width, height))
    width, height = _scaled(width, height, 768 / min(width, height))
    return 85 + 170 * math.ceil(width / 512) * math.ceil(height / 512)


def anthropic_tokens(width: int, height: int, detail: str = "auto") -> int:  # noqa: ARG001
    """Tokens of a picture for Claude."""
    scale = min(1568 / max(width, height), math.sqrt(1_150_000 / (width * height)))
    width, height = _scaled(width, height, scale)
    return round(width * height / 750)


def gemini_tokens(width: int, height: int, detail: str = "auto") -> int:  # noqa: ARG001
    """Tokens of a picture for Gemini 3."""
    return GEMINI_3.get(detail, GEMINI_3["high"])


RULES: Mapping[str, Callable[[int, int, str], int]] = {
    "openai": openai_tokens,
    "anthropic": anthropic_tokens,
    "gemini": gemini_tokens,
}


def _scaled(width: int, height: int, scale: float) -> tuple[int, int]:
    """The size of a picture that is made smaller, never larger."""
    return (width, height) if scale >= 1 else (round(width * scale), round(height * scale))


def pieces(body: Mapping[str, Any]) -> Iterator[Piece]:
    """A request in OpenAI's chat format, piece by piece in the order in which a cache compares it."""
    for tool in body.get("tools", []):
        yield _text(json.dumps(tool["function"], ensure_ascii=False), 0)
    for message in body["messages"]:
        yield from map(_part, _parts(message.get("content") or ""))
        for call in message.get("tool_calls") or []:
            yield _text(call["function"]["name"] + call["function"]["arguments"], OVERHEAD)


def _parts(content: str | list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{"type": "text", "text": content}] if isinstance(content, str) else content


def _part(part: Mapping[str, Any]) -> Piece:
    return _text(part["text"], OVERHEAD) if part["type"] == "text" else _picture(part["image_url"])


def _text(text: str, overhead: int) -> Piece:
    count = text_tokens(text) + overhead
    return hashlib.sha256(text.encode()).hexdigest(), dict.fromkeys(RULES, count)


@cache
def text_tokens(text: str) -> int:
    """Tokens of a text."""
    return len(_tokeniser().encode(text, disallowed_special=()))


@cache
def _tokeniser() -> tiktoken.Encoding:
    """The tokeniser in the copy that litellm carries, so that nothing is fetched."""
    litellm = Path(str(distribution("litellm").locate_file("litellm")))
    os.environ["TIKTOKEN_CACHE_DIR"] = str(litellm / "litellm_core_utils" / "tokenizers")
    return tiktoken.get_encoding("cl100k_base")


def _picture(image: Mapping[str, str]) -> Piece:
    width, height = _size(image["url"])
    detail = image.get("detail", "auto")
    mark = hashlib.sha256(image["url"].encode()).hexdigest() + detail
    return mark, {name: rule(width, height, detail) for name, rule in RULES.items()}


@cache
def _size(url: str) -> tuple[int, int]:
    with Image.open(io.BytesIO(base64.b64decode(url.split(",", 1)[1]))) as image:
        return image.size
