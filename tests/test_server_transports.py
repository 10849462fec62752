"""The server as a process of its own: over stdio, over HTTP, killed and started again."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import httpx2
import pytest
from hosts import Host, http_server, stdio
from mcp import Client, MCPError
from photographed import photos

pytestmark = pytest.mark.anyio


async def test_a_desktop_host_folds_over_stdio_without_naming_its_run(tmp_path: Path) -> None:
    async with Client(stdio(tmp_path, photos())) as client:
        host = Host(client)
        await host.call("open_run", sequence="sailboat")
        await host.call("save_checkpoint", frame=1)
        folded = await host.call("fold", edge=[1, 3], direction=1)
        await host.answer("view_frame", frame=2)
    assert folded["attempt"] == 1


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["auto", "legacy"])
async def test_hosts_of_either_era_see_the_server_and_its_tools(tmp_path: Path, mode: str) -> None:
    async with Client(stdio(tmp_path), mode=mode) as client:
        tools = (await client.list_tools()).tools
        assert client.server_info is not None
        assert client.server_info.name == "foldingagent"
        assert "open_run" in (client.instructions or "")
    assert len(tools) == 28


@pytest.mark.slow
async def test_two_hosts_on_one_http_server_have_a_run_each(tmp_path: Path) -> None:
    with http_server(tmp_path, "--sequences", str(photos())) as url:
        async with Client(url) as first, Client(url, mode="legacy") as second:
            hosts = [Host(first), Host(second)]
            runs = [(await host.call("open_run", sequence="sailboat"))["run_id"] for host in hosts]
            for host, run in zip(hosts, runs, strict=True):
                await host.call("save_checkpoint", frame=1, run_id=run)
            await hosts[0].call("fold", edge=[1, 3], direction=1, run_id=runs[0])
            await hosts[1].call("flip", axis="x", run_id=runs[1])
            pending = [
                (await host.call("get_run", run_id=run))["pending"]
                for host, run in zip(hosts, runs, strict=True)
            ]
            refusal = await hosts[0].refusal("get_run")
            await hosts[1].answer("critic_grid", frame=2, run_id=runs[1])
    assert [actions[0]["action"] for actions in pending] == ["fold", "flip"]
    assert "run_id" in refusal


async def test_a_page_under_a_foreign_name_cannot_reach_the_http_server(tmp_path: Path) -> None:
    body = {"jsonrpc": "2.0", "id": 1, "method": "ping"}
    with http_server(tmp_path, "--known-as", "paper.example") as url:
        async with httpx2.AsyncClient() as web:
            foreign = await web.post(url, json=body, headers={"Host": "evil.example"})
            known = await web.post(url, json=body, headers={"Host": "paper.example:8000"})
            page = await web.post(url, json=body, headers={"Origin": "https://evil.example"})
            healthy = await web.get(url.replace("/mcp", "/health"))
    assert foreign.status_code == 421
    assert known.status_code not in (421, 403)
    assert page.status_code == 403
    assert healthy.json() == {"status": "ok"}


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="finds the server's process in /proc")
async def test_a_killed_server_has_lost_nothing_that_it_answered(tmp_path: Path) -> None:
    earlier = servers()
    async with Client(stdio(tmp_path, photos())) as client:
        host = Host(client)
        run_id = (await host.call("open_run", sequence="sailboat"))["run_id"]
        await host.call("save_checkpoint", frame=1)
        await host.call("add_vertex", edge=[1, 2], position=0.5)
        answered = await host.call("fold", edge=[5, 4], direction=1)
        (server,) = servers() - earlier
        os.kill(server, signal.SIGKILL)
        with pytest.raises(MCPError):
            await host.call("get_run")
    async with Client(stdio(tmp_path, photos())) as client:
        host = Host(client)
        reopened = await host.call("open_run", run_id=run_id)
        assert (await host.call("get_current_state"))["state"] == answered["state"]
        assert [action["action"] for action in reopened["pending"]] == ["add_vertex", "fold"]
        assert (await host.call("undo"))["state"] != answered["state"]


def servers() -> set[int]:
    """The children of this process that run a folding server."""
    found = set()
    for process in Path("/proc").iterdir():
        if not process.name.isdigit():
            continue
        try:
            parent = int((process / "stat").read_text().rsplit(")", 1)[1].split()[1])
            command = (process / "cmdline").read_text().split("\0")
        except (OSError, IndexError):
            continue
        if parent == os.getpid() and "folding_server" in command:
            found.add(int(process.name))
    return found


@pytest.mark.slow
def test_piped_input_is_answered_to_the_last_request_in_either_era(tmp_path: Path) -> None:
    opening = {
        "protocolVersion": "2025-11-25",
        "capabilities": {},
        "clientInfo": {"name": "pipe", "version": "1"},
    }
    calls = [("tools/call", {"name": "open_run", "arguments": {}}), ("tools/list", {})]
    legacy = [("initialize", opening), ("notifications/initialized", None), *calls]
    envelope = {
        "_meta": {
            "io.modelcontextprotocol/protocolVersion": "2026-07-28",
            "io.modelcontextprotocol/clientInfo": opening["clientInfo"],
            "io.modelcontextprotocol/clientCapabilities": {},
        }
    }
    modern = [(method, {**params, **envelope}) for method, params in calls]
    for messages in (legacy, modern):
        answers = piped(tmp_path, messages)
        asked = {number for number, (_, params) in enumerate(messages) if params is not None}
        assert {answer["id"] for answer in answers} == asked
        assert all("result" in answer for answer in answers), answers


def piped(data: Path, messages: list[tuple[str, dict[str, Any] | None]]) -> list[dict[str, Any]]:
    """What a server writes that reads these requests, and notifications, and then the end of its input."""
    lines = []
    for number, (method, params) in enumerate(messages):
        asks = {} if params is None else {"id": number, "params": params}
        lines.append(json.dumps({"jsonrpc": "2.0", "method": method, **asks}))
    command = [sys.executable, "-m", "folding_server", "--data", str(data)]
    finished = subprocess.run(
        command, input="\n".join(lines), capture_output=True, text=True, timeout=120, check=True
    )
    return [json.loads(line) for line in finished.stdout.splitlines()]
