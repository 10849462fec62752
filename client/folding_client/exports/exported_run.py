"""A recorded run as its turns: what each role was asked and said, and which tools were called meanwhile."""

import base64
import json
import mimetypes
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from folding_client.batch.batch_entry import BatchEntry, described_entry
from folding_client.interrupts import UsageError
from folding_client.record.event_log import Event, read_events
from folding_client.record.folder import RunFolder


@dataclass(frozen=True)
class ModelTurn:
    """A query of a role and its reply; ``reply`` is the event ``reply`` or ``unreadable``, None if the run was cut short."""

    role: str
    request: Event
    reply: Event | None


@dataclass(frozen=True)
class ToolTurn:
    """A call of a tool of the server's and its result, None if the run was cut short."""

    call: Event
    result: Event | None

    @property
    def text(self) -> str:
        """What the tool answered, as text."""
        if self.result is None:
            return ""
        return self.result["text"] or json.dumps(self.result["structured"], separators=(",", ":"))


Turn = ModelTurn | ToolTurn


@dataclass(frozen=True)
class ExportedRun:
    """A run's folder, what ``run.json`` says, the events, and the turns in order of their beginning; ``first`` and ``last``
    are times.
    """

    folder: Path
    about: Mapping[str, Any]
    events: Sequence[Event] = ()
    turns: list[Turn] = field(default_factory=list)
    first: datetime | None = None
    last: datetime | None = None

    @property
    def entry(self) -> BatchEntry:
        """How the run fared."""
        outcome = self.about["outcome"]
        return described_entry(
            self.about["sequence"]["name"], outcome["status"], outcome["reason"], self.about, self.folder
        )

    def model_of(self, role: str) -> str:
        """The id of the model that played a role."""
        return str(self.about["models"].get(role, role))


def exported_runs(places: Iterable[Path]) -> Iterator[ExportedRun]:
    """The runs in folders, at any depth, in order of path. UsageError if a place holds none, or a record is damaged."""
    for place in places:
        found = False
        for folder, inner, files in os.walk(place):
            inner.sort()
            if "run.json" in files:
                inner.clear()
                found = True
                yield exported_run(Path(folder))
        if not found:
            message = f"{place} holds no recorded run; name run folders, or a folder of them."
            raise UsageError(message)


def exported_run(folder: Path) -> ExportedRun:
    """The run in a folder. UsageError if its record is damaged."""
    about = RunFolder(folder).description("models", "outcome")
    file = folder / "events.jsonl"
    events = list(read_events(file)) if file.exists() else []
    times = [when(event) for event in events]
    return ExportedRun(
        folder, about, events, _turns(events), min(times, default=None), max(times, default=None)
    )


def when(event: Event) -> datetime:
    """The time of an event."""
    return datetime.fromisoformat(event["time"])


def data_url(run: ExportedRun, picture: Mapping[str, str]) -> str | None:
    """A picture of a run as a ``data:`` URL; None if its file is gone."""
    try:
        data = (run.folder / picture["file"]).read_bytes()
    except OSError:
        return None
    mime = mimetypes.guess_type(picture["file"])[0] or "application/octet-stream"
    return f"data:{mime};base64,{base64.b64encode(data).decode('ascii')}"


def _turns(events: Iterable[Event]) -> list[Turn]:
    """Pair what was asked with what was answered. A call that was sent again counts once."""
    turns: list[Turn] = []
    asked: dict[str, int] = {}
    called: int | None = None
    for event in events:
        match event["kind"]:
            case "request":
                asked[event["role"]] = len(turns)
                turns.append(ModelTurn(event["role"], event, None))
            case "reply" | "unreadable" if event["role"] in asked:
                at = asked.pop(event["role"])
                turns[at] = ModelTurn(event["role"], turns[at].request, event)  # type: ignore[union-attr]
            case "call":
                called = len(turns)
                turns.append(ToolTurn(event, None))
            case "result" if called is not None:
                turns[called] = ToolTurn(turns[called].call, event)  # type: ignore[union-attr]
                called = None
    return turns
