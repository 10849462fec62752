"""Hosts for tests of the server: a real client in memory, and real server processes over stdio and HTTP."""

import json
import os
import re
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.server import FoldingServer
from mcp import Client, StdioServerParameters
from mcp.types import CallToolResult, ImageContent, TextContent


@dataclass(frozen=True)
class Host:
    """A host's side of a connection."""

    client: Client

    async def call(self, tool: str, **arguments: Any) -> dict[str, Any]:
        """The data of a call that must succeed."""
        result = await self.answer(tool, **arguments)
        assert not result.is_error, text_of(result)
        return data_of(result)

    async def refusal(self, tool: str, **arguments: Any) -> str:
        """The one sentence that answers a call that must be refused."""
        result = await self.answer(tool, **arguments)
        assert result.is_error, f"{tool} was not refused: {text_of(result)}"
        assert result.structured_content is None
        (block,) = result.content
        assert isinstance(block, TextContent)
        assert "\n" not in block.text
        assert "Traceback" not in block.text
        assert "Error executing" not in block.text
        return block.text

    async def answer(self, tool: str, **arguments: Any) -> CallToolResult:
        """Whatever a call is answered with."""
        result = await self.client.call_tool(tool, arguments)
        assert isinstance(result, CallToolResult)
        return result


def data_of(result: CallToolResult) -> dict[str, Any]:
    """The data of an answer: structured, or in the second text where pictures come with it."""
    if images_of(result):
        assert result.structured_content is None
        stated = result.content[1]
        assert isinstance(stated, TextContent)
        return dict(json.loads(stated.text))
    assert result.structured_content is not None
    return dict(result.structured_content)


def text_of(result: CallToolResult) -> str:
    """The text of an answer."""
    return "\n".join(block.text for block in result.content if isinstance(block, TextContent))


def images_of(result: CallToolResult) -> list[ImageContent]:
    """The images of an answer."""
    return [block for block in result.content if isinstance(block, ImageContent)]


@asynccontextmanager
async def in_memory(
    data: Path,
    *sequences: Path,
    allowed: Path | None = None,
    shared: bool = False,
    read_only: bool = False,
    for_evaluation: bool = False,
    **client: Any,
) -> AsyncIterator[Host]:
    """A host connected to a server in this process; ``client`` are options of the SDK's client."""
    folders = (allowed,) if allowed else ()
    settings = ServerSettings(
        data,
        sequences=sequences,
        allowed=folders,
        shared=shared,
        read_only=read_only,
        for_evaluation=for_evaluation,
    )
    with AppContext(settings) as app:
        async with Client(FoldingServer(app), **client) as connected:
            yield Host(connected)


def stdio(data: Path, *sequences: Path) -> StdioServerParameters:
    """The process that a desktop host would start."""
    folders = [part for folder in sequences for part in ("--sequences", str(folder))]
    return StdioServerParameters(
        command=sys.executable,
        args=["-m", "folding_server", "--data", str(data), *folders],
        env={"PATH": os.environ["PATH"]},
    )


@contextmanager
def http_server(data: Path, *options: str) -> Iterator[str]:
    """A server process that listens on a free local port; yields its URL."""
    with http_process(data, *options) as process:
        yield process.url


@dataclass(frozen=True)
class HttpProcess:
    """A server process and where it listens."""

    process: subprocess.Popen[str]
    url: str

    @property
    def place(self) -> tuple[str, int]:
        """Host and port for a plain socket."""
        host, port = self.url.removeprefix("http://").removesuffix("/mcp").split(":")
        return host, int(port)

    def end(self) -> str:
        """Have it end as service managers do; what it wrote to stderr since it listens. TimeoutExpired after 20 s."""
        self.process.terminate()
        return self.process.communicate(timeout=20)[1]


@contextmanager
def http_process(data: Path, *options: str) -> Iterator[HttpProcess]:
    """A server process that listens on a free local port."""
    command = [sys.executable, "-m", "folding_server", "--http", "127.0.0.1:0", "--data", str(data), *options]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            line = process.stderr.readline()
            found = re.search(r"http://\S+", line)
            assert found, line
            yield HttpProcess(process, found.group())
        finally:
            if process.returncode is None:
                process.terminate()
                process.communicate(timeout=20)


def server(*arguments: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """A finished ``foldingagent-server`` command."""
    command = [sys.executable, "-m", "folding_server", *map(str, arguments)]
    return subprocess.run(
        command, capture_output=True, text=True, timeout=120, check=False, cwd=cwd, stdin=subprocess.DEVNULL
    )


def json_of(finished: subprocess.CompletedProcess[str]) -> Any:
    """The one JSON document that a successful command printed."""
    assert finished.returncode == 0, finished.stderr
    return json.loads(finished.stdout)
