"""The Inspector's command line, as a host of either era of the protocol, over stdio and over HTTP."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from folding_server.mcp.tools.apps import PAGE_URI

from mcp_peers import versions
from mcp_peers.answers import data_of, is_picture, said
from mcp_peers.checks import Check, Peer, Place, prefixed
from mcp_peers.clients import check_tools
from mcp_peers.environments import PeerBroken, node_environment, node_path
from mcp_peers.our_server import SEQUENCE, environment, finished, http_url, stdio_command

SECONDS = 120
"""How long one command may take, start of Node.js and of the server included."""
IS_ERROR = 5
"""How the Inspector ends where a tool's answer is an error."""
ERAS: Mapping[str, Sequence[str]] = {"legacy": (), "modern": ("--protocol-era", "modern")}


@dataclass(frozen=True)
class Inspector:
    """The Inspector with a target, which is a command or an address."""

    commands: Path
    target: Sequence[str]
    options: Sequence[str]
    place: Place

    def ask(self, method: str, *words: str) -> tuple[int, Any]:
        """How one command ended, and the result or the app that it printed, None if it printed none."""
        env = environment(self.place.scratch, PATH=node_path(self.commands))
        command: list[str | Path] = [
            self.commands / "mcp-inspector",
            "--cli",
            *self.target,
            "--method",
            method,
            *words,
        ]
        done = finished([*command, *self.options, "--format", "json", "-q"], env, self.place.scratch, SECONDS)
        try:
            told = json.loads(done.stdout)
            return done.returncode, told.get("result", told.get("appInfo"))
        except ValueError:
            return done.returncode, None

    def call(self, tool: str, **arguments: Any) -> tuple[int, Mapping[str, Any]]:
        """How a call ended, and its answer."""
        code, result = self.ask("tools/call", "--tool-name", tool, "--tool-args-json", json.dumps(arguments))
        content = (result or {}).get("content", ())
        answer = {
            "texts": [block["text"] for block in content if block["type"] == "text"],
            "images": [
                {"mime": block["mimeType"], "data": block["data"]}
                for block in content
                if block["type"] == "image"
            ],
            "structured": (result or {}).get("structuredContent"),
        }
        return code, answer


def _inspector(place: Place) -> Iterator[Check]:
    """Every command of the Inspector's, in both eras and on both transports."""
    package = "@modelcontextprotocol/inspector"
    commands = node_environment(place.cache, "inspector", {package: versions.INSPECTOR})
    for era, options in ERAS.items():
        target = stdio_command(place.scratch / "data")
        yield from prefixed(f"{era}, stdio", _commands(Inspector(commands, target, options, place)))
        with http_url(place.scratch / "http-data") as url:
            yield from prefixed(f"{era}, http", _commands(Inspector(commands, [url], options, place)))


def _commands(inspector: Inspector) -> Iterator[Check]:
    """The commands, each in a process of its own; the run is named each time."""
    code, listed = inspector.ask("tools/list", "--strict")
    yield Check("tools/list --strict", code == 0 and bool(listed), f"ended with {code}")
    yield check_tools([tool["name"] for tool in (listed or {}).get("tools", ())])
    code, opened = inspector.call("open_run", sequence=SEQUENCE)
    run = data_of(opened).get("run_id")
    yield Check(
        "tools/call: text and JSON", code == 0 and bool(run) and "." in said(opened), f"{code}: {opened}"
    )
    if run is None:
        raise PeerBroken(f"open_run ended with {code}")
    code, seen = inspector.call("view_frame", frame=1, run_id=run)
    pictured = bool(seen["images"]) and all(map(is_picture, seen["images"]))
    yield Check("tools/call: picture", code == 0 and pictured, f"{code}: {seen['texts']}")
    code, refused = inspector.call("fold", edge=[1, 99], direction=1, run_id=run)
    yield Check("tools/call: refusal", code == IS_ERROR and run in said(refused) + run, f"{code}: {refused}")
    code, program = inspector.ask("resources/read", "--uri", f"folding://runs/{run}/program")
    yield Check("resources/read: text", code == 0 and "steps" in program["contents"][0]["text"], f"{code}")
    code, diagram = inspector.ask("resources/read", "--uri", f"folding://runs/{run}/diagram.png")
    found = diagram["contents"][0] if code == 0 else {"blob": "", "mimeType": ""}
    yield Check(
        "resources/read: picture", is_picture({"mime": found["mimeType"], "data": found["blob"]}), f"{code}"
    )
    code, prompt = inspector.ask(
        "prompts/get", "--prompt-name", "reconstruct", "--prompt-args", f"sequence={SEQUENCE}"
    )
    yield Check("prompts/get", code == 0 and SEQUENCE in json.dumps(prompt), f"{code}")
    code, app = inspector.ask("tools/call", "--tool-name", "show_model", "--app-info")
    has_page = code == 0 and app is not None and app.get("resourceUri") == PAGE_URI
    yield Check("--app-info of show_model", has_page, f"{code}: {app}")


PEERS = (Peer("inspector", versions.INSPECTOR, "the MCP Inspector's command line, in both eras", _inspector),)
