"""Instructions through the protocol: sheets and single steps, programs tried whole, the prompts that use them."""

import json
from pathlib import Path

import pytest
from folding_schemas.actions import Program
from hosts import in_memory, text_of
from mcp.types import ImageContent
from paths import EXAMPLES, ROOT
from pydantic import TypeAdapter

pytestmark = pytest.mark.anyio
CUP = json.loads((EXAMPLES / "programs" / "cup.json").read_text())


async def test_a_run_is_told_in_words_and_drawn(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        await host.call("open_run")
        await host.call("fold", edge=[1, 3], direction=1)
        await host.call("flip", axis="x")
        whole = await host.answer("get_instructions")
        one = await host.answer("get_instructions", step=1)
        bare = await host.call("get_instructions", images="none")
        refused = await host.refusal("get_instructions", step=9)
    assert whole.structured_content is None
    assert [type(block).__name__ for block in whole.content] == ["TextContent", "TextContent", "ImageContent"]
    assert text_of(one).startswith("1. Bring the top right corner to the bottom left corner (axiom 2).")
    assert len(bare["steps"]) == 3 and bare["refusal"] is None
    assert "no step 9" in refused and "1 to 3" in refused


async def test_a_program_is_tried_without_a_run(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        answer = await host.answer("try_program", program=CUP)
        as_text = await host.call("try_program", program=json.dumps(CUP), images="none")
        runs = await host.call("list_runs")
    assert sum(isinstance(block, ImageContent) for block in answer.content) == 1
    assert as_text["complete"] and as_text["steps_done"] == 7 and as_text["error"] is None
    assert runs["runs"] == []


async def test_the_step_that_fails_is_named_and_those_before_it_are_kept(tmp_path: Path) -> None:
    bad = {**CUP, "steps": [*CUP["steps"][:2], [{"action": "fold", "edge": [1, 77], "direction": 1}]]}
    unread = {"steps": [[{"action": "fold", "edge": [1, 3], "direction": 2}]]}
    async with in_memory(tmp_path) as host:
        tried = await host.call("try_program", program=bad, images="none")
        wrong = await host.call("try_program", program=unread)
        nonsense = await host.call("try_program", program="no program")
    assert (tried["complete"], tried["steps_done"], len(tried["steps"])) == (False, 2, 2)
    assert tried["error"].startswith("Step 3, action 1") and "no vertex 77" in tried["error"]
    assert "Action 1 of step 1" in wrong["error"] and wrong["state"] is None
    assert nonsense["error"] and not nonsense["complete"]


async def test_the_prompts_name_the_tools(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        teach = (await host.client.get_prompt("teach_folding")).messages[0].content
        design = (await host.client.get_prompt("design_model", {"idea": "a fox"})).messages[0].content
    assert "get_instructions" in teach.text
    assert "a fox" in design.text and "try_program" in design.text


def test_the_program_format_is_published_as_a_json_schema() -> None:
    published = json.loads((ROOT / "docs" / "program.schema.json").read_text())
    assert published.pop("$schema") == "https://json-schema.org/draft/2020-12/schema"
    assert published == TypeAdapter(Program).json_schema()
