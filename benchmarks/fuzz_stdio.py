"""A server process over stdio for ``benchmarks/fuzz.py``: hostile lines, each followed by a question that must be answered."""

import json
import random
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fuzz_http import NO_RUNS
from fuzz_verdicts import line_fault
from hostile_messages import Subject, hostile_message
from kept_connections import META

SESSIONS = "2025-11-25"
"""A version of the protocol whose connections begin with a handshake."""


class StdioTarget:
    """A server process, in the protocol of 2026-07-28 or in an earlier one."""

    def __init__(self, process: "subprocess.Popen[bytes]", places: tuple[str, ...], modern: bool) -> None:
        self.process, self._places, self._modern, self._asked = process, places, modern, 0
        if not modern:
            client = {"name": "fuzz", "version": "1"}
            self._ask("initialize", protocolVersion=SESSIONS, capabilities={}, clientInfo=client)
            self._write(b'{"jsonrpc":"2.0","method":"notifications/initialized"}')
        tools = self._ask("tools/list")["result"]["tools"]
        templates = self._ask("resources/templates/list")["result"]["resourceTemplates"]
        self._run_id = self.tool("open_run")["run_id"]
        self._subject = Subject(
            {tool["name"]: tool["inputSchema"] for tool in tools},
            tuple(each["uriTemplate"] for each in templates),
            [self._run_id] * 3 + NO_RUNS,
        )

    def call(self, rng: random.Random, number: int) -> tuple[str, str, str | None]:
        """Send one hostile line: its kind, what came back in a word, and what is wrong with that, if anything."""
        message = hostile_message(rng, self._subject, number, self._modern)
        self._write(message.text.replace(b"\n", b" "))
        lines: list[str] = []
        self._ask("prompts/list", lines)
        faults = [fault for line in lines if (fault := line_fault(line, self._places))]
        fault = f"{faults[0]} <- {message.text[:600]!r}" if faults else None
        return message.kind, "answered" if lines else "silent", fault

    def faults_at_the_end(self) -> list[str]:
        """What does not work any more."""
        run_id = self.tool("open_run")["run_id"]
        folded = self.tool("fold", edge=[1, 3], direction=1, run_id=run_id)
        return [] if folded["new_faces"] == [2] else ["a fold is not what it was"]

    def tool(self, name: str, **arguments: Any) -> dict[str, Any]:
        """The data of a call that must succeed."""
        answer = self._ask("tools/call", name=name, arguments=arguments)
        return dict(answer["result"]["structuredContent"])

    def _ask(self, method: str, others: list[str] | None = None, **parameters: Any) -> dict[str, Any]:
        """The answer to a request of our own; what else comes meanwhile is added to ``others``."""
        self._asked += 1
        number = f"own {self._asked}"
        meta = {"_meta": META} if self._modern else {}
        message = {"jsonrpc": "2.0", "id": number, "method": method, "params": {**parameters, **meta}}
        self._write(json.dumps(message).encode())
        assert self.process.stdout
        for line in self.process.stdout:
            answer = json.loads(line)
            if isinstance(answer, dict) and answer.get("id") == number:
                return answer
            if others is not None:
                others.append(line.decode())
        raise SystemExit(
            f"fuzz: the process has ended with {self.process.wait()} before it answered {method}"
        )

    def _write(self, line: bytes) -> None:
        assert self.process.stdin
        self.process.stdin.write(line + b"\n")
        self.process.stdin.flush()


@contextmanager
def stdio_target(
    folder: Path, sequences: Path, log: Path, places: tuple[str, ...], modern: bool
) -> Iterator[StdioTarget]:
    """A server process over stdio; what it has to say goes to a file."""
    options = ["--data", str(folder / f"stdio-{modern}"), "--sequences", str(sequences)]
    command = [sys.executable, "-m", "folding_server", *options]
    with (
        log.open("w") as stderr,
        subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=stderr) as process,
    ):
        try:
            yield StdioTarget(process, places, modern)
        finally:
            process.kill()
