"""The schemas that hosts are given, in the part of JSON Schema that all of them take.

Measured in hosts: VS Code refuses arrays without ``items``, for which ``prefixItems`` does not count; google-genai
refuses ``additionalProperties: false``; Gemini takes no enumeration of integers; titles that repeat a name cost tokens.
"""

from typing import Any

Schema = dict[str, Any]
"""A JSON schema: of a tool's arguments, or of its answer."""


def lean_input(schema: Schema) -> Schema:
    """The schema of arguments: what is optional is not required, rather than nullable or with a default of null."""
    properties = {name: _argument(part) for name, part in schema.get("properties", {}).items()}
    lean: Schema = {"type": "object", "properties": properties}
    return {**lean, "required": schema["required"]} if schema.get("required") else lean


def _argument(part: Schema) -> Schema:
    """One argument. Its description says what leaving it out means."""
    kinds = [each for each in part.get("anyOf", ()) if each.get("type") != "null"]
    kept = {key: value for key, value in part.items() if key not in ("title", "default", "anyOf")}
    return {**(kinds[0] if kinds else {}), **kept}


def lean_output(schema: Schema) -> Schema:
    """The schema of an answer: its fields and their types. What objects within it hold is left open."""
    properties = {name: _field(part) for name, part in schema.get("properties", {}).items()}
    lean: Schema = {"type": "object", "properties": properties}
    return {**lean, "required": schema["required"]} if schema.get("required") else lean


def _field(part: Schema) -> Schema:
    """One field of an answer, or what an array holds."""
    if "anyOf" in part:
        kinds = [_field(each) for each in part["anyOf"]]
        plain = [each["type"] for each in kinds if each.keys() == {"type"}]
        return {"type": plain} if len(plain) == len(kinds) else {"anyOf": kinds}
    if "$ref" in part or "oneOf" in part:
        return {"type": "object"}
    lean: Schema = {key: part[key] for key in ("type", "enum") if key in part}
    return {**lean, "items": _field(part.get("items", {}))} if part.get("type") == "array" else lean
