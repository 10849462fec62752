"""Writes what happens in a run, as it happens: events, pictures, sums, and the description in
``run.json``.
"""

import logging
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

from folding_client.messages import Message, Picture, Reply, ToolCall, ToolResult, Usage
from folding_client.progress import Progress, Silent
from folding_client.protocol.requests import unanswered
from folding_client.record.event_log import EventListener, EventLog, read_events
from folding_client.record.fits import FitRecord
from folding_client.record.folder import RunFolder
from folding_client.record.totals import (
    Totals,
    deciders_of,
    decision,
    seconds_of,
    tallied,
    tally_of,
    totals_of,
)

RECORD_FORMAT = 1
_LOG = logging.getLogger(__name__)
_LOGGED = frozenset(
    {"role", "frame", "name", "tool", "seconds", "is_error", "reason", "status", "verdict", "wait"}
)
"""What is logged of an event beside its kind."""


class Recorder:
    """The one writer of a run folder. ``about`` is what ``run.json`` says beside outcome and sums; ``progress`` is told
    of every event, and ``listeners`` of each once it is on record.

    ``unanswered`` is the call that was on its way when the run was last cut short, if one was.
    """

    def __init__(
        self,
        folder: RunFolder,
        about: dict[str, Any],
        progress: Progress | None = None,
        listeners: Sequence[EventListener] = (),
    ) -> None:
        self.folder = folder
        self.about = about
        self._progress = progress or Silent()
        self._listeners = listeners
        before = list(read_events(folder.events)) if folder.events.exists() else []
        self._log = EventLog(folder.events)
        self.unanswered = unanswered(before)
        self.totals = totals_of(before)
        self._tally = tally_of(before)
        self._deciders = deciders_of(before)
        self._fits = FitRecord(before)
        self._seconds_before = seconds_of(before)
        self._started = time.monotonic()

    @property
    def decided(self) -> Mapping[int, str]:
        """By frame, who decided it last."""
        return self._deciders

    @property
    def seconds(self) -> float:
        """Seconds that were worked on the run, those before it was resumed included."""
        return self._seconds_before + time.monotonic() - self._started

    def event(self, kind: str, **data: object) -> None:
        """Append one event."""
        if name := tallied(kind, data):
            self._tally[name] += 1
        self._deciders |= decision(kind, data)
        _LOG.debug("%s %s", kind, {name: data[name] for name in _LOGGED & data.keys()})
        self._fits.add(kind, data)
        written = self._log.append(kind, **data)
        for listener in self._listeners:
            listener.told(written)
        self._progress.told(kind, data, self.totals)

    def request(self, role: str, messages: Sequence[Message], new_from: int) -> None:
        """A query goes out: the messages from ``new_from`` on are new to this conversation, the others are on
        record.
        """
        self.event(
            "request",
            role=role,
            messages=len(messages),
            new_from=new_from,
            new=[self._message(message) for message in messages[new_from:]],
        )

    def reply(self, role: str, reply: Reply, seconds: float) -> None:
        """A reply came; its tokens and price are added to the role's sums."""
        self._add(role, reply.usage, seconds)
        self.event(
            "reply",
            role=role,
            seconds=round(seconds, 3),
            text=reply.text,
            thinking=reply.thinking,
            calls=[asdict(call) for call in reply.tool_calls],
            finish_reason=reply.finish_reason,
            usage=asdict(reply.usage),
            native=reply.native,
        )

    def unreadable(self, role: str, reason: str, usage: Usage, seconds: float) -> None:
        """A reply came that cannot be read; it is counted like any other."""
        self._add(role, usage, seconds)
        self.event("unreadable", role=role, seconds=round(seconds, 3), reason=reason, usage=asdict(usage))

    def call(
        self,
        by: str,
        call: ToolCall | None,
        name: str,
        arguments: dict[str, Any],
        request_id: str | None = None,
        *,
        technical: bool = False,
    ) -> None:
        """A tool call goes to the server, for the agent or for the client itself, with a ``technical`` reason or without."""
        why = {"technical": True} if technical else {}
        self.event(
            "call",
            by=by,
            id=call.id if call else None,
            name=name,
            arguments=arguments,
            request_id=request_id,
            **why,
        )

    def result(self, by: str, name: str, result: ToolResult, seconds: float) -> None:
        """The server answered the last call."""
        self.event("result", by=by, name=name, seconds=round(seconds, 3), **self._result(result))

    def outcome(self, status: str, reason: str, frames_saved: int, frames: int) -> None:
        """Write ``run.json`` with the state of things; called at the start, after every step and at
        the end.
        """
        self.about["outcome"] = {
            "status": status,
            "reason": reason,
            "frames_saved": frames_saved,
            "frames": frames,
            "seconds": round(self.seconds, 3),
            "updated": datetime.now(UTC).isoformat(),
        }
        self.about["decided"] = {str(frame): by for frame, by in sorted(self._deciders.items())}
        self.about["fits"] = self._fits.described(frames_saved)
        self.about["tally"] = dict(sorted(self._tally.items()))
        self.about["totals"] = {role: asdict(totals) for role, totals in self.totals.items()}
        self.folder.write_json("run.json", self.about)

    def close(self) -> None:
        """Close the log, and tell the listeners that it is over."""
        self._log.close()
        for listener in self._listeners:
            listener.close()

    def _add(self, role: str, usage: Usage, seconds: float) -> None:
        self.totals[role] = self.totals.get(role, Totals()).plus(usage, seconds)

    def _pictures(self, pictures: Sequence[Picture]) -> list[dict[str, str]]:
        return [
            {"file": self.folder.keep_picture(picture), "subject": picture.subject} for picture in pictures
        ]

    def _message(self, message: Message) -> dict[str, Any]:
        entry: dict[str, Any] = {"role": message.role, "text": message.text}
        if message.pictures:
            entry["images"] = self._pictures(message.pictures)
        if message.call_id is not None:
            entry |= {"call_id": message.call_id, "tool": message.tool, "is_error": message.is_error}
        if message.tool_calls:
            entry["calls"] = [asdict(call) for call in message.tool_calls]
        return entry

    def _result(self, result: ToolResult) -> dict[str, Any]:
        text = result.text if result.is_error or result.data is None else ""
        return {
            "is_error": result.is_error,
            "text": text,
            "structured": result.data,
            "images": self._pictures(result.pictures),
        }
