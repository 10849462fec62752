"""What hosts and providers accept as the schema of a tool's arguments, as rules: each yields what it would refuse."""

from collections.abc import Iterator
from typing import Any

Schema = dict[str, Any]

STRICT_KEYWORDS = frozenset(
    {
        "type",
        "description",
        "properties",
        "required",
        "items",
        "enum",
        "minimum",
        "maximum",
        "minItems",
        "maxItems",
    }
)
"""Keywords of our schemas that OpenAI's strict mode takes ("Structured outputs", supported schemas)."""


def nodes(schema: Schema, where: str = "") -> Iterator[tuple[str, Schema]]:
    """A schema and all schemas within it, with where they are."""
    yield where, schema
    for name, part in schema.get("properties", {}).items():
        yield from nodes(part, f"{where}.{name}")
    for key in ("items", "prefixItems", "anyOf", "oneOf", "allOf"):
        found = schema.get(key, ())
        for part in found if isinstance(found, list) else [found] if found else ():
            yield from nodes(part, f"{where}.{key}")


def vs_code(schema: Schema) -> Iterator[str]:
    """VS Code fails the whole request for an array without ``items``; ``prefixItems`` does not count."""
    for where, node in nodes(schema):
        if node.get("type") == "array" and not node.get("items"):
            yield f"{where}: array type must have items"


def gemini(schema: Schema) -> Iterator[str]:
    """Gemini takes enumerations of text alone, one type for each value, and no ``additionalProperties``."""
    for where, node in nodes(schema):
        if any(not isinstance(value, str) for value in node.get("enum", ())) or "const" in node:
            yield f"{where}: only text can be enumerated"
        if "additionalProperties" in node:
            yield f"{where}: additionalProperties"
        if isinstance(node.get("type"), list) or "anyOf" in node:
            yield f"{where}: more than one type"
        if node.get("type") == "array" and not node.get("items"):
            yield f"{where}: array without items"


def openai_strict(schema: Schema) -> Iterator[str]:
    """Strict mode refuses keywords it does not know; converters add ``additionalProperties`` and ``required``."""
    for where, node in nodes(schema):
        for keyword in sorted(node.keys() - STRICT_KEYWORDS):
            yield f"{where}: {keyword}"
        if "type" not in node:
            yield f"{where}: no type"


def codex(schema: Schema) -> Schema:
    """What Codex makes of a schema: an array without ``items`` becomes an array of text."""
    if schema.get("type") == "array" and "items" not in schema:
        return {**schema, "items": {"type": "string"}}
    properties = {name: codex(part) for name, part in schema.get("properties", {}).items()}
    return {**schema, "properties": properties} if properties else schema
