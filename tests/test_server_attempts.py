"""Attempts through the protocol: what ends them, what they cost, what can be chosen of them."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from folding_schemas.attempt_limits import TECHNICAL_RETURN
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.server import FoldingServer
from folding_server.mcp.tools.attempts import MOST_EARLIER_STATES
from hosts import Host, data_of, images_of, in_memory, server, text_of
from mcp import Client
from photographed import photos

pytestmark = pytest.mark.anyio


@asynccontextmanager
async def at_frame_1(data: Path, **opening: object) -> AsyncIterator[Host]:
    """A host whose run has frame 1 saved."""
    async with in_memory(data, photos()) as host:
        await host.call("open_run", sequence="sailboat", **opening)
        await host.call("save_checkpoint", frame=1)
        yield host


async def test_an_undo_to_the_checkpoint_costs_an_attempt_and_says_how_many_are_left(tmp_path: Path) -> None:
    async with at_frame_1(tmp_path) as host:
        for number in range(1, 6):
            acted = await host.call("rotate", angle=number)
            assert acted["summary"].endswith(f"Attempt {number} of 5 at frame 2.")
            undone = await host.call("undo")
            assert undone["summary"].endswith(f"Attempts left at frame 2: {5 - number} of 5.")
            assert (await host.call("get_run"))["attempts_left"] == 5 - number
        assert "The 5 attempts at frame 2 are used up" in await host.refusal("flip", axis="x")


async def test_a_client_s_technical_return_costs_nothing_and_a_model_has_no_argument_for_it(
    tmp_path: Path,
) -> None:
    async with at_frame_1(tmp_path) as host:
        for _ in range(6):
            await host.call("rotate", angle=10)
            result = await host.client.call_tool(
                "restore_checkpoint", {"frame": 1}, meta={TECHNICAL_RETURN: True}
            )
            assert data_of(result)["attempts_left"] == 5
        await host.call("rotate", angle=10)
        claimed = await host.call(
            "restore_checkpoint", frame=1, **{TECHNICAL_RETURN: True, "technical": True}
        )
        assert (claimed["attempts_used"], claimed["attempts_left"]) == (1, 4)
        tools = (await host.client.list_tools()).tools
        (offered,) = [each for each in tools if each.name == "restore_checkpoint"]
        assert offered.input_schema["properties"].keys() == {"frame", "run_id"}


async def test_a_technical_return_is_true_or_left_out(tmp_path: Path) -> None:
    async with at_frame_1(tmp_path) as host:
        result = await host.client.call_tool(
            "restore_checkpoint", {"frame": 1}, meta={TECHNICAL_RETURN: "cut off"}
        )
        assert result.is_error
        assert "'cut off' is not possible; send true, or leave it out" in text_of(result)


async def test_of_many_earlier_states_the_newest_are_drawn_and_it_is_said_how_many_are_not(
    tmp_path: Path,
) -> None:
    async with at_frame_1(tmp_path) as host:
        for angle in range(1, MOST_EARLIER_STATES + 4):
            await host.call("rotate", angle=angle)
        result = await host.answer("list_attempts", frame=2, images="none")
    listed = data_of(result)
    assert [each["state"] for each in listed["states"]] == [15, *range(3, 15)]
    assert listed["left_out"] == 2
    assert "2 older states of the attempts can be chosen too and are not drawn" in text_of(result)


async def test_every_state_is_listed_drawn_compared_and_can_be_committed(tmp_path: Path) -> None:
    async with at_frame_1(tmp_path) as host:
        await host.call("fold", edge=[1, 3], direction=1)
        await host.call("flip", axis="x")
        await host.call("undo")
        await host.call("rotate", angle=90)
        await host.call("restore_checkpoint", frame=1)
        result = await host.answer("list_attempts", frame=2)
        listed = data_of(result)
        assert [(each["attempt"], each["state"], each["last"]) for each in listed["states"]] == [
            (1, 3, True),
            (1, 1, False),
            (1, 2, False),
        ]
        assert len(images_of(result)) == 3
        compared = await host.answer("compare_to_frame", frame=2, attempt=1, state=1)
        assert text_of(compared).startswith("Attempt 1: ")
        assert "no state 4 of attempt 1" in await host.refusal(
            "compare_to_frame", frame=2, attempt=1, state=4
        )
        assert "give the number of the attempt too" in await host.refusal(
            "compare_to_frame", frame=2, state=1
        )
        await host.call("commit_attempt", frame=2, attempt=1, state=2)
        program = (await host.call("get_run"))["program"]
    assert [each["action"] for each in program["steps"][0]] == ["fold", "flip"]


async def test_a_commitment_says_which_frames_it_rewrites_and_drops(tmp_path: Path) -> None:
    async with at_frame_1(tmp_path) as host:
        await host.call("rotate", angle=10)
        await host.call("save_checkpoint", frame=2)
        await host.call("rotate", angle=20)
        await host.call("restore_checkpoint", frame=1)
        await host.call("rotate", angle=30)
        await host.call("save_checkpoint", frame=2)
        await host.call("rotate", angle=40)
        await host.call("save_checkpoint", frame=3)
        await host.call("rotate", angle=50)
        await host.call("save_checkpoint", frame=4)
        listed = await host.answer("list_attempts", frame=3)
        committed = await host.answer("commit_attempt", frame=3, attempt=1)
    assert "B1 grew from other frames; choosing it rewrites frames: 2." in text_of(listed)
    assert [each["on_path"] for each in data_of(listed)["states"]] == [False, True]
    assert (data_of(committed)["rewritten"], data_of(committed)["dropped"]) == ([2], [4])
    assert "rewrote frames: 2. Later frames" in text_of(committed)


async def test_a_run_keeps_the_number_of_attempts_that_it_was_opened_with(tmp_path: Path) -> None:
    async with at_frame_1(tmp_path, attempts=2) as host:
        run = await host.call("get_run")
        assert (run["budget"], run["attempts_left"]) == (2, 2)
        refused = await host.refusal("open_run", run_id=run["run_id"], attempts=3)
        assert "has 2 attempts a frame, not 3; leave attempts out" in refused
        assert "from 1 to 20" in await host.refusal("open_run", sequence="sailboat", attempts=21)
        assert "A free fold has no attempts" in await host.refusal("open_run", attempts=3)
        assert (await host.call("open_run", sequence="sailboat"))["budget"] == 5


async def test_the_server_s_option_is_the_number_where_a_run_says_none(tmp_path: Path) -> None:
    with AppContext(ServerSettings(tmp_path, sequences=(photos(),), attempts=3)) as app:
        async with Client(FoldingServer(app)) as connected:
            host = Host(connected)
            assert (await host.call("open_run", sequence="sailboat"))["budget"] == 3
            assert (await host.call("open_run", sequence="sailboat", attempts=4))["budget"] == 4


@pytest.mark.parametrize("bad", ["0", "21", "many"])
def test_a_number_of_attempts_that_cannot_be_is_one_line(tmp_path: Path, bad: str) -> None:
    ended = server("--data", tmp_path, "--attempts", bad)
    assert ended.returncode != 0
    assert "--attempts" in ended.stderr
    assert ended.stderr.count("\n") == 1
