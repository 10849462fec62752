"""What hosts are told beside answers: updates of what they watch, log messages, completions, links; and finding runs again."""

import json
import sqlite3
from pathlib import Path
from typing import Any

import anyio
import pytest
from folding_server.mcp.results import readable
from folding_server.store.database import DATABASE_NAME
from hosts import Host, in_memory, text_of
from mcp import MCPError
from mcp.types import (
    CallToolResult,
    LoggingMessageNotification,
    PromptReference,
    ResourceLink,
    ResourceTemplateReference,
    ResourceUpdatedNotification,
    TextResourceContents,
)
from photographed import photos

pytestmark = pytest.mark.anyio


class Heard:
    """What a host of before 2026-07-28 is told unasked."""

    def __init__(self) -> None:
        self.updated: list[str] = []
        self.logged: list[tuple[str, str]] = []

    async def __call__(self, message: object) -> None:
        if isinstance(message, ResourceUpdatedNotification):
            self.updated.append(str(message.params.uri))
        if isinstance(message, LoggingMessageNotification):
            self.logged.append((message.params.level, str(message.params.data)))


def links_of(result: CallToolResult) -> dict[str, str]:
    """The links of an answer: title and address."""
    return {str(block.title): str(block.uri) for block in result.content if isinstance(block, ResourceLink)}


@pytest.mark.filterwarnings("ignore::mcp.shared.exceptions.MCPDeprecationWarning")
class TestUpdates:
    async def test_an_earlier_host_is_told_when_a_run_it_subscribed_to_changes(self, tmp_path: Path) -> None:
        heard = Heard()
        async with in_memory(tmp_path, mode="legacy", message_handler=heard) as host:
            run_id = (await host.call("open_run"))["run_id"]
            state, program = (f"folding://runs/{run_id}/{part}" for part in ("state", "program"))
            await host.client.session.subscribe_resource(state)
            await host.client.session.subscribe_resource(program)
            await host.call("fold", edge=[1, 3], direction=1)
            await host.call("get_run")
            await host.client.session.unsubscribe_resource(program)
            await host.call("rotate", angle=90)
            await anyio.wait_all_tasks_blocked()
        assert heard.updated == [state, program, state]

    async def test_a_host_of_today_listens_to_a_checkpoint(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            run_id = (await host.call("open_run"))["run_id"]
            address = f"folding://runs/{run_id}/checkpoints/2"
            async with host.client.listen(resource_subscriptions=[address]) as told:
                await host.call("fold", edge=[1, 3], direction=1)
                await host.call("save_checkpoint", frame=2)
                with anyio.fail_after(10):
                    event = await anext(aiter(told))
        assert str(event.uri) == address


@pytest.mark.filterwarnings("ignore::mcp.shared.exceptions.MCPDeprecationWarning")
class TestLogMessages:
    async def test_an_earlier_host_hears_what_it_set_the_level_for(self, tmp_path: Path) -> None:
        heard = Heard()
        async with in_memory(tmp_path, mode="legacy", message_handler=heard) as host:
            await host.call("open_run")
            await host.client.session.set_logging_level("warning")
            await host.call("rotate", angle=1)
            await host.refusal("fold", edge=[1, 77], direction=1)
            await host.client.session.set_logging_level("info")
            await host.call("rotate", angle=2)
            await anyio.wait_all_tasks_blocked()
        assert [level for level, _ in heard.logged] == ["warning", "info"]
        assert "77" in heard.logged[0][1]
        assert "rotate: Done: rotate(2.0)." in heard.logged[1][1]


class TestCompletions:
    @pytest.fixture
    def template(self) -> ResourceTemplateReference:
        return ResourceTemplateReference(uri="folding://runs/{run_id}/checkpoints/{frame}")

    async def complete(
        self, host: Host, reference: Any, name: str, value: str, /, **chosen: str
    ) -> list[str]:
        """The values offered for an argument."""
        answer = await host.client.complete(reference, {"name": name, "value": value}, chosen or None)
        return list(answer.completion.values)

    async def test_runs_are_completed_newest_first(
        self, tmp_path: Path, template: ResourceTemplateReference
    ) -> None:
        async with in_memory(tmp_path) as host:
            runs = [(await host.call("open_run"))["run_id"] for _ in range(3)]
            offered = await self.complete(host, template, "run_id", "")
            one = await self.complete(host, template, "run_id", runs[0])
        assert offered == runs[::-1]
        assert one == [runs[0]]

    async def test_frames_and_vertices_are_those_of_the_run_or_sequence_chosen(
        self, tmp_path: Path, template: ResourceTemplateReference
    ) -> None:
        photo = ResourceTemplateReference(uri="folding://sequences/{name}/frames/{frame}")
        vertex = ResourceTemplateReference(uri="folding://runs/{run_id}/vertices/{vertex}")
        async with in_memory(tmp_path, photos()) as host:
            run_id = (await host.call("open_run", sequence="sailboat"))["run_id"]
            await host.call("save_checkpoint", frame=1)
            await host.call("add_vertex", edge=[1, 2], position=0.5)
            assert await self.complete(host, template, "frame", "", run_id=run_id) == ["1"]
            assert await self.complete(host, photo, "frame", "", name="sailboat") == ["1", "2", "3", "4"]
            assert await self.complete(host, vertex, "vertex", "", run_id=run_id) == list("12345")
            assert await self.complete(host, vertex, "vertex", "", run_id="none such") == []
            judged = await self.complete(host, PromptReference(name="judge_step"), "frame", "")
            assert judged == ["2", "3", "4"]


class TestLinks:
    async def test_what_an_answer_links_to_can_be_read(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            run_id = (await host.call("open_run", sequence="sailboat"))["run_id"]
            await host.call("save_checkpoint", frame=1)
            await host.call("fold", edge=[1, 3], direction=1)
            saved = links_of(await host.answer("save_checkpoint", frame=2))
            links = links_of(await host.answer("get_run"))
            read = {title: await read_json(host, uri) for title, uri in links.items()}
            corner = await read_json(host, f"folding://runs/{run_id}/vertices/1")
        assert saved == {"Checkpoint of frame 2": f"folding://runs/{run_id}/checkpoints/2"}
        assert saved.items() <= links.items()
        assert read["Folded model (FOLD)"]["file_spec"]
        assert read["Crease pattern (FOLD)"]["edges_assignment"]
        assert len(read["Folding program"]["steps"]) == 1
        assert read["Checkpoint of frame 2"]["actions"] == [
            {"action": "fold", "edge": [1, 3], "direction": 1}
        ]
        assert (corner["vertex"], corner["position"], len(corner["faces"])) == (1, [0.0, 1.0], 2)

    async def test_hosts_whose_protocol_has_no_links_get_none(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            answer = await host.answer("get_run")
        assert links_of(answer)
        assert links_of(readable(answer, "", "2025-03-26")) == {}
        assert text_of(readable(answer, "", "2025-03-26")) == text_of(answer)


class TestRunList:
    async def test_runs_are_found_again_after_a_restart(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            free = (await host.call("open_run"))["run_id"]
            boat = (await host.call("open_run", sequence="sailboat"))["run_id"]
            await host.call("save_checkpoint", frame=1)
        async with in_memory(tmp_path, photos()) as host:
            listed = await host.call("list_runs")
            newest = await host.call("list_runs", count=1)
            resource = await read_json(host, "folding://runs")
        runs = {each["run_id"]: each for each in listed["runs"]}
        assert list(runs) == [boat, free]
        assert (runs[boat]["sequence"], runs[boat]["frames"], runs[boat]["saved"]) == ("sailboat", 4, 1)
        assert runs[boat]["changed"].endswith("+00:00")
        assert (runs[free]["sequence"], runs[free]["frames"]) == (None, 0)
        assert not listed["more"]
        assert newest == {"runs": listed["runs"][:1], "more": True}
        assert resource == listed

    async def test_a_run_whose_record_is_damaged_does_not_hide_the_others(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            whole = (await host.call("open_run"))["run_id"]
            damaged = (await host.call("open_run"))["run_id"]
        database = sqlite3.connect(tmp_path / DATABASE_NAME)
        with database:
            database.execute("UPDATE folding_events SET payload = '{' WHERE run_id = ?", (damaged,))
        database.close()
        async with in_memory(tmp_path) as host:
            listed = await host.call("list_runs")
            assert [each["run_id"] for each in listed["runs"]] == [damaged, whole]
            assert "is damaged" in await host.refusal("get_run", run_id=damaged)

    async def test_an_empty_list_says_how_to_start(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            assert "open_run starts one" in text_of(await host.answer("list_runs"))


class TestPrompts:
    @pytest.mark.parametrize(
        ("prompt", "arguments", "named"),
        [
            ("reconstruct", {"sequence": "nothing like it"}, ["nothing like it", "sailboat"]),
            ("judge_step", {"frame": "last"}, ["'last'", "from 2"]),
        ],
    )
    async def test_a_prompt_for_what_is_not_there_says_so(
        self, tmp_path: Path, prompt: str, arguments: dict[str, str], named: list[str]
    ) -> None:
        async with in_memory(tmp_path, photos()) as host:
            with pytest.raises(MCPError) as error:
                await host.client.get_prompt(prompt, arguments)
        assert error.value.code == -32602
        assert all(part in error.value.message for part in named)
        assert error.value.message.endswith(".")


async def read_json(host: Host, uri: str) -> Any:
    """A resource of JSON."""
    (content,) = (await host.client.read_resource(uri)).contents
    assert isinstance(content, TextResourceContents)
    return json.loads(content.text)
