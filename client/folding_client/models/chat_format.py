"""Our conversations in the chat format that litellm translates for every provider.

Models differ in two places that matter here: whether a tool's result may hold pictures, and whether a cache has to be asked
for. What a reply held that has to come back untouched (thinking blocks, thought signatures, reasoning details and items)
comes back by what it held, whoever the provider is: a model is reached through many.
"""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from folding_client.messages import JsonObject, Message, Picture, Resolution, ToolCall, ToolSpec
from folding_client.models.model_entry import ModelEntry
from folding_client.models.picture_sizes import in_its_resolution
from folding_client.models.portable_schema import portable
from folding_client.models.text_calls import told_in_text

Chat = list[JsonObject]
_CACHED = {"cache_control": {"type": "ephemeral"}}
_PICTURES_FOR_CLAUDE = frozenset({"anthropic", "azure_ai", "bedrock", "vertex_ai"})
_PICTURES_FOR_GEMINI = frozenset({"gemini", "vertex_ai", "vertex_ai_beta"})
_OPENAI = frozenset({"openai", "azure"})
_OPENAI_DETAILS: Mapping[Resolution, str] = {"small": "low"}
"""OpenAI sees such a picture in 512 x 512 pixels for 85 tokens (developers.openai.com, "Images and vision")."""
_GEMINI_DETAILS: Mapping[Resolution, str] = {"small": "low", "medium": "medium"}
"""A quarter and half of the tokens of a picture; documents are read no better above medium (ai.google.dev, "Media resolution")."""
_OLDER_GEMINI = re.compile(r"gemini-[12](\D|$)")

_TRANSLATED = ("thinking_blocks", "reasoning_items")
"""What litellm translates from every provider and back, under these names."""
_OWN_FIELDS = ("reasoning_details", "extra_content")
"""Fields of a provider's own, which litellm moves into ``provider_specific_fields``, from where they go back."""
_SIGNATURES = ("thought_signatures", "compaction_blocks")
"""What litellm finds in ``provider_specific_fields`` when it translates a reply back."""
_CALL_FIELDS = frozenset({"id", "type", "function", "index"})


@dataclass(frozen=True)
class Dialect:
    """How a model wants a conversation at its provider."""

    pictures_in_results: bool = False
    cache_marks: bool = False
    details: Mapping[Resolution, str] = field(default_factory=dict)
    """What the provider calls the resolutions of pictures, those that it has a word for."""


def dialect_of(entry: ModelEntry) -> Dialect:
    """The dialect of a model. Before version 3, Gemini takes no pictures in results; Claude's cache is asked for wherever
    it is served.
    """
    if entry.is_claude:
        return Dialect(entry.provider in _PICTURES_FOR_CLAUDE, cache_marks=True)
    is_gemini = entry.provider in _PICTURES_FOR_GEMINI and not _OLDER_GEMINI.search(entry.name)
    details = _GEMINI_DETAILS if is_gemini else _OPENAI_DETAILS if entry.provider in _OPENAI else {}
    return Dialect(is_gemini, details=details)


def held_by(message: Mapping[str, Any]) -> JsonObject:
    """What of a provider's message has to be kept to give its reply back as it was.

    Thinking that is text alone goes back only if its provider wrote it in ``reasoning_content``; DeepSeek and Moonshot
    refuse a conversation without it.
    """
    fields = message.get("provider_specific_fields") or {}
    held = {name: message[name] for name in ("tool_calls", *_TRANSLATED) if message.get(name)}
    held |= {name: fields[name] for name in _OWN_FIELDS if fields.get(name)}
    signatures = {name: fields[name] for name in _SIGNATURES if fields.get(name)}
    if signatures:
        held["provider_specific_fields"] = signatures
    if (
        message.get("reasoning_content")
        and not fields.get("reasoning")
        and not (held.keys() - {"tool_calls"})
    ):
        held["reasoning_content"] = message["reasoning_content"]
    return held


def chat_messages(messages: Sequence[Message], dialect: Dialect) -> Chat:
    """The conversation in chat format.

    Where results cannot hold pictures, those of a reply's calls follow in one user message after all its
    results, since the results must follow the reply without a gap.
    """
    chat: Chat = []
    waiting: list[Message] = []
    for message in told_in_text(messages):
        if waiting and message.role != "tool":
            chat.append(_pictures_of(waiting, dialect))
            waiting = []
        chat.append(_chat_message(message, dialect))
        if message.role == "tool" and message.pictures and not dialect.pictures_in_results:
            waiting.append(message)
    if waiting:
        chat.append(_pictures_of(waiting, dialect))
    return _with_cache_marks(chat) if dialect.cache_marks else chat


def chat_tools(tools: Sequence[ToolSpec]) -> Chat:
    """The tools in chat format."""
    return [
        {
            "type": "function",
            "function": {
                "name": tool.name,
                "description": tool.description,
                "parameters": portable(tool.schema),
            },
        }
        for tool in tools
    ]


def _chat_message(message: Message, dialect: Dialect) -> JsonObject:
    if message.role == "assistant":
        return _reply(message)
    if message.role == "tool":
        shown = message.pictures if dialect.pictures_in_results else ()
        return {
            "role": "tool",
            "tool_call_id": message.call_id,
            "name": message.tool,
            "content": _content(
                f"Error: {message.text}" if message.is_error else message.text, shown, dialect
            ),
        }
    return {"role": message.role, "content": _content(message.text, message.pictures, dialect)}


def _reply(message: Message) -> JsonObject:
    held = dict(message.native or {})
    calls = held.pop("tool_calls", [])
    reply: JsonObject = {
        "role": "assistant",
        "content": message.text if message.text.strip() else None,
        **held,
    }
    if message.tool_calls:
        extras = [{name: call[name] for name in call.keys() - _CALL_FIELDS} for call in calls]
        extras += [{}] * (len(message.tool_calls) - len(extras))
        reply["tool_calls"] = [
            _call(call) | extra for call, extra in zip(message.tool_calls, extras, strict=False)
        ]
    return reply


def _call(call: ToolCall) -> JsonObject:
    return {
        "id": call.id,
        "type": "function",
        "function": {"name": call.name, "arguments": _valid(call.arguments)},
    }


def _valid(arguments: str) -> str:
    """Arguments as they may be sent back: providers refuse a conversation that holds anything but an object
    here.
    """
    try:
        return arguments if isinstance(json.loads(arguments), dict) else "{}"
    except ValueError:
        return "{}"


def _content(text: str, pictures: Sequence[Picture], dialect: Dialect) -> Any:  # noqa: ANN401
    if not pictures:
        return text
    parts = [{"type": "text", "text": text}] if text else []
    return parts + [part for picture in pictures for part in _picture(picture, dialect)]


def _picture(picture: Picture, dialect: Dialect) -> Chat:
    """A picture, after its caption if it has one."""
    detail = dialect.details.get(picture.resolution)
    image = {"url": in_its_resolution(picture).data_url()} | ({"detail": detail} if detail else {})
    caption = [{"type": "text", "text": picture.caption}] if picture.caption else []
    return [*caption, {"type": "image_url", "image_url": image}]


def _pictures_of(results: Sequence[Message], dialect: Dialect) -> JsonObject:
    pictures = [picture for result in results for picture in result.pictures]
    names = "; ".join(
        f"{result.tool}: {', '.join(picture.subject for picture in result.pictures)}" for result in results
    )
    return {
        "role": "user",
        "content": _content(f"The pictures of these results, in order: {names}.", pictures, dialect),
    }


def _with_cache_marks(chat: Chat) -> Chat:
    """Ask for the cache to keep the system prompt, the step's opening, and everything up to the last
    message.
    """
    marked = {0, min(1, len(chat) - 1), len(chat) - 1}
    return [_marked(message) if index in marked else message for index, message in enumerate(chat)]


def _marked(message: JsonObject) -> JsonObject:
    content = message["content"]
    if isinstance(content, str) and content:
        return {**message, "content": [{"type": "text", "text": content, **_CACHED}]}
    if isinstance(content, list):
        return {**message, "content": [*content[:-1], {**content[-1], **_CACHED}]}
    return message
