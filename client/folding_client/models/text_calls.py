"""Tool calls that a model wrote into its text, because its server does not know the model's way of writing them.

Known ways: ``<tool_call>{...}</tool_call>`` (Hermes, Qwen), ``<function=name>{...}</function>`` (Llama),
``[TOOL_CALLS][{...}]`` (Mistral), ``<|python_tag|>{...}`` (Llama), a fenced JSON block, and a text that is JSON alone. A call
names a tool that is on offer, so that other JSON stays text.
"""

import json
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any

from folding_client.messages import Message, ToolCall, user

IN_TEXT = "text_"
"""What ids of calls begin with that a model wrote into its text."""
_TAGGED = re.compile(r"<(tool_call|function_call|tool_use)>\s*(.*?)\s*(?:</\1>|\Z)", re.DOTALL)
_NAMED = re.compile(r"<function=([\w-]+)>\s*(.*?)\s*</function>", re.DOTALL)
_PREFIXED = re.compile(r"(?:\[TOOL_CALLS\]|<\|python_tag\|>)\s*(.*)\Z", re.DOTALL)
_FENCED = re.compile(r"```(?:json|tool_call|tool_code)?[ \t]*\n(.*?)\n?```", re.DOTALL)
_NAME_KEYS = ("name", "tool", "tool_name", "function")
_ARGUMENT_KEYS = ("arguments", "parameters", "args", "input", "tool_input")


def calls_in(text: str, tools: Collection[str], first: int) -> tuple[ToolCall, ...]:
    """The calls of ``tools`` that a text holds, in order; their ids count from ``first``."""
    found = _named(text) or [call for entry in _entries(text) if (call := _call(entry))]
    known = [(name, arguments) for name, arguments in found if name in tools]
    return tuple(
        ToolCall(f"{IN_TEXT}{number}", name, arguments)
        for number, (name, arguments) in enumerate(known, start=first)
    )


def told_in_text(messages: Sequence[Message]) -> list[Message]:
    """The messages with calls in text as their model wrote them, and with their results as the user's words."""
    told: list[Message] = []
    for answers, group in groupby(messages, key=_answers_text):
        some = list(group)
        told += [_results(some)] if answers else map(_without_calls, some)
    return told


def _answers_text(message: Message) -> bool:
    return message.role == "tool" and _is_in_text(message.call_id)


def _is_in_text(call_id: str | None) -> bool:
    return (call_id or "").startswith(IN_TEXT)


def _results(messages: Sequence[Message]) -> Message:
    said = "\n\n".join(
        f"{'Error' if message.is_error else 'Result'} of {message.tool}:\n{message.text}"
        for message in messages
    )
    return user(said, tuple(picture for message in messages for picture in message.pictures))


def _without_calls(message: Message) -> Message:
    in_text = any(_is_in_text(call.id) for call in message.tool_calls)
    return replace(message, tool_calls=()) if in_text else message


def _named(text: str) -> list[tuple[str, str]]:
    return [(name, arguments or "{}") for name, arguments in _NAMED.findall(text)]


def _entries(text: str) -> Iterator[Any]:
    """The JSON values that may be calls, lists taken apart."""
    tagged = [inner for _, inner in _TAGGED.findall(text)]
    for source in tagged or _PREFIXED.findall(text) or _FENCED.findall(text) or [text]:
        yield from _values(source)


def _values(source: str) -> Iterator[Any]:
    """The JSON values that a text consists of, one after the other; what is not JSON ends them."""
    decoder, rest = json.JSONDecoder(), source.strip()
    while rest[:1] in ("{", "["):
        try:
            value, end = decoder.raw_decode(rest)
        except ValueError:
            return
        yield from value if isinstance(value, list) else [value]
        rest = rest[end:].lstrip(" \t\r\n,;")


def _call(entry: Any) -> tuple[str, str] | None:  # noqa: ANN401
    """The name and the arguments of a call, which may stand in a ``function`` of its own, as text or as an object."""
    if not isinstance(entry, dict):
        return None
    inner = entry["function"] if isinstance(entry.get("function"), dict) else entry
    name = next((inner[key] for key in _NAME_KEYS if isinstance(inner.get(key), str)), None)
    if name is None:
        return None
    arguments: object = next((inner[key] for key in _ARGUMENT_KEYS if key in inner), {})
    return name, arguments if isinstance(arguments, str) else json.dumps(arguments)
