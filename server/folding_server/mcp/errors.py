"""What the protocol layer refuses, in one plain sentence: unknown tools or arguments, wrong values."""

import json
from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import ValidationError

Schema = Mapping[str, Any]
"""The JSON schema of a tool's arguments."""

_SHOWN = 80
"""How many characters of a bad value are repeated to the caller."""


def unknown_tool(name: str, tools: Iterable[str]) -> str:
    """The answer to a call of a tool that does not exist."""
    return f"There is no tool {name!r}; the tools are {', '.join(tools)}."


def unknown_arguments(tool: str, schema: Schema, arguments: Mapping[str, object]) -> str | None:
    """The answer to a call with arguments that the tool does not take, or None if it takes them all."""
    taken = schema.get("properties", {})
    stray = [name for name in arguments if name not in taken]
    if not stray:
        return None
    return f"{tool} takes no argument {stray[0]!r}; its arguments are {', '.join(taken)}."


def bad_arguments(tool: str, schema: Schema, arguments: Mapping[str, object], error: ValidationError) -> str:
    """The answer to a call whose values do not fit: the first that is wrong, and what is allowed."""
    first = error.errors(include_url=False, include_context=False)[0]
    name = str(first["loc"][0]) if first["loc"] else ""
    allowed = schema.get("properties", {}).get(name, {}).get("description", first["msg"])
    if name not in arguments:
        return f"{tool} needs {name}: {allowed}."
    return f"{name} {_shown(arguments[name])} is not possible: it must be {allowed}."


def bad_address(uri: str, error: ValidationError) -> str:
    """The answer to a resource address with a part of the wrong kind."""
    first = error.errors(include_url=False, include_context=False)[0]
    part = ".".join(map(str, first["loc"]))
    return f"There is no resource {uri}: {part} {_shown(first['input'])} is not a whole number."


def _shown(value: object) -> str:
    """A bad value as JSON, cut where it gets long."""
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
