"""The server in hosts: what each of them shows its model, sends and refuses, by rules taken from the hosts."""

import importlib
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from folding_server.mcp.catalogue import RECORDS, tools
from folding_server.mcp.tool_record import ToolSelection
from host_rules import Schema, codex, gemini, openai_strict, vs_code
from hosts import Host, data_of, images_of, in_memory, stdio, text_of
from mcp import Client, MCPError
from mcp.types import CallToolResult, ImageContent, TextContent
from mcp.types import Tool as ListedTool
from photographed import photos
from token_counting import text_tokens

pytestmark = pytest.mark.anyio

MOST_TOKENS = 9_000
"""Of the whole list of tools: what a host may spend on it before the user has said a word."""
PICTURES: dict[str, dict[str, Any]] = {
    "view_frame": {"frame": 2},
    "observe_movement": {"frame": 2},
    "render_current": {},
    "generate_checkpoint_overview": {},
    "list_attempts": {"frame": 2},
    "critic_grid": {"frame": 2},
    "compare_to_frame": {"frame": 2},
    "export_state": {"format": "png"},
    "get_instructions": {},
    "try_program": {"program": {"steps": [[{"action": "fold", "edge": [1, 3], "direction": 1}]]}},
}
"""A call of each tool with pictures that has some."""


async def a_saved_fold(host: Host) -> None:
    """A run on the sailboat with frame 1 saved and one fold done."""
    await host.call("open_run", sequence="sailboat")
    await host.call("save_checkpoint", frame=1)
    await host.call("fold", edge=[1, 3], direction=1)


def codex_shows(result: CallToolResult) -> list[str]:
    """What Codex gives its model: structured content alone where there is any, else texts and images."""
    if result.structured_content is not None:
        return [json.dumps(result.structured_content)]
    return [
        block.text if isinstance(block, TextContent) else f"<{block.mime_type}>"
        for block in result.content
        if isinstance(block, TextContent | ImageContent)
    ]


class TestPictures:
    def test_every_tool_with_pictures_is_called_here(self) -> None:
        assert {record.name for record in RECORDS if record.pictures} == PICTURES.keys()

    async def test_codex_gives_its_model_text_data_and_every_picture(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            await a_saved_fold(host)
            listed = {tool.name: tool for tool in (await host.client.list_tools()).tools}
            for tool, arguments in PICTURES.items():
                answer = await host.answer(tool, **arguments)
                said, data, *pictures = codex_shows(answer)
                assert listed[tool].output_schema is None
                assert said.endswith(".")
                assert json.loads(data)
                assert pictures == [f"<{image.mime_type}>" for image in images_of(answer)] != []

    async def test_answers_without_pictures_are_structured_and_say_by_which_schema(
        self, tmp_path: Path
    ) -> None:
        async with in_memory(tmp_path) as host:
            answer = await host.answer("open_run")
            listed = {tool.name: tool for tool in (await host.client.list_tools()).tools}
        assert answer.structured_content is not None
        assert json.loads(text_of(answer).splitlines()[1]) == answer.structured_content
        for record in RECORDS:
            assert (listed[record.name].output_schema is None) == record.pictures, record.name

    async def test_pictures_can_be_left_out_or_made_small(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            await a_saved_fold(host)
            for tool, arguments in PICTURES.items():
                full = await host.answer(tool, **arguments)
                small = await host.answer(tool, **arguments, images="small")
                none = await host.answer(tool, **arguments, images="none")
                assert data_of(full) == data_of(small) == data_of(none)
                assert len(images_of(small)) == len(images_of(full))
                assert sum(map(width, images_of(small))) <= sum(map(width, images_of(full))) // 2
                assert images_of(none) == []
                assert text_of(none).startswith("Without pictures: ")


def width(image: ImageContent) -> int:
    """The width of an image in pixels."""
    from base64 import b64decode
    from io import BytesIO

    from PIL import Image

    return Image.open(BytesIO(b64decode(image.data))).width


class TestSchemas:
    @pytest.mark.parametrize("rule", [vs_code, gemini, openai_strict])
    def test_every_tool_keeps_the_rules_of(self, rule: Callable[[Schema], Iterator[str]]) -> None:
        offered = tools(reading_files=True)
        assert [(tool.name, broken) for tool in offered for broken in rule(tool.parameters)] == []

    @pytest.mark.parametrize(
        ("rule", "schema"),
        [
            (vs_code, {"type": "array", "prefixItems": [{"type": "integer"}]}),
            (gemini, {"type": "integer", "enum": [1, -1]}),
            (gemini, {"type": "object", "additionalProperties": False}),
            (gemini, {"anyOf": [{"type": "string"}, {"type": "null"}]}),
            (openai_strict, {"type": "array", "prefixItems": [{"type": "integer"}]}),
            (openai_strict, {"type": "string", "title": "Axis"}),
        ],
    )
    def test_a_rule_tells_what_its_host_refuses(
        self, rule: Callable[[Schema], Iterator[str]], schema: Schema
    ) -> None:
        assert list(rule({"type": "object", "properties": {"x": schema}}))

    def test_codex_changes_nothing(self) -> None:
        assert all(codex(tool.parameters) == tool.parameters for tool in tools(reading_files=True))

    async def test_google_genai_converts_every_tool(self, tmp_path: Path) -> None:
        convert = importlib.import_module("google.genai._mcp_utils").mcp_to_gemini_tool
        async with in_memory(tmp_path) as host:
            listed = (await host.client.list_tools()).tools
        converted = [convert(tool).function_declarations[0] for tool in listed]
        assert [each.name for each in converted] == [tool.name for tool in listed]
        (fold,) = [each for each in converted if each.name == "fold"]
        assert fold.parameters.properties["edge"].items.type == "INTEGER"
        assert sorted(fold.parameters.required) == ["direction", "edge"]

    def test_optional_arguments_say_what_leaving_them_out_means(self) -> None:
        for tool in tools(reading_files=True):
            optional = tool.parameters["properties"].keys() - set(tool.parameters.get("required", ()))
            for name in optional - {"notes", "sequence", "labels"} - ({"run_id"} & {tool.name}):
                said = tool.parameters["properties"][name]["description"]
                assert "left out" in said or tool.name == "open_run", (tool.name, name)


class TestArguments:
    async def test_arguments_that_hosts_add_are_ignored_and_named(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            done = await host.answer("fold", edge=[1, 3], direction=1, wait_for_previous=True, toolCallId="x")
            refused = await host.refusal("fold", edges=[1, 3], direction=1)
        first = done.content[0]
        assert isinstance(first, TextContent)
        assert "Ignored: 'wait_for_previous', 'toolCallId'; the arguments of fold are edge" in first.text
        assert data_of(done)["moved_faces"]
        assert "needs edge" in refused
        assert "Ignored: 'edges'" in refused

    @pytest.mark.parametrize("left_out", [None, ""])
    async def test_null_and_empty_text_mean_left_out(self, tmp_path: Path, left_out: str | None) -> None:
        async with in_memory(tmp_path) as host:
            opened = await host.call("open_run", sequence=left_out, run_id=left_out)
            await host.call("fold", edge=[1, 3], direction=1, run_id=left_out)
            drawn = await host.call("render_current", labels=left_out, images=left_out)
            opened_again = await host.call("unfold", edge=left_out)
            await host.call("save_checkpoint", frame=2, notes=left_out)
            saved = await host.call("get_checkpoint_state", frame=2)
        assert opened["sequence"] is None
        assert drawn["labels"] is False
        assert opened_again["run_id"] == opened["run_id"]
        assert saved["notes"] is None

    @pytest.mark.parametrize("notes", ["[1]", '{"a": 1}', "null", "true", '"quoted"'])
    async def test_text_stays_as_it_was_sent(self, tmp_path: Path, notes: str) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            await host.call("save_checkpoint", frame=2, notes=notes)
            assert (await host.call("get_checkpoint_state", frame=2))["notes"] == notes

    @pytest.mark.slow
    @pytest.mark.parametrize("edge", ["[1, 3]", "1, 3", "1 3", ["1", "3"], [1.0, 3.0]])
    @pytest.mark.parametrize("direction", ["1", "+1", 1.0])
    async def test_numbers_and_lists_as_text_are_read(
        self, tmp_path: Path, edge: object, direction: object
    ) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            folded = await host.call("fold", edge=edge, direction=direction)
            await host.call("save_checkpoint", frame="2")
            turned = await host.call("rotate", angle="90")
        assert folded["moved_faces"]
        assert turned["summary"].startswith("Done: rotate(90.0).")


class TestList:
    async def test_every_tool_resource_and_prompt_has_a_title_and_an_icon(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            listed = [
                *(await host.client.list_tools()).tools,
                *(await host.client.list_resource_templates()).resource_templates,
                *(await host.client.list_prompts()).prompts,
                *(r for r in (await host.client.list_resources()).resources if r.uri.startswith("folding:")),
            ]
        assert all(each.title and each.icons for each in listed)
        assert len({each.title for each in listed}) == len(listed)
        assert all(
            str(icon.src).startswith("data:image/svg+xml,") for each in listed for icon in each.icons or ()
        )

    def test_hints_say_what_may_be_called_again(self) -> None:
        again = {tool.name for tool in tools() if tool.annotations and tool.annotations.idempotent_hint}
        assert {"get_run", "view_frame", "commit_attempt"} <= again
        assert not again & {"fold", "rotate", "flip", "undo", "save_checkpoint", "restore_checkpoint"}

    async def test_the_whole_list_is_short(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            listed = (await host.client.list_tools()).tools
        assert sum(map(tokens, listed)) <= MOST_TOKENS

    def test_each_set_holds_the_one_before(self) -> None:
        paper, standard, everything = (names(each) for each in ("paper", "standard", "all"))
        assert paper < standard < everything
        assert "undo" in standard - paper
        assert "propose_actions" in everything - standard
        assert {"open_run", "list_runs", "commit_attempt"} <= paper

    async def test_the_command_line_chooses_the_tools(self, tmp_path: Path) -> None:
        command = stdio(tmp_path)
        command.args += ["--tools", "paper", "--read-only"]
        async with Client(command) as client:
            offered = {tool.name for tool in (await client.list_tools()).tools}
        assert offered == {tool.name for tool in tools("paper", read_only=True)}

    async def test_a_read_only_server_offers_and_carries_out_no_change(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            run_id = (await host.call("open_run"))["run_id"]
        async with in_memory(tmp_path, read_only=True) as host:
            listed = (await host.client.list_tools()).tools
            assert all(tool.annotations and tool.annotations.read_only_hint for tool in listed)
            assert "no tool 'fold'" in await host.refusal("fold", edge=[1, 3], direction=1, run_id=run_id)
            assert (await host.call("get_run", run_id=run_id))["run_id"] == run_id


def tokens(tool: ListedTool) -> int:
    """Tokens of a tool as it is listed, by the tokeniser that the benchmarks count with."""
    listed = tool.model_dump(mode="json", by_alias=True, exclude_none=True)
    text = json.dumps(listed, ensure_ascii=False, separators=(",", ":"))
    return text_tokens(text)


def names(tool_set: ToolSelection) -> set[str]:
    """The names of a set's tools."""
    return {tool.name for tool in tools(tool_set)}


class TestRefusals:
    async def test_long_names_are_cut_as_long_values_are(self, tmp_path: Path) -> None:
        long = "x" * 1_000_000
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            said = [
                text_of(await host.answer("rotate", angle=1, **{long: 1})).splitlines()[0],
                await host.refusal("rotate", **{long: 1}),
                await host.refusal(long),
                await host.refusal("rotate", angle=long),
                await host.refusal("get_run", run_id=long),
                await host.refusal("flip", axis={long: long}),
            ]
        assert all(len(sentence) < 1000 for sentence in said)

    async def test_a_long_address_is_cut(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            for start in ("folding://", "folding://runs/", "folding://sequences/x/frames/"):
                with pytest.raises(MCPError) as error:
                    await host.client.read_resource(start + "x" * 100_000)
                assert len(error.value.message) < 500
                assert error.value.message.endswith(".")

    async def test_many_strange_names_are_counted(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            said = text_of(await host.answer("rotate", angle=1, **{f"n{i}": i for i in range(2000)}))
        assert "'n4' and 1995 more" in said
