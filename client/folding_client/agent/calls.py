"""Checking a model's tool call against the tool's own JSON schema, before anything is sent."""

import json
from collections.abc import Mapping
from difflib import get_close_matches

import jsonschema

from folding_client.interrupts import CallRefused
from folding_client.messages import JsonObject, ToolCall, ToolSpec


def checked_arguments(call: ToolCall, offered: Mapping[str, ToolSpec]) -> JsonObject:
    """The call's arguments as data. CallRefused, with what to do instead, if they cannot be sent."""
    spec = offered.get(call.name)
    if spec is None:
        raise CallRefused(_unknown_tool(call.name, offered))
    arguments = _parsed(call)
    properties = spec.schema.get("properties", {})
    if unknown := sorted(set(arguments) - set(properties)):
        allowed = ", ".join(properties) or "none"
        message = (
            f"{call.name} has no argument {', '.join(map(repr, unknown))}; its arguments are: {allowed}."
        )
        raise CallRefused(message)
    validator = jsonschema.Draft202012Validator(spec.schema)
    if error := jsonschema.exceptions.best_match(validator.iter_errors(arguments)):
        where = "/".join(str(part) for part in error.absolute_path)
        message = (
            f"The arguments of {call.name} do not fit{f' at {where}' if where else ''}: {error.message}."
        )
        raise CallRefused(message)
    return arguments


def _parsed(call: ToolCall) -> JsonObject:
    try:
        arguments = json.loads(call.arguments or "{}")
    except ValueError as error:
        message = (
            f"The arguments of {call.name} are not JSON ({error}): {call.arguments[:200]!r}. Send one "
            "JSON object."
        )
        raise CallRefused(message) from error
    if not isinstance(arguments, dict):
        message = f"The arguments of {call.name} are {call.arguments[:200]!r}; send one JSON object instead."
        raise CallRefused(message)
    return arguments


def _unknown_tool(name: str, offered: Mapping[str, ToolSpec]) -> str:
    near = get_close_matches(name, offered, n=1)
    hint = f" Did you mean {near[0]}?" if near else ""
    return f"There is no tool {name!r}.{hint} The tools are: {', '.join(offered)}."
