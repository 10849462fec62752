"""Changing calls through the protocol: sent again with their request ids, refused, many at once."""

import gc
import tracemalloc
from functools import partial
from pathlib import Path
from typing import Any

import anyio
import pytest
from folding_schemas.request_id import REQUEST_ID
from hosts import Host, in_memory, text_of
from pictures import write_sequence_folder

pytestmark = pytest.mark.anyio

FIRST, SECOND = "00000000-0000-4000-8000-000000000001", "00000000-0000-4000-8000-000000000002"
OPENING = "00000000-0000-4000-8000-00000000000f"
MOST_BYTES_OF_A_CALL = 50
"""A lock or an entry under its run id would be more than 150 bytes."""
CHANGES: list[tuple[str, dict[str, Any]]] = [
    ("save_checkpoint", {"frame": 1}),
    ("add_vertex", {"edge": [1, 2], "position": 0.5}),
    ("fold", {"edge": [5, 4], "direction": 1}),
    ("unfold", {}),
    ("undo", {}),
    ("rotate", {"angle": 45.0}),
    ("flip", {"axis": "x"}),
    ("save_checkpoint", {"frame": 2, "notes": "turned over"}),
    ("restore_checkpoint", {"frame": 1}),
    ("commit_attempt", {"frame": 2, "attempt": 1}),
]
"""Every tool that changes a run, in an order in which all are allowed."""


async def requested(host: Host, request_id: object, tool: str, **arguments: Any) -> dict[str, Any]:
    """The answer to a call with a request id, as it travels, without what the protocol adds to every answer."""
    result = await host.client.call_tool(tool, arguments, meta={REQUEST_ID: request_id})
    return result.model_dump(mode="json", exclude={"meta"})


async def test_every_call_sent_again_is_answered_as_the_first_time_in_another_process_too(
    tmp_path: Path,
) -> None:
    photos = write_sequence_folder(tmp_path / "photos" / "crane", [1, 2, 3])
    ids = [f"00000000-0000-4000-8000-{number:012}" for number in range(len(CHANGES))]
    opening = partial(requested, request_id=OPENING, tool="open_run", sequence="crane")
    async with in_memory(tmp_path / "data", photos) as host:
        opened = await opening(host)
        run_id = opened["structured_content"]["run_id"]
        answers = []
        for request_id, (tool, arguments) in zip(ids, CHANGES, strict=True):
            answer = await requested(host, request_id, tool, run_id=run_id, **arguments)
            assert not answer["is_error"], answer
            assert await requested(host, request_id, tool, run_id=run_id, **arguments) == answer
            answers.append(answer)
        stands = await host.call("get_run", run_id=run_id)
    assert answers[2]["structured_content"]["moved_faces"]
    async with in_memory(tmp_path / "data", photos) as host:
        again = [
            await requested(host, request_id, tool, run_id=run_id, **arguments)
            for request_id, (tool, arguments) in zip(ids, CHANGES, strict=True)
        ]
        assert again == answers
        assert await opening(host) == opened
        assert await host.call("get_run", run_id=run_id) == stands


async def test_a_request_id_with_another_call_is_refused_and_changes_nothing(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        run_id = (await requested(host, FIRST, "open_run"))["structured_content"]["run_id"]
        await requested(host, SECOND, "rotate", run_id=run_id, angle=45)
        before = await host.call("get_run", run_id=run_id)
        for request_id, tool, arguments in [
            (SECOND, "rotate", {"angle": 46}),
            (SECOND, "fold", {"edge": [1, 99], "direction": 1}),
            (SECOND, "undo", {}),
            (FIRST, "undo", {}),
        ]:
            refused = await requested(host, request_id, tool, run_id=run_id, **arguments)
            assert refused["is_error"]
            (block,) = refused["content"]
            assert block["text"] == (
                f"The request id {request_id} was used by an earlier call with another tool or other "
                "arguments; send every call with a request id of its own."
            )
        assert await host.call("get_run", run_id=run_id) == before


@pytest.mark.parametrize("bad", ["1", 7, "x" * 500, {"id": FIRST}])
async def test_a_request_id_that_is_no_uuid_is_refused(tmp_path: Path, bad: object) -> None:
    async with in_memory(tmp_path) as host:
        await host.call("open_run")
        refused = await host.client.call_tool("rotate", {"angle": 45}, meta={REQUEST_ID: bad})
        assert refused.is_error
        assert text_of(refused).endswith("it must be a UUID made for this call; send one, or none at all.")
        assert len(text_of(refused)) < 250
        assert (await host.call("get_run"))["pending"] == []


async def test_calls_without_a_request_id_are_carried_out_each(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        await host.call("open_run")
        for _ in range(2):
            await host.call("rotate", angle=45)
        assert len((await host.call("get_run"))["pending"]) == 2


async def test_what_the_simulator_refuses_is_not_in_the_run(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        run = await host.call("open_run")
        assert "99" in await host.refusal("fold", edge=[1, 99], direction=1)
        assert await host.call("get_run") == run


async def test_calls_at_once_on_one_run_are_all_carried_out(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        run_id = (await host.call("open_run"))["run_id"]
        async with anyio.create_task_group() as tasks:
            for _ in range(20):
                tasks.start_soon(partial(host.call, "rotate", angle=18, run_id=run_id))
        assert len((await host.call("get_run", run_id=run_id))["pending"]) == 20


@pytest.mark.slow
async def test_calls_with_unknown_run_ids_leave_nothing_behind(tmp_path: Path) -> None:
    letters = str.maketrans("0123456789", "abcdefghij")

    async def call_often(host: Host, count: int) -> None:
        for number in range(count):
            run_id = "20260101-000000-" + f"{number:010}".translate(letters)
            assert "There is no run" in await host.refusal("rotate", angle=1, run_id=run_id)
            assert "There is no run" in await host.refusal("undo", run_id=f"unknown {number}")

    def bytes_in_use() -> int:
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    async with in_memory(tmp_path) as host:
        tracemalloc.start()
        try:
            await call_often(host, 20)
            before = bytes_in_use()
            await call_often(host, 450)  # sqlite3 keeps up to 200 cursors until it looks them over
            after = bytes_in_use()
        finally:
            tracemalloc.stop()
    assert (after - before) / 900 < MOST_BYTES_OF_A_CALL
