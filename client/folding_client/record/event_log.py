"""The append-only log of a run: one JSON object a line, flushed as it is written."""

import json
import os
import time
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, Any, Protocol

from folding_client.interrupts import UsageError
from folding_client.record.redaction import redact

Event = dict[str, Any]


class EventListener(Protocol):
    """Is told of every event of a run once it is on record."""

    def told(self, event: Event) -> None:
        """Take an event."""
        ...

    def close(self) -> None:
        """The work on the run is over."""
        ...


class EventLog:
    """Appends events to a file; reopening it continues the numbering and drops a line that was cut off.

    The run folder's lock keeps other processes from appending to it.

    Every event has ``seq`` (from 1), ``time`` (UTC), ``elapsed`` (seconds since the log was opened) and
    ``kind``.
    """

    def __init__(self, path: Path) -> None:
        self._file: IO[str] = path.open("a", encoding="utf-8")
        self._seq = _mended(path)
        self._opened = time.monotonic()

    def append(self, kind: str, **data: object) -> Event:
        """Write one event and hand it to the operating system before returning it."""
        self._seq += 1
        event: Event = {
            "seq": self._seq,
            "time": datetime.now(UTC).isoformat(timespec="milliseconds"),
            "elapsed": round(time.monotonic() - self._opened, 3),
            "kind": kind,
            **data,
        }
        self._file.write(redact(json.dumps(event, ensure_ascii=False)) + "\n")
        self._file.flush()
        return event

    def close(self) -> None:
        """Write through to the disk and close."""
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()


def read_events(path: Path) -> Iterator[Event]:
    """The events of a log in order; a last line that was cut off by a kill is left out. UsageError if
    unreadable.
    """
    try:
        lines = path.read_bytes().split(b"\n")
    except OSError as error:
        message = (
            f"No recorded run at {path.parent}: {error.strerror}. Name a folder that holds an events.jsonl."
        )
        raise UsageError(message) from error
    for number, line in enumerate(lines[:-1], start=1):
        event = _event(line)
        if event is None:
            message = (
                f"Line {number} of {path} is no event, so the record is damaged; use another run folder."
            )
            raise UsageError(message)
        yield event


def _event(line: bytes) -> Event | None:
    """The event that a line of a log states; None if it states none."""
    try:
        event = json.loads(line)
    except ValueError:
        return None
    return event if isinstance(event, dict) and "kind" in event else None


def gaps(events: Iterable[Event]) -> Iterator[tuple[int, int]]:
    """The numbers of the events that are missing from a log, first and last of each gap."""
    before = 0
    for event in events:
        if event["seq"] > before + 1:
            yield before + 1, event["seq"] - 1
        before = event["seq"]


def _mended(path: Path) -> int:
    """Cut an unfinished last line off a log; the number of the last line that is left, 0 if none is."""
    whole = path.read_bytes()
    end = whole.rfind(b"\n") + 1
    if end < len(whole):
        with path.open("r+b") as file:
            file.truncate(end)
    last = _event(whole[:end].rstrip(b"\n").rpartition(b"\n")[2])
    return int(last["seq"]) if last and "seq" in last else whole.count(b"\n")
