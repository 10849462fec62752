"""Checking that tools are named and described in the part of JSON schema that all providers take."""

import re
from typing import Any

KNOWN = {"type", "description", "properties", "required", "items", "enum", "minimum", "maximum"}
KNOWN |= {"minItems", "maxItems"}
_NAME = re.compile(r"[a-zA-Z0-9_-]{1,64}")


def check_tool(name: str, description: str, parameters: dict[str, Any]) -> None:
    """Raise AssertionError at a tool that one of the providers refuses."""
    assert _NAME.fullmatch(name), name
    assert description, f"{name} is described"
    assert parameters.get("type") == "object", f"the parameters of {name} are an object"
    check_schema(parameters)


def check_schema(schema: dict[str, Any]) -> None:
    """Raise AssertionError at whatever one of the providers refuses."""
    assert set(schema) <= KNOWN, sorted(set(schema) - KNOWN)
    assert "type" in schema, schema
    if schema["type"] == "array":
        check_schema(schema["items"])
    if "enum" in schema:
        assert schema["type"] == "string", schema
    assert set(schema.get("required", [])) <= set(schema.get("properties", {})), schema
    for inner in schema.get("properties", {}).values():
        check_schema(inner)
