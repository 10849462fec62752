"""A model that says what it was told to: a written script, or the replies of a recorded run.

A script is JSON or JSON lines: a list of entries ``{"role", "text", "calls", "finish_reason", "thinking"}``,
all optional; ``calls`` is a list of ``{"tool", "arguments"}`` and ``role`` is ``agent`` unless it says
otherwise. A recorded run is its folder or its ``events.jsonl``.
"""

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError

from folding_client.interrupts import ScriptEnded, UsageError
from folding_client.messages import Message, Reply, ToolCall, ToolSpec, Usage
from folding_client.record.event_log import Event, read_events

SCRIPTED = "scripted:"
"""What ids of models begin with that say what a file tells them to."""


class ScriptedCall(BaseModel):
    """A tool call of a script; ``arguments`` as text is sent as it stands, valid JSON or not."""

    model_config = ConfigDict(extra="forbid")

    tool: str
    arguments: dict[str, Any] | str = {}


class ScriptedReply(BaseModel):
    """One reply of a script."""

    model_config = ConfigDict(extra="forbid")

    role: str = "agent"
    text: str = ""
    thinking: str = ""
    calls: list[ScriptedCall] = []
    finish_reason: str = ""

    def reply(self, number: int) -> Reply:
        """The entry as a model's reply; ``number`` makes its call ids unique."""
        calls = tuple(
            ToolCall(f"call_{number}_{index}", call.tool, _text(call.arguments))
            for index, call in enumerate(self.calls, start=1)
        )
        return Reply(
            self.text, calls, self.thinking, self.finish_reason or ("tool_calls" if calls else "stop")
        )


@dataclass
class ScriptedModel:
    """Replies with one role's entries in order. ScriptEnded after the last.

    ``said`` tells, at the first query, how many of them were said before.
    """

    name: str
    replies: Sequence[Reply]
    said: Callable[[], int] = int
    position: int | None = None

    async def query(
        self,
        messages: Sequence[Message],  # noqa: ARG002
        tools: Sequence[ToolSpec],  # noqa: ARG002
        *,
        json_mode: bool = False,  # noqa: ARG002
    ) -> Reply:
        """The next reply."""
        if self.position is None:
            self.position = self.said()
        if self.position >= len(self.replies):
            message = (
                f"The script {self.name} has no reply after its {len(self.replies)}; extend it, then resume."
            )
            raise ScriptEnded(message)
        self.position += 1
        return self.replies[self.position - 1]


def load_script(path: Path, role: str) -> list[Reply]:
    """The replies of one role in a script or a recorded run. UsageError if it cannot be read."""
    try:
        path = path.expanduser()
    except RuntimeError as error:
        message = f"Cannot read the script {path}: it begins with a user who has no folder here."
        raise UsageError(message) from error
    if path.is_dir() or path.name == "events.jsonl":
        return recorded_replies(read_events(path / "events.jsonl" if path.is_dir() else path), role)
    try:
        text = path.read_text(encoding="utf-8")
        entries = TypeAdapter(list[ScriptedReply]).validate_python(_entries(text))
    except OSError as error:
        message = (
            f"Cannot read the script {path}: {error.strerror}. Name a JSON file, or the folder of a "
            "recorded run."
        )
        raise UsageError(message) from error
    except ValidationError as error:
        first = error.errors()[0]
        message = f"{path} is not a script: {'.'.join(map(str, first['loc']))}: {first['msg']}."
        raise UsageError(message) from error
    except ValueError as error:
        message = f"{path} is not a script: it is neither JSON nor JSON lines ({error})."
        raise UsageError(message) from error
    return [entry.reply(number) for number, entry in enumerate(entries, start=1) if entry.role == role]


def recorded_replies(events: Iterable[Event], role: str) -> list[Reply]:
    """The replies of one role in a recorded run, in order."""
    return [
        Reply(
            event["text"],
            tuple(ToolCall(**call) for call in event["calls"]),
            event["thinking"],
            event["finish_reason"],
            Usage(**event["usage"]),
            event["native"],
        )
        for event in events
        if event["kind"] == "reply" and event["role"] == role
    ]


def _entries(text: str) -> list[Any]:
    if text.lstrip().startswith("["):
        entries = json.loads(text)
        return entries if isinstance(entries, list) else [entries]
    return [json.loads(line) for line in text.splitlines() if line.strip()]


def _text(arguments: dict[str, Any] | str) -> str:
    return arguments if isinstance(arguments, str) else json.dumps(arguments)
