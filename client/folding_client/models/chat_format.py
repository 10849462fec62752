"""Our conversations in the chat format that litellm translates for every provider.

Providers differ in three places that matter here: whether a tool's result may hold pictures, what of a reply
has to come back untouched (thinking blocks, thought signatures), and whether a cache has to be asked for.
"""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from folding_client.messages import JsonObject, Message, Picture, ToolCall, ToolSpec
from folding_client.models.portable_schema import portable

Chat = list[JsonObject]
_CACHED = {"cache_control": {"type": "ephemeral"}}


@dataclass(frozen=True)
class Dialect:
    """How a provider wants a conversation. ``echoed`` are the fields of its replies that go back as they
    came.
    """

    pictures_in_results: bool = False
    cache_marks: bool = False
    echoed: tuple[str, ...] = ()
    thinking: str | None = None


ANTHROPIC = Dialect(
    pictures_in_results=True, cache_marks=True, echoed=("thinking_blocks",), thinking="budget"
)
GEMINI = Dialect(
    pictures_in_results=True, echoed=("thinking_blocks", "provider_specific_fields"), thinking="budget"
)
OPENAI = Dialect(thinking="effort")

_DIALECTS = {"anthropic": ANTHROPIC, "gemini": GEMINI, "vertex_ai": GEMINI, "vertex_ai_beta": GEMINI}
_OLDER_GEMINI = re.compile(r"gemini-[12](\D|$)")


def dialect_of(provider: str, model: str) -> Dialect:
    """The dialect of a litellm provider's model; providers not known better speak OpenAI's. Before version 3,
    Gemini takes no pictures in results.
    """
    dialect = _DIALECTS.get(provider, OPENAI)
    return replace(dialect, pictures_in_results=False) if _OLDER_GEMINI.search(model) else dialect


def chat_messages(messages: Sequence[Message], dialect: Dialect) -> Chat:
    """The conversation in chat format.

    Where results cannot hold pictures, those of a reply's calls follow in one user message after all its
    results, since the results must follow the reply without a gap.
    """
    chat: Chat = []
    waiting: list[Message] = []
    for message in messages:
        if waiting and message.role != "tool":
            chat.append(_pictures_of(waiting))
            waiting = []
        chat.append(_chat_message(message, dialect))
        if message.role == "tool" and message.pictures and not dialect.pictures_in_results:
            waiting.append(message)
    if waiting:
        chat.append(_pictures_of(waiting))
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
        return _reply(message, dialect)
    if message.role == "tool":
        shown = message.pictures if dialect.pictures_in_results else ()
        return {
            "role": "tool",
            "tool_call_id": message.call_id,
            "name": message.tool,
            "content": _content(f"Error: {message.text}" if message.is_error else message.text, shown),
        }
    return {"role": message.role, "content": _content(message.text, message.pictures)}


def _reply(message: Message, dialect: Dialect) -> JsonObject:
    native = message.native or {}
    reply: JsonObject = {"role": "assistant", "content": message.text if message.text.strip() else None}
    reply |= {name: native[name] for name in dialect.echoed if native.get(name)}
    if message.tool_calls:
        extras = {call["id"]: call.get("provider_specific_fields") for call in native.get("tool_calls") or []}
        reply["tool_calls"] = [
            _call(call, extras.get(call.id) if dialect.echoed else None) for call in message.tool_calls
        ]
    return reply


def _call(call: ToolCall, extras: JsonObject | None) -> JsonObject:
    entry: JsonObject = {
        "id": call.id,
        "type": "function",
        "function": {"name": call.name, "arguments": _valid(call.arguments)},
    }
    return entry | {"provider_specific_fields": extras} if extras else entry


def _valid(arguments: str) -> str:
    """Arguments as they may be sent back: providers refuse a conversation that holds anything but an object
    here.
    """
    try:
        return arguments if isinstance(json.loads(arguments), dict) else "{}"
    except ValueError:
        return "{}"


def _content(text: str, pictures: Sequence[Picture]) -> Any:  # noqa: ANN401
    if not pictures:
        return text
    return [*([{"type": "text", "text": text}] if text else []), *map(_picture, pictures)]


def _picture(picture: Picture) -> JsonObject:
    return {"type": "image_url", "image_url": {"url": picture.data_url()}}


def _pictures_of(results: Sequence[Message]) -> JsonObject:
    pictures = [picture for result in results for picture in result.pictures]
    names = "; ".join(
        f"{result.tool}: {', '.join(picture.subject for picture in result.pictures)}" for result in results
    )
    return {
        "role": "user",
        "content": _content(f"The pictures of these results, in order: {names}.", pictures),
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
