"""The events of a run as a nested trace: steps, in them the queries of the agent, in these what followed from each reply."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from folding_schemas.event_record import (
    CallEvent,
    RecordedEvent,
    RecordedPicture,
    RecordedToolCall,
    ReplyEvent,
    RequestEvent,
    RequestOptionsEvent,
    ResultEvent,
    StepStartedEvent,
    UnreadableEvent,
)

from folding_client.report.frame_reports import RECORDED_PICTURE

LONGEST_TEXT = 6_000
"""Characters of one text that a page shows: more than any reply in a run of the paper's length; the rest is in the record."""
_LONG_ENOUGH_TO_REPEAT = 200
"""Characters from which on a text that was shown before is only referred to."""
_ON_THE_OUTSIDE = frozenset({"seq", "time", "elapsed", "kind"})
_AGENT = "agent"

Tone = Literal["plain", "good", "bad"]
_BAD = frozenset(
    {
        *("refused", "skipped", "rolled_back", "rewound", "unreadable", "retry", "server_lost", "stopped"),
        *("plan_failed", "plan_refused", "output_missing", "outputs_missing", "saved_against"),
    }
)


@dataclass(frozen=True)
class TraceText:
    """A text of an entry under a heading; ``code`` keeps its lines. ``shown_at`` is the number of the event where the same
    text is shown already.
    """

    heading: str
    text: str
    code: bool = False
    shown_at: int | None = None


@dataclass
class TraceEntry:
    """One event, or a query or call with its answer, and what it led to."""

    seq: int
    kind: str
    title: str
    gist: str = ""
    tone: Tone = "plain"
    seconds: float | None = None
    tokens: int | None = None
    cost: float | None = None
    texts: list[TraceText] = field(default_factory=list)
    pictures: list[RecordedPicture] = field(default_factory=list)
    entries: list["TraceEntry"] = field(default_factory=list)


@dataclass
class TraceStep:
    """The work from one ``step_started`` to the next; ``frame`` is None for what is around it."""

    seq: int
    frame: int | None
    entries: list[TraceEntry] = field(default_factory=list)


class Trace:
    """Made from the events of a run, in order."""

    def __init__(self, events: Iterable[RecordedEvent]) -> None:
        self.steps: list[TraceStep] = []
        self._shown: dict[str, int] = {}
        self._agent: TraceEntry | None = None
        self._query: TraceEntry | None = None
        self._call: TraceEntry | None = None
        for event in events:
            self._add(event)

    def _add(self, event: RecordedEvent) -> None:
        match event:
            case StepStartedEvent():
                self.steps.append(TraceStep(event.seq, event.frame))
                self._agent = self._query = self._call = None
            case RequestEvent():
                self._asked(event)
            case ReplyEvent():
                self._replied(event)
            case UnreadableEvent():
                self._unreadable(event)
            case CallEvent():
                self._called(event)
            case ResultEvent():
                self._answered(event)
            case RequestOptionsEvent():
                self._put(self._noted(event))
            case _:
                self._put(self._noted(event))

    def _put(self, entry: TraceEntry) -> None:
        """An entry where it belongs: what follows from a reply of the agent is part of that query."""
        if self._agent is not None:
            self._agent.entries.append(entry)
            return
        if not self.steps:
            self.steps.append(TraceStep(entry.seq, None))
        self.steps[-1].entries.append(entry)

    def _asked(self, event: RequestEvent) -> None:
        if event.role == _AGENT:
            self._agent = None
        entry = TraceEntry(event.seq, "query", f"{event.role}")
        for message in event.new:
            if message.role in {"system", "user"}:
                entry.texts.append(self._text(f"{message.role} message", message.text, event.seq))
                entry.pictures += _named_pictures(message.images)
        self._put(entry)
        self._query, self._call = entry, None
        if event.role == _AGENT:
            self._agent = entry

    def _replied(self, event: ReplyEvent) -> None:
        entry = self._query or TraceEntry(event.seq, "query", event.role)
        if self._query is None:
            self._put(entry)
        entry.seconds, entry.cost = event.seconds, event.usage.cost
        entry.tokens = event.usage.input_tokens + event.usage.output_tokens
        entry.gist = _gist(event)
        if event.thinking:
            entry.texts.append(self._text("reasoning", event.thinking, event.seq))
        if event.text:
            entry.texts.append(self._text("reply", event.text, event.seq))
        if event.calls:
            listed = "\n".join(map(_written_call, event.calls))
            entry.texts.append(self._text("calls", listed, event.seq, code=True))
        self._query = None

    def _unreadable(self, event: UnreadableEvent) -> None:
        entry = self._query or TraceEntry(event.seq, "query", event.role)
        if self._query is None:
            self._put(entry)
        entry.seconds, entry.cost, entry.tone = event.seconds, event.usage.cost, "bad"
        entry.tokens = event.usage.input_tokens + event.usage.output_tokens
        entry.gist = f"unreadable: {event.reason}"
        self._query = None

    def _called(self, event: CallEvent) -> None:
        arguments = {name: value for name, value in event.arguments.items() if name != "run_id"}
        entry = TraceEntry(event.seq, "call", event.name, _in_brackets(arguments))
        if event.technical:
            entry.texts.append(TraceText("why", "for a technical reason; it costs no attempt"))
        if event.by != _AGENT:
            entry.kind = "own call"
        self._put(entry)
        self._call = entry

    def _answered(self, event: ResultEvent) -> None:
        entry = self._call
        if entry is None:
            entry = TraceEntry(event.seq, "call", event.name)
            self._put(entry)
        entry.seconds = event.seconds
        entry.tone = "bad" if event.is_error else _tone_of(event.structured)
        if event.text:
            entry.texts.append(self._text("refused" if event.is_error else "answer", event.text, event.seq))
        if event.structured:
            entry.texts.append(self._text("answer", _as_json(event.structured), event.seq, code=True))
        entry.pictures += _named_pictures(event.images)
        self._call = None

    def _noted(self, event: RecordedEvent) -> TraceEntry:
        told = event.model_dump(mode="json", exclude=set(_ON_THE_OUTSIDE), exclude_none=True)
        kind = str(getattr(event, "kind", "event"))
        entry = TraceEntry(event.seq, "event", kind.replace("_", " "), _plain_words(told))
        entry.tone = "bad" if kind in _BAD else _tone_of(told)
        entry.texts.append(self._text("event", _as_json(told), event.seq, code=True))
        return entry

    def _text(self, heading: str, text: str, seq: int, *, code: bool = False) -> TraceText:
        """A text to show, cut where it is too long for a page; a reference where the page has it already."""
        if len(text) >= _LONG_ENOUGH_TO_REPEAT:
            if (before := self._shown.get(text)) is not None:
                return TraceText(heading, "", shown_at=before)
            self._shown[text] = seq
        if len(text) > LONGEST_TEXT:
            text = f"{text[:LONGEST_TEXT]}\n[{len(text) - LONGEST_TEXT} more characters are in events.jsonl]"
        return TraceText(heading, text, code)


def _named_pictures(pictures: Sequence[RecordedPicture]) -> list[RecordedPicture]:
    """The pictures whose file names are those of a record."""
    return [picture for picture in pictures if RECORDED_PICTURE.fullmatch(picture.file)]


def _gist(event: ReplyEvent) -> str:
    """What a reply comes to, in a line."""
    if event.calls:
        return "; ".join(map(_written_call, event.calls))[:200]
    return " ".join(event.text.split())[:200] or event.finish_reason


def _written_call(call: RecordedToolCall) -> str:
    try:
        arguments = json.loads(call.arguments or "{}")
    except ValueError:
        arguments = None
    return f"{call.name}{_in_brackets(arguments) if isinstance(arguments, dict) else f'({call.arguments})'}"


def _in_brackets(arguments: dict[str, Any]) -> str:
    return f"({', '.join(f'{name}={json.dumps(value, ensure_ascii=False)}' for name, value in arguments.items())})"


def _as_json(data: dict[str, Any]) -> str:
    """An object with a line for each member."""
    lines = (
        f"{json.dumps(name, ensure_ascii=False)}: {json.dumps(value, ensure_ascii=False)}"
        for name, value in data.items()
    )
    return "\n".join(lines)


def _plain_words(data: dict[str, Any]) -> str:
    """The short members of an event in a line."""
    told = (
        f"{name} {value}"
        for name, value in data.items()
        if isinstance(value, str | int | float) and not isinstance(value, bool) and str(value)
    )
    return ", ".join(told)[:200]


def _tone_of(data: dict[str, Any] | None) -> Tone:
    """Green for a match, red for what a critic found wrong."""
    verdict = (data or {}).get("verdict")
    if verdict is None:
        return "plain"
    return "good" if verdict == "MATCH" else "bad"
