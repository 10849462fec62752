"""A tool's JSON schema in the words that every provider understands, and no more of them than a model needs.

Providers take subsets of JSON schema: Gemini knows no references, tuples or numbered choices, OpenAI wants
every array to say what it holds. Calls are checked against the full schema, so what is left out here is lost
to the model's provider only; descriptions say it in prose, as they do the bounds of numbers and lengths.
"""

from typing import Any

from folding_client.messages import JsonObject

_KEPT = frozenset({"type", "description", "properties", "required", "items", "enum", "anyOf"})


def portable(schema: JsonObject) -> JsonObject:
    """The schema of a tool's arguments without references, tuples, null alternatives, numbered choices, titles and a
    description of its own, since the tool has one.
    """
    simple = _simple(schema, schema.get("$defs", {}))
    simple.pop("description", None)
    return simple


def _simple(schema: JsonObject, definitions: JsonObject) -> JsonObject:
    schema = _resolved(schema, definitions)
    kept = {key: value for key, value in schema.items() if key in _KEPT}
    if "prefixItems" in schema and "items" not in schema:
        kept["items"] = schema["prefixItems"][0]
    if kept.get("type") != "string":
        kept.pop("enum", None)
    if not kept.get("required"):
        kept.pop("required", None)
    return {key: _simple_part(key, value, definitions) for key, value in kept.items()}


def _resolved(schema: JsonObject, definitions: JsonObject) -> JsonObject:
    """The schema with its reference looked up, and with its only alternative to null in its place."""
    if "$ref" in schema:
        target = definitions[schema["$ref"].rsplit("/", 1)[-1]]
        return _resolved({**target, **{k: v for k, v in schema.items() if k != "$ref"}}, definitions)
    alternatives = [each for each in schema.get("anyOf", ()) if each.get("type") != "null"]
    if len(alternatives) == 1:
        rest = {key: value for key, value in schema.items() if key != "anyOf"}
        return _resolved({**alternatives[0], **rest}, definitions)
    return schema


def _simple_part(key: str, value: Any, definitions: JsonObject) -> Any:  # noqa: ANN401
    if key == "properties":
        return {name: _simple(each, definitions) for name, each in value.items()}
    if key == "items":
        return _simple(value, definitions)
    return [_simple(each, definitions) for each in value] if key == "anyOf" else value
