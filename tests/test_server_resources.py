"""Resources, prompts and the server's own words, through the protocol."""

import base64
import json
from pathlib import Path

import jsonschema
import pytest
from folding_prompts import prompt, tool_description
from folding_schemas.actions import Program
from folding_schemas.results import RunInfo, SequenceList
from folding_schemas.state import FoldedState
from folding_server.frames.image_files import decode_bytes
from folding_server.frames.sequences import THUMBNAIL_BYTES, THUMBNAIL_SIDE
from hosts import Host, in_memory
from mcp.types import BlobResourceContents, PromptReference, TextContent, TextResourceContents
from paths import ROOT
from photographed import photos

pytestmark = pytest.mark.anyio


async def text(host: Host, uri: str) -> str:
    """A text resource."""
    (content,) = (await host.client.read_resource(uri)).contents
    assert isinstance(content, TextResourceContents)
    return content.text


async def data(host: Host, uri: str) -> bytes:
    """A binary resource."""
    (content,) = (await host.client.read_resource(uri)).contents
    assert isinstance(content, BlobResourceContents)
    return base64.b64decode(content.blob)


async def test_a_run_can_be_read_as_resources(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        opened = await host.call("open_run")
        folded = await host.call("fold", edge=[1, 3], direction=1)
        run = f"folding://runs/{opened['run_id']}"
        assert RunInfo.model_validate_json(await text(host, run)).pending
        assert (
            FoldedState.model_validate_json(await text(host, f"{run}/state")).model_dump(mode="json")
            == folded["state"]
        )
        assert len(Program.model_validate_json(await text(host, f"{run}/program")).steps) == 1
        assert (await text(host, f"{run}/diagram.svg")).startswith("<svg")
        assert (await data(host, f"{run}/diagram.png")).startswith(b"\x89PNG")


async def test_sequences_and_photos_can_be_read_as_resources(tmp_path: Path) -> None:
    async with in_memory(tmp_path, photos()) as host:
        listed = SequenceList.model_validate_json(await text(host, "folding://sequences"))
        photo = await data(host, "folding://sequences/sailboat/frames/4")
        thumbnail = await data(host, "folding://sequences/sailboat/frames/4/thumbnail")
    assert "sailboat" in [each.name for each in listed.sequences]
    assert photo.startswith(b"\xff\xd8")
    assert max(decode_bytes(thumbnail, "the thumbnail").shape) == THUMBNAIL_SIDE
    assert len(thumbnail) <= THUMBNAIL_BYTES < len(photo)


async def test_every_resource_says_what_it_is(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        fixed = (await host.client.list_resources()).resources
        templates = (await host.client.list_resource_templates()).resource_templates
    assert all(each.description and each.mime_type for each in fixed)
    assert all(each.description and each.mime_type for each in templates)


async def test_the_prompt_for_desktop_hosts_names_the_tools_it_tells_to_use(tmp_path: Path) -> None:
    async with in_memory(tmp_path, ROOT / "examples") as host:
        (message,) = (await host.client.get_prompt("reconstruct", {"sequence": "cat"})).messages
        open_choice = (await host.client.get_prompt("reconstruct")).messages[0]
        tools = {tool.name for tool in (await host.client.list_tools()).tools}
    assert isinstance(message.content, TextContent)
    assert isinstance(open_choice.content, TextContent)
    named = {"open_run", "propose_actions", "compare_to_frame", "generate_checkpoint_overview", "get_run"}
    assert all(f"`{name}`" in message.content.text for name in named)
    assert named <= tools
    assert "sequence cat" in message.content.text
    assert "list_sequences" in open_choice.content.text


async def test_the_agent_s_critics_are_prompts_for_hosts_too(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        offered = {each.name: each for each in (await host.client.list_prompts()).prompts}
        judge = (await host.client.get_prompt("judge_step", {"frame": "5"})).messages[0].content
        next_one = (await host.client.get_prompt("judge_step")).messages[0].content
        look_back = (await host.client.get_prompt("find_mistake")).messages[0].content
    assert offered.keys() == {"reconstruct", "judge_step", "find_mistake", "teach_folding", "design_model"}
    assert all(each.title and each.description for each in offered.values())
    assert isinstance(judge, TextContent)
    assert isinstance(next_one, TextContent)
    assert isinstance(look_back, TextContent)
    assert "Call `critic_grid` for frame 5." in judge.text
    assert "EXTREME DIVERGENCE" in judge.text
    assert "the frame that comes next" in next_one.text
    assert "`generate_checkpoint_overview`" in look_back.text
    assert "last_correct_frame" in look_back.text


async def test_names_of_sequences_are_completed(tmp_path: Path) -> None:
    reference = PromptReference(name="reconstruct")
    async with in_memory(tmp_path, photos()) as host:
        for start, expected in {"sail": ["sailboat"], "boat": []}.items():
            answer = await host.client.complete(reference, {"name": "sequence", "value": start})
            assert answer.completion.values == expected


async def test_answers_are_valid_against_the_published_schemas(tmp_path: Path) -> None:
    async with in_memory(tmp_path, photos()) as host:
        schemas = {tool.name: tool.output_schema for tool in (await host.client.list_tools()).tools}
        answers = {
            "list_sequences": await host.call("list_sequences"),
            "open_run": await host.call("open_run", sequence="sailboat"),
            "save_checkpoint": await host.call("save_checkpoint", frame=1),
            "fold": await host.call("fold", edge=[1, 3], direction=1),
            "critic_grid": await host.call("critic_grid", frame=2),
            "compare_to_frame": await host.call("compare_to_frame", frame=2),
            "list_attempts": await host.call("list_attempts", frame=2),
            "restore_checkpoint": await host.call("restore_checkpoint", frame=1),
            "commit_attempt": await host.call("commit_attempt", frame=2, attempt=1),
            "export_state": await host.call("export_state", format="fold"),
            "check_foldability": await host.call("check_foldability"),
            "get_run": await host.call("get_run"),
        }
    for tool, answer in answers.items():
        if (schema := schemas[tool]) is not None:
            jsonschema.validate(json.loads(json.dumps(answer)), schema)


def test_a_prompt_and_its_caller_must_agree_on_the_placeholders() -> None:
    assert "cat" in prompt("server/reconstruct", sequence="cat")
    with pytest.raises(KeyError, match="sequence"):
        prompt("server/reconstruct")
    with pytest.raises(KeyError, match="colour"):
        prompt("server/reconstruct", sequence="cat", colour="red")
    with pytest.raises(KeyError, match="crumple"):
        tool_description("crumple")
