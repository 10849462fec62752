"""A server process over HTTP for ``benchmarks/fuzz.py``, with two owners of tokens: one whose run must stay, and one who fuzzes."""

import json
import random
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from fuzz_verdicts import http_fault
from hostile_messages import Subject, hostile_message
from hostile_requests import HttpRequest, hostile_request
from kept_connections import META, post

LONGEST_SECONDS = 60.0
"""How long an answer may take; the slowest tools take a few seconds."""
LEGACY_SHARE = 0.25
"""How many calls speak a protocol with sessions."""
OWNERS = {"alice": "alice-0123456789abcdef", "mallory": "mallory-0123456789abcdef"}
"""Tokens by owner: the one whose run must stay as it is, and the one who sends the hostile calls."""
NO_RUNS = ["20260101-000000-aaaaaaaaaa", "../../etc/passwd", "20260101-000000-AAAAAAAAAA", "x" * 10_000]


class HttpTarget:
    """A server process, as the two owners reach it."""

    def __init__(self, process: "subprocess.Popen[str]", url: str, places: tuple[str, ...]) -> None:
        self.process = process
        self._url, self._places, self._host = url, places, urlsplit(url).netloc
        self._kept = self.ask("alice", "open_run")["run_id"]
        self.ask("alice", "rotate", angle=45, run_id=self._kept)
        self._as_it_was = self.kept_run()
        self._own = [self.ask("mallory", "open_run", **free)["run_id"] for free in ({}, {"sequence": "cat"})]
        listed = {
            tool["name"]: tool["inputSchema"] for tool in self._request("mallory", "tools/list")["tools"]
        }
        forms = [
            each["uriTemplate"]
            for each in self._request("mallory", "resources/templates/list")["resourceTemplates"]
        ]
        forms += [each["uri"] for each in self._request("mallory", "resources/list")["resources"]]
        self._subject = Subject(listed, tuple(forms), [*self._own * 3, self._kept, *NO_RUNS])

    def call(self, rng: random.Random, number: int) -> tuple[str, str, str | None]:
        """Send one hostile call: its kind, what came back in a word, and what is wrong with that, if anything."""
        legacy = rng.random() < LEGACY_SHARE
        message = hostile_message(rng, self._subject, number, not legacy)
        request = hostile_request(rng, self._host, message, OWNERS["mallory"], legacy)
        data = self._exchange(request)
        if request.cut:
            return request.kind, "cut", http_fault(data, self._places) if data else None
        fault = http_fault(data, self._places)
        return (
            request.kind,
            data[9:12].decode(errors="replace"),
            fault and f"{fault} <- {request.data[:600]!r}",
        )

    def kept_run(self) -> Any:  # noqa: ANN401 - JSON
        """Where the other owner's run stands."""
        return self.ask("alice", "get_current_state", run_id=self._kept), self.ask(
            "alice", "get_run", run_id=self._kept
        )

    def faults_at_the_end(self) -> list[str]:
        """What is not as it was, and what does not work any more."""
        if self.process.poll() is not None:
            return [f"the process has ended with {self.process.returncode}"]
        faults = [] if self.kept_run() == self._as_it_was else ["the other owner's run has changed"]
        run_id = self.ask("mallory", "open_run")["run_id"]
        folded = self.ask("mallory", "fold", edge=[1, 3], direction=1, run_id=run_id)
        return faults if folded["new_faces"] == [2] else [*faults, "a fold is not what it was"]

    def ask(self, owner: str, tool: str, **arguments: Any) -> dict[str, Any]:
        """The data of a call that must succeed."""
        result = self._request(owner, "tools/call", name=tool, arguments=arguments)
        assert not result["isError"], result
        return dict(result["structuredContent"])

    def _request(self, owner: str, method: str, **parameters: Any) -> dict[str, Any]:
        message = {"jsonrpc": "2.0", "id": 1, "method": method, "params": {**parameters, "_meta": META}}
        headers = {"Mcp-Method": method, "Authorization": f"Bearer {OWNERS[owner]}", "Connection": "close"}
        if "name" in parameters:
            headers["Mcp-Name"] = parameters["name"]
        data = self._exchange(HttpRequest("", post(self._url, json.dumps(message).encode(), headers)))
        return dict(json.loads(data.partition(b"\r\n\r\n")[2])["result"])

    def _exchange(self, request: HttpRequest) -> bytes:
        """All that is answered on a connection of its own. After a cut request only what has come already."""
        place = urlsplit(self._url)
        received = b""
        with socket.create_connection((place.hostname, place.port), timeout=LONGEST_SECONDS) as connection:
            try:
                connection.sendall(request.data)
                if request.cut:
                    connection.shutdown(socket.SHUT_WR)
                while part := connection.recv(1 << 16):
                    received += part
                    if b"text/event-stream" in received and b"subscriptions/acknowledged" in received:
                        break
            except OSError as error:  # reset, closed by now, or too late
                return received or (b"" if request.cut else f"{type(error).__name__}".encode())
        return received


@contextmanager
def http_target(folder: Path, sequences: Path, log: Path, places: tuple[str, ...]) -> Iterator[HttpTarget]:
    """A server process with tokens; what it has to say goes to a file."""
    tokens = folder / "tokens"
    tokens.write_text("".join(f"{owner} {token}\n" for owner, token in OWNERS.items()))
    tokens.chmod(0o600)
    options = ["--data", str(folder / "http"), "--sequences", str(sequences), "--token-file", str(tokens)]
    command = [sys.executable, "-m", "folding_server", "--http", "127.0.0.1:0", *options]
    with log.open("w") as stderr, subprocess.Popen(command, stderr=stderr, text=True) as process:
        try:
            yield HttpTarget(process, _served_at(process, log), places)
        finally:
            process.terminate()


def _served_at(process: "subprocess.Popen[str]", log: Path) -> str:
    while process.poll() is None:
        if found := re.search(r"http://\S+\n", log.read_text()):
            return found.group().strip()
    raise SystemExit(f"fuzz: the server did not start: {log.read_text()}")
