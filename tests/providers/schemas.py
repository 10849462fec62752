"""Checking that a tool's parameters are in the part of JSON schema that all providers take."""

from typing import Any

KNOWN = {"type", "description", "properties", "required", "items", "enum", "minimum", "maximum"}
KNOWN |= {"minItems", "maxItems"}


def check_schema(schema: dict[str, Any]) -> None:
    """Raise AssertionError at whatever one of the providers refuses."""
    assert set(schema) <= KNOWN, sorted(set(schema) - KNOWN)
    assert "type" in schema, schema
    if schema["type"] == "array":
        check_schema(schema["items"])
    if "enum" in schema:
        assert schema["type"] == "string", schema
    for inner in schema.get("properties", {}).values():
        check_schema(inner)
