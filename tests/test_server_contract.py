"""The tool surface is what was agreed, and a change of it is called compatible or breaking."""

import copy
import re
from collections.abc import Callable

import pytest
from contract import tool_reference
from contract.tool_contract import Contract, Schema, breaking, committed, compatible, current
from folding_server.mcp.catalogue import tools
from paths import ROOT


def test_the_tools_are_those_of_the_contract() -> None:
    changed = [
        *(f"breaking: {line}" for line in breaking(committed(), current())),
        *(f"compatible: {name}" for name in compatible(committed(), current())),
    ]
    assert current() == committed(), f"run tests/contract/tool_contract.py and commit its result; {changed}"


def test_every_tool_says_what_it_is_for_and_what_its_arguments_mean() -> None:
    for tool in tools(reading_files=True, for_evaluation=True):
        assert len(tool.description) > 80, tool.name
        assert all(schema.get("description") for schema in tool.parameters.get("properties", {}).values()), (
            tool.name
        )
        assert "run_id" in tool.parameters["properties"] or tool.name in {
            "list_sequences",
            "list_runs",
            "add_sequence",
            "try_program",
            "remove_sequence",
        }


def test_descriptions_say_the_bounds_that_are_not_sent_to_every_model() -> None:
    for tool in tools(reading_files=True, for_evaluation=True):
        for name, schema in tool.parameters["properties"].items():
            for each in (schema, *schema.get("anyOf", ())):
                for bound in ("minimum", "maximum"):
                    assert str(each.get(bound, "")) in schema["description"], (tool.name, name, bound)
            if "minItems" in schema:
                assert schema["description"].startswith("two vertex ids")


def test_the_page_about_the_tools_names_them_all_and_no_others() -> None:
    table = (ROOT / "docs" / "tools.md").read_text(encoding="utf-8").partition("## Which run")[0]
    named = re.findall(r"`(\w+)`", table)
    assert sorted(named) == sorted(tool.name for tool in tools(reading_files=True, for_evaluation=True))


def test_the_reference_says_what_the_tools_say() -> None:
    written = tool_reference.FILE.read_text(encoding="utf-8")
    assert written == tool_reference.reference(), "run tests/contract/tool_reference.py and commit its result"
    assert all(
        f"## `{tool.name}`: {tool.title}" in written
        for tool in tools(reading_files=True, for_evaluation=True)
    )


@pytest.fixture
def contract() -> Contract:
    """A contract to change."""
    return copy.deepcopy(committed())


def test_a_new_optional_argument_and_a_new_answer_field_are_compatible(contract: Contract) -> None:
    contract["fold"]["input"]["properties"]["angle"] = {"type": "number"}
    contract["fold"]["output"]["properties"]["time"] = {"type": "number"}
    contract["fold"]["output"]["$defs"]["FoldedState"]["properties"]["weight"] = {"type": "number"}
    assert breaking(committed(), contract) == []
    assert compatible(committed(), contract) == ["fold"]


def test_a_new_tool_is_compatible_and_a_lost_one_is_breaking(contract: Contract) -> None:
    assert compatible({}, contract) == list(contract)
    del contract["fold"]
    assert breaking(committed(), contract) == ["fold: the tool is gone"]


@pytest.mark.parametrize(
    ("part", "change", "named"),
    [
        ("input", lambda schema: schema["required"].append("run_id"), "run_id is now required"),
        ("input", lambda schema: schema["properties"].pop("edge"), "edge is gone"),
        ("input", lambda schema: schema["properties"]["direction"].update(enum=[1]), "direction changed"),
        ("output", lambda schema: schema["properties"].pop("state"), "lost state"),
        ("output", lambda schema: schema["required"].remove("state"), "may lack state"),
        (
            "output",
            lambda schema: schema["$defs"]["FoldedState"]["properties"].pop("layers"),
            "FoldedState lost layers",
        ),
        (
            "output",
            lambda schema: schema["$defs"]["FoldedState"]["properties"]["layers"].update(type="string"),
            "FoldedState changed its layers",
        ),
    ],
)
def test_what_would_fail_a_host_is_breaking(
    contract: Contract, part: str, change: Callable[[Schema], object], named: str
) -> None:
    change(contract["fold"][part])
    assert any(named in line for line in breaking(committed(), contract))
