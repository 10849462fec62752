"""The tool surface as a contract: its committed form, and whether a change breaks hosts that rely on it.

``python tests/contract/tool_contract.py`` writes ``tools.json`` anew and says what changed.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mcp.server.mcpserver.tools import Tool

Schema = dict[str, Any]
Contract = dict[str, Schema]

FILE = Path(__file__).with_name("tools.json")


def current() -> Contract:
    """The tools as the server states them, without prose: descriptions may be reworded freely.

    ``output`` is the whole model of the answer, of which hosts are given a lean schema or, with pictures, none.
    """
    from folding_server.mcp.catalogue import tools

    return {
        tool.name: {
            "input": _without_prose(tool.parameters),
            "output": _without_prose(_answer(tool)),
            "structured": tool.output_schema is not None,
            "read_only": bool(tool.annotations and tool.annotations.read_only_hint),
        }
        for tool in tools(reading_files=True, for_evaluation=True)
    }


def _answer(tool: "Tool") -> Schema:
    """The schema of the model that a tool answers with."""
    schema: Schema = tool.fn_metadata.output_model.model_json_schema()
    return schema


def committed() -> Contract:
    """The tools as last agreed."""
    contract: Contract = json.loads(FILE.read_text(encoding="utf-8"))
    return contract


def breaking(old: Contract, new: Contract) -> list[str]:
    """What a host written for the old contract would stumble over in the new one, one line each."""
    gone = [f"{name}: the tool is gone" for name in old if name not in new]
    kept = [name for name in old if name in new]
    return gone + [f"{name}: {line}" for name in kept for line in _broken_tool(old[name], new[name])]


def compatible(old: Contract, new: Contract) -> list[str]:
    """The tools that differ without breaking anything."""
    broken = {line.partition(":")[0] for line in breaking(old, new)}
    return [name for name in new if old.get(name) != new[name] and name not in broken]


def _broken_tool(old: Schema, new: Schema) -> Iterator[str]:
    """A host sends what it always sent and reads what it always read."""
    yield from _narrower(old["input"], new["input"])
    if old.get("structured", True) and not new["structured"]:
        yield "the answer is not structured content any more"
    before, after = old["output"], new["output"]
    yield from _lost(before, after, "the answer")
    for name, definition in before.get("$defs", {}).items():
        yield from _lost(definition, after.get("$defs", {}).get(name, definition), f"the answer's {name}")


def _lost(before: Schema, after: Schema, what: str) -> Iterator[str]:
    """What a reader of an object's fields misses or finds otherwise; more fields are no loss."""
    if _properties(before) or _properties(after):
        for name, schema in _properties(before).items():
            if name not in _properties(after):
                yield f"{what} lost {name}"
            elif name in before.get("required", []) and name not in after.get("required", []):
                yield f"{what} may lack {name}"
            elif schema != _properties(after)[name]:
                yield f"{what}'s {name} changed" if what == "the answer" else f"{what} changed its {name}"
    elif before != after:
        yield f"{what} changed"


def _narrower(old: Schema, new: Schema) -> Iterator[str]:
    """Arguments that were allowed and no longer are."""
    for name, schema in _properties(old).items():
        if name not in _properties(new):
            yield f"the argument {name} is gone"
        elif schema != _properties(new)[name]:
            yield f"the argument {name} changed"
    for name in new.get("required", []):
        if name not in old.get("required", []):
            yield f"the argument {name} is now required"


def _properties(schema: Schema) -> Schema:
    properties: Schema = schema.get("properties", {})
    return properties


def _without_prose(schema: Any) -> Any:
    """A schema without titles and descriptions (but with properties that happen to be called so)."""
    if isinstance(schema, list):
        return [_without_prose(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    return {
        key: {name: _without_prose(part) for name, part in value.items()}
        if key in ("properties", "$defs")
        else _without_prose(value)
        for key, value in schema.items()
        if key not in ("title", "description")
    }


def main() -> None:
    """Write the contract as it is now."""
    old, new = (committed() if FILE.exists() else {}), current()
    FILE.write_text(json.dumps(new, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    for line in breaking(old, new):
        print(f"breaking    {line}")
    for name in compatible(old, new):
        print(f"compatible  {name}: {'changed' if name in old else 'new'}")


if __name__ == "__main__":
    main()
