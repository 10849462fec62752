"""The reference of the tools, ``docs/reference.md``, made from what the server itself says of them.

``PYTHONPATH=tests python tests/contract/tool_reference.py`` writes it anew.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mcp.types import ToolAnnotations

Schema = dict[str, Any]

FILE = Path(__file__).resolve().parents[2] / "docs" / "reference.md"
HEAD = """\
# The tools, one by one

Made from the tools' own schemas and descriptions by `PYTHONPATH=tests python tests/contract/tool_reference.py`; a test fails when it is
not up to date. What all tools have in common is in [tools.md](tools.md). Descriptions are the first paragraph of what hosts are given.
*Set* is the smallest of `--tools paper`, `standard` and `all` that holds the tool. Models of answers follow the tools."""


def reference() -> str:
    """The whole page."""
    from folding_server.mcp.catalogue import FOR_EVALUATION, READING_FILES, RECORDS, tools

    made = {tool.name: tool for tool in tools(reading_files=True, for_evaluation=True)}
    parts = [HEAD]
    models: dict[str, Schema] = {}
    for record in (*RECORDS, *READING_FILES, *FOR_EVALUATION):
        tool = made[record.name]
        answer: Schema = tool.fn_metadata.output_model.model_json_schema()
        models |= {name: part for name, part in answer.pop("$defs", {}).items() if name not in models}
        models[answer["title"]] = answer
        sent = "JSON text, with pictures" if record.pictures else "structured content"
        offered = " Offered with `--allow`." if record in READING_FILES else ""
        offered = " Offered with `--for-evaluation`." if record in FOR_EVALUATION else offered
        hints = _in_words(record.hints, of_run="run_id" in tool.parameters["properties"])
        facts = f"{hints}{offered} Set: `{record.within}`. Answers with {_linked(answer['title'])} as {sent}."
        first = tool.description.partition("\n\n")[0]
        parts += [f"## `{record.name}`: {record.title}", first, facts, *_arguments(tool.parameters)]
    parts.append("# The models of the answers")
    for name, model in sorted(models.items()):
        parts += [f"## {name}", *_described(model), _table("field", _fields(model))]
    return "\n\n".join(parts) + "\n"


def _in_words(hints: ToolAnnotations, *, of_run: bool) -> str:
    """What the hints of a tool say."""
    if hints.read_only_hint:
        return "Only looks."
    given = "Takes something away from the run" if hints.destructive_hint else "Adds to the run"
    given = given if of_run else "Keeps something new"
    return f"{given}; a second call changes nothing more." if hints.idempotent_hint else f"{given}."


def _arguments(schema: Schema) -> list[str]:
    """The table of a tool's arguments."""
    required = schema.get("required", [])
    rows = [
        (f"`{name}`", _kind(part), "yes" if name in required else "", part["description"])
        for name, part in schema["properties"].items()
    ]
    return [_table("argument", rows, "type", "needed", "what")] if rows else ["It takes no arguments."]


def _fields(model: Schema) -> Iterator[tuple[str, ...]]:
    """The fields of a model with their types and, where they have some, defaults."""
    for name, part in model.get("properties", {}).items():
        default = f", `{part['default']}` if left out" if part.get("default") and "const" not in part else ""
        yield f"`{name}`", _kind(part) + default


def _described(model: Schema) -> list[str]:
    """What a model's docstring says."""
    return [model["description"].replace("``", "`")] if "description" in model else []


def _table(first: str, rows: Any, *others: str) -> str:
    """A table in Markdown."""
    heads = (first, *(others or ("type",)))
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _kind(part: Schema) -> str:
    """A type in words: what it is, what it may be, how large."""
    if "$ref" in part:
        return _linked(part["$ref"].rpartition("/")[2])
    for choice in ("anyOf", "oneOf"):
        if choice in part:
            return " or ".join(_kind(each) for each in part[choice])
    if "const" in part:
        return f"`{part['const']}`"
    if "enum" in part:
        return ", ".join(f"`{value}`" for value in part["enum"])
    if part.get("type") == "array":
        return _array(part)
    if isinstance(part.get("additionalProperties"), dict):
        return f"object of {_kind(part['additionalProperties'])}"
    return f"{part.get('type', 'anything')}{_bounds(part)}"


def _array(part: Schema) -> str:
    """An array: of what, and how many."""
    if "prefixItems" in part:
        return f"[{', '.join(_kind(each) for each in part['prefixItems'])}]"
    least, most = part.get("minItems"), part.get("maxItems")
    kind = _kind(part.get("items", {}))
    return f"[{', '.join([kind] * least)}]" if least is not None and least == most else f"list of {kind}"


def _bounds(part: Schema) -> str:
    """The bounds of a number."""
    least, most = part.get("minimum"), part.get("maximum")
    if least is not None and most is not None:
        return f" from {least:g} to {most:g}"
    return f" from {least:g}" if least is not None else f" to {most:g}" if most is not None else ""


def _linked(name: str) -> str:
    """The name of a model, as a link to it."""
    return f"[{name}](#{name.lower()})"


if __name__ == "__main__":
    FILE.write_text(reference(), encoding="utf-8")
