"""Clients of the SDKs for Python and TypeScript: the same calls with each, over stdio and over HTTP."""

import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from folding_server.mcp.catalogue import RECORDS

from mcp_peers import versions
from mcp_peers.answers import CALLS, check_answers
from mcp_peers.checks import Check, Peer, Place, prefixed
from mcp_peers.environments import PeerBroken, node_environment, node_path, python_environment
from mcp_peers.our_server import environment, finished, http_url, stdio_command

PROGRAMS = Path(__file__).with_name("programs")
SECONDS = 120
"""How long a client may take for its calls, start of the server included."""


def told_by(command: Sequence[str | Path], wanted: Mapping[str, Any], place: Place, **env: str) -> Any:  # noqa: ANN401
    """The JSON that a program prints. PeerBroken if it fails."""
    done = finished([*command, json.dumps(wanted)], environment(place.scratch, **env), place.scratch, SECONDS)
    if done.returncode != 0:
        raise PeerBroken(f"{Path(command[-1]).name} ended with {done.returncode}: {done.stderr[-400:]}")
    return json.loads(done.stdout.splitlines()[-1])


def check_tools(names: Sequence[str]) -> Check:
    """Whether a client lists all tools."""
    missing = {record.name for record in RECORDS} ^ set(names)
    return Check("every tool is listed", not missing, f"missing or too many: {sorted(missing)}")


def _calls(
    command: Sequence[str | Path], wanted: Mapping[str, Any], place: Place, **env: str
) -> Iterator[Check]:
    """The checks of a client on either transport."""
    stdio = {**wanted, "calls": CALLS, "command": stdio_command(place.scratch / "data")}
    told = told_by(command, stdio, place, **env)
    yield from prefixed("stdio", [check_tools(told["tools"]), *check_answers(told["answers"])])
    with http_url(place.scratch / "http-data") as url:
        told = told_by(command, {**wanted, "calls": CALLS, "url": url}, place, **env)
    yield from prefixed("http", [check_tools(told["tools"]), *check_answers(told["answers"])])


def _python(place: Place, name: str, version: str) -> Iterator[Check]:
    """A client of a Python SDK."""
    python = python_environment(place.cache, name, f"mcp=={version}")
    yield from _calls([python, PROGRAMS / f"{name.replace('-', '_')}.py"], {}, place)


def _typescript(
    place: Place, name: str, packages: Mapping[str, str], modules: Sequence[str]
) -> Iterator[Check]:
    """A client of a TypeScript SDK."""
    commands = node_environment(place.cache, name, packages)
    program = place.cache / name / "peer.mjs"
    shutil.copy(PROGRAMS / "typescript.mjs", program)
    yield from _calls([commands / "node", program], {"modules": modules}, place, PATH=node_path(commands))


def _typescript_sdk(place: Place) -> Iterator[Check]:
    package = "@modelcontextprotocol/sdk"
    modules = [f"{package}/client/{part}.js" for part in ("index", "stdio", "streamableHttp")]
    yield from _typescript(place, "typescript-sdk", {package: versions.TYPESCRIPT_SDK}, modules)


def _typescript_client(place: Place) -> Iterator[Check]:
    package = "@modelcontextprotocol/client"
    modules = [package, f"{package}/stdio", package]
    yield from _typescript(place, "typescript-client", {package: versions.TYPESCRIPT_CLIENT}, modules)


PEERS = (
    Peer(
        "python-sdk-1",
        versions.PYTHON_SDK_1,
        "client of the Python SDK 1",
        lambda place: _python(place, "python-sdk-1", versions.PYTHON_SDK_1),
    ),
    Peer(
        "python-sdk-2",
        versions.PYTHON_SDK_2,
        "client of the Python SDK 2",
        lambda place: _python(place, "python-sdk-2", versions.PYTHON_SDK_2),
    ),
    Peer("typescript-sdk", versions.TYPESCRIPT_SDK, "client of the TypeScript SDK 1", _typescript_sdk),
    Peer(
        "typescript-client", versions.TYPESCRIPT_CLIENT, "client of the TypeScript SDK 2", _typescript_client
    ),
)
