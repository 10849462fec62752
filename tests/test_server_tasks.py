"""Long calls as tasks, for clients of the protocol that have the extension."""

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from datetime import timedelta
from pathlib import Path
from typing import Any, Literal

import anyio
import pytest
from folding_server.mcp.auth import read_tokens
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.http.address import Address, listen
from folding_server.mcp.http.names import AcceptedNames
from folding_server.mcp.http.serving import configuration, http_app
from folding_server.mcp.server import FoldingServer
from folding_server.mcp.tasks import MOST_TASKS, TTL_SECONDS, CallTask
from folding_server.workers.worker_pool import WorkerPool
from folding_server.workers.worker_process import WorkerProcess
from hosts import Host
from mcp import Client, MCPError
from mcp.client.extension import ClaimContext, ClientExtension, ResultClaim, advertise
from mcp.client.session import ClientSession
from mcp.client.streamable_http import streamable_http_client
from mcp.types import CallToolResult, EmptyResult, Request, RequestParams, Result, TextContent
from photographed import photos
from pydantic import ConfigDict
from test_http_tokens import ALICE as ADA
from test_http_tokens import BOB, bearing
from test_worker_processes import gone_within
from web_threads import serving_in_a_thread

pytestmark = pytest.mark.anyio
TASKS = "io.modelcontextprotocol/tasks"


class TaskParams(RequestParams):
    task_id: str
    input_responses: dict[str, Any] | None = None


class TaskRequest(Request[TaskParams, str]):
    name_param = "taskId"


class Told(Result):
    """What the server tells of a task."""

    model_config = ConfigDict(extra="allow")
    status: str
    result: CallToolResult | None = None


class Handle(Result):
    """The handle that a call is answered with."""

    result_type: Literal["task"]
    task_id: str
    status: str
    ttl_ms: int
    poll_interval_ms: int


async def ask(session: ClientSession, method: str, task: str) -> Told:
    request = TaskRequest(method=method, params=TaskParams(task_id=task))
    return await session.send_request(request, Told)


async def over(session: ClientSession, task: str) -> Told:
    """A task, when it is over."""
    while (told := await ask(session, "tasks/get", task)).status == "working":  # noqa: ASYNC110 - as clients do
        await anyio.sleep(0.05)
    return told


class TasksOfClient(ClientExtension):
    """A client's side of the extension: it asks until a task is over, or hands the handle out where ``waits`` is false."""

    identifier = TASKS

    def __init__(self, *, waits: bool = True) -> None:
        self.handles: list[Handle] = []
        self._waits = waits

    def claims(self) -> list[ResultClaim[Handle]]:
        return [ResultClaim(result_type="task", model=Handle, resolve=self._resolve)]

    async def _resolve(self, handle: Handle, context: ClaimContext) -> CallToolResult:
        self.handles.append(handle)
        if not self._waits:
            return CallToolResult(content=[TextContent(text=handle.task_id)])
        found = (await over(context.session, handle.task_id)).result
        assert found is not None
        return found


@pytest.fixture(scope="module")
def worker() -> Iterator[WorkerProcess]:
    process = WorkerProcess()
    yield process
    process.close()


@asynccontextmanager
async def served(
    data: Path,
    worker: WorkerProcess,
    extension: ClientExtension | None,
    prompt_seconds: float = 0,
    **client: Any,
) -> AsyncIterator[tuple[Host, FoldingServer]]:
    """A host, with a run whose first frame is saved, and its server, which makes every long call a task."""
    with AppContext(ServerSettings(data, sequences=(photos(),)), WorkerPool([worker])) as app:
        server = FoldingServer(app, prompt_seconds=prompt_seconds)
        async with Client(server, extensions=[extension] if extension else None, **client) as connected:
            host = Host(connected)
            await host.call("open_run", sequence="sailboat")
            await host.call("save_checkpoint", frame=1)
            yield host, server


async def test_a_long_call_is_a_task_whose_result_is_the_answer(
    tmp_path: Path, worker: WorkerProcess
) -> None:
    extension = TasksOfClient()
    async with served(tmp_path, worker, extension) as (host, _):
        as_task = await host.answer("compare_to_frame", frame=1)
        quick = await host.answer("get_run")
    (handle,) = extension.handles
    async with served(tmp_path / "plain", worker, None) as (host, _):
        assert (await host.answer("compare_to_frame", frame=1)).content == as_task.content
    assert not quick.is_error
    assert handle.status == "working"
    assert (handle.ttl_ms, handle.poll_interval_ms) == (600_000, 1000)


async def test_a_call_that_is_answered_soon_is_no_task(tmp_path: Path, worker: WorkerProcess) -> None:
    extension = TasksOfClient()
    async with served(tmp_path, worker, extension, prompt_seconds=60) as (host, _):
        assert (await host.call("compare_to_frame", frame=1))["verdict"]
        assert "Frame 9 is not in 1..4" in await host.refusal("compare_to_frame", frame=9)
    assert extension.handles == []


@pytest.mark.parametrize(("extension", "mode"), [(None, "auto"), (advertise(TASKS), "legacy")])
async def test_a_client_without_tasks_gets_the_answer_itself(
    tmp_path: Path, worker: WorkerProcess, extension: ClientExtension | None, mode: str
) -> None:
    async with served(tmp_path, worker, extension, mode=mode) as (host, _):
        assert (await host.call("compare_to_frame", frame=1))["verdict"]
        with pytest.raises(MCPError, match="Method not found" if mode == "legacy" else "did not declare"):
            await ask(host.client.session, "tasks/get", "any")


async def test_a_task_tells_what_it_does_and_stops_its_worker_when_it_is_cancelled(
    tmp_path: Path, worker: WorkerProcess
) -> None:
    worker.stop()
    async with served(tmp_path, worker, TasksOfClient(waits=False)) as (host, _):
        session = host.client.session
        (named,) = (await host.answer("compare_to_frame", frame=2)).content
        assert isinstance(named, TextContent)
        while "statusMessage" not in (  # noqa: ASYNC110 - as clients do
            told := (await ask(session, "tasks/get", named.text)).model_dump()
        ):
            await anyio.sleep(0.02)
        process = worker.process_id
        assert process is not None
        request = TaskRequest(method="tasks/cancel", params=TaskParams(task_id=named.text))
        await session.send_request(request, EmptyResult)
        assert (await ask(session, "tasks/get", named.text)).status == "cancelled"
        assert await gone_within(1, process)
        assert not (await host.answer("get_run")).is_error
    assert told["status"] == "working"
    assert told["statusMessage"] == "finding the sheet in the photos"


async def test_a_refusal_is_the_result_of_a_completed_task(tmp_path: Path, worker: WorkerProcess) -> None:
    async with served(tmp_path, worker, TasksOfClient()) as (host, _):
        assert "Frame 9 is not in 1..4" in await host.refusal("compare_to_frame", frame=9)


async def test_answers_that_no_task_asked_for_are_passed_over(tmp_path: Path, worker: WorkerProcess) -> None:
    async with served(tmp_path, worker, TasksOfClient(waits=False)) as (host, _):
        (named,) = (await host.answer("compare_to_frame", frame=1)).content
        assert isinstance(named, TextContent)
        params = TaskParams(task_id=named.text, input_responses={"name": {"action": "accept"}})
        await host.client.session.send_request(TaskRequest(method="tasks/update", params=params), EmptyResult)
        assert (await over(host.client.session, named.text)).status == "completed"


async def test_an_unknown_task_and_one_whose_time_is_over_are_not_there(
    tmp_path: Path, worker: WorkerProcess
) -> None:
    async with served(tmp_path, worker, TasksOfClient()) as (host, server):
        old = CallTask(None)
        old.created -= timedelta(seconds=TTL_SECONDS + 1)
        server._tasks._tasks[old.task_id] = old
        for task in ("none", old.task_id):
            for method in ("tasks/get", "tasks/update", "tasks/cancel"):
                with pytest.raises(
                    MCPError, match=f"There is no task '{task}'; tasks are kept for 10 minutes"
                ):
                    await ask(host.client.session, method, task)
        assert old.task_id not in server._tasks._tasks


async def test_where_many_tasks_are_kept_a_call_waits_for_its_answer(
    tmp_path: Path, worker: WorkerProcess
) -> None:
    extension = TasksOfClient()
    async with served(tmp_path, worker, extension) as (host, server):
        for _ in range(MOST_TASKS):
            task = CallTask(None)
            server._tasks._tasks[task.task_id] = task
        assert (await host.call("compare_to_frame", frame=1))["verdict"]
    assert extension.handles == []


async def test_a_task_is_its_owners_alone(tmp_path: Path, worker: WorkerProcess) -> None:
    (tmp_path / "tokens").write_text(f"ada {ADA}\nbob {BOB}\n")
    (tmp_path / "tokens").chmod(0o600)
    settings = ServerSettings(tmp_path, sequences=(photos(),), shared=True)
    with (
        AppContext(settings, WorkerPool([worker])) as app,
        listen(Address("127.0.0.1", 0)) as listener,
        serving_in_a_thread(
            configuration(
                http_app(
                    FoldingServer(app, read_tokens(tmp_path / "tokens"), prompt_seconds=0),
                    AcceptedNames.of("127.0.0.1"),
                )
            ),
            listener,
        ) as url,
    ):
        async with (
            bearing(ADA) as hers,
            bearing(BOB) as his,
            Client(
                streamable_http_client(url, http_client=hers), extensions=[TasksOfClient(waits=False)]
            ) as ada,
            Client(streamable_http_client(url, http_client=his), extensions=[TasksOfClient()]) as bob,
        ):
            run_id = (await Host(ada).call("open_run", sequence="sailboat"))["run_id"]
            (named,) = (await Host(ada).answer("compare_to_frame", frame=1, run_id=run_id)).content
            assert isinstance(named, TextContent)
            with pytest.raises(MCPError, match="There is no task"):
                await ask(bob.session, "tasks/get", named.text)
            assert (await over(ada.session, named.text)).status == "completed"
