"""The events of a run as OpenTelemetry spans, by its conventions for generative AI: invoke_agent, chat, execute_tool.

The same for a run at work and for one on record, so that both come to the same trace. Needs OpenTelemetry's SDK, which the
extra ``telemetry`` brings; whoever imports this module says so where it is missing.
"""

from collections import Counter
from collections.abc import Mapping
from datetime import datetime
from hashlib import sha256
from typing import Any, NamedTuple

from opentelemetry.sdk.resources import Resource
from opentelemetry.sdk.trace import SpanProcessor, TracerProvider
from opentelemetry.sdk.trace.id_generator import IdGenerator
from opentelemetry.trace import Span, SpanKind, Status, StatusCode, set_span_in_context

from folding_client.record.event_log import Event
from folding_client.record.redaction import redact
from folding_client.settings import WITHOUT_ASKING

AGENT_NAME = "foldingagent"
CUT_SHORT = "cut_short"
"""The ``error.type`` of what has no end on record."""


class RunSpanIds(IdGenerator):
    """Ids made from what tells a run from others and, of a span, from what it begins with: the same whenever they are made."""

    def __init__(self, run: str) -> None:
        self._run = run
        self.beginning = ""

    def generate_trace_id(self) -> int:
        """The id of the run's trace, 128 bits."""
        return int.from_bytes(sha256(f"{self._run} trace".encode()).digest()[:16], "big")

    def generate_span_id(self) -> int:
        """The id of the span that begins with ``beginning``, 64 bits."""
        return int.from_bytes(sha256(f"{self._run} {self.beginning}".encode()).digest()[:8], "big")


class _QuerySpans(NamedTuple):
    """A query that is under way; ``role`` is the invocation of a role other than the agent's."""

    chat: Span
    role: Span | None


class EventSpans:
    """Makes the spans of a run, told its events in order; ended ones go to ``processor``.

    The run is an ``invoke_agent``, and so is, within it, each time that it was resumed. What is asked and called meanwhile
    lies within the one at work; another role's query within an ``invoke_agent`` of its own.
    """

    def __init__(self, about: Mapping[str, Any], processor: SpanProcessor) -> None:
        self._about = about
        self._ids = RunSpanIds(f"{about['created']} {about['sequence']['folder']}")
        service = Resource({"service.name": AGENT_NAME})
        provider = TracerProvider(resource=service, id_generator=self._ids, shutdown_on_exit=False)
        provider.add_span_processor(processor)
        self._tracer = provider.get_tracer("folding_client")
        self._first: Span | None = None
        self._run: Span | None = None
        self._queries: dict[str, _QuerySpans] = {}
        self._tool: Span | None = None
        self._tokens: Counter[str] = Counter()
        self._saved = 0
        self._now = 0

    def told(self, event: Event) -> None:
        """Start and end what the event starts and ends."""
        if self._run is None or event["kind"] == "resumed":
            self.close()
            self._run = self._invoke_agent(event)
        self._now = _nanoseconds(event)
        match event["kind"]:
            case "opened" | "resumed":
                self._run.set_attribute("gen_ai.conversation.id", event["run_id"])
                self._saved = len(event["saved"])
            case "step_over":
                self._saved = event["frame"]
            case "request":
                self._request(event)
            case "reply" | "unreadable":
                self._reply(event)
            case "call":
                self._call(event)
            case "result":
                self._result(event)
            case "ended":
                self._end_run(event["status"], event["reason"])

    def close(self) -> None:
        """End whatever is under way as cut short."""
        self._end_run(CUT_SHORT, "")

    def _invoke_agent(self, event: Event) -> Span:
        """The invocation that begins with an event."""
        span = self._start(
            f"invoke_agent {AGENT_NAME}",
            event,
            self._first,
            {
                **self._operation("invoke_agent", "agent"),
                "gen_ai.agent.name": AGENT_NAME,
                "foldingagent.sequence": self._about["sequence"]["name"],
            },
        )
        self._first = self._first or span
        self._tokens.clear()
        return span

    def _end_run(self, status: str, reason: str) -> None:
        """End the invocation at work, and what it was about."""
        for role in list(self._queries):
            self._cut_query_short(role)
        self._cut_tool_short()
        if self._run is None or not self._run.is_recording():
            return
        for name in ("input_tokens", "output_tokens"):
            self._run.set_attribute(f"gen_ai.usage.{name}", self._tokens[name])
        self._run.set_attribute("foldingagent.status", status)
        self._run.set_attribute("foldingagent.frames", self._about["sequence"].get("frames") or 0)
        self._run.set_attribute("foldingagent.frames_saved", self._saved)
        if status != "complete":
            _fail(self._run, status, reason)
        self._run.end(self._now)

    def _request(self, event: Event) -> None:
        """A query begins; one of the same role that was not answered is cut short."""
        role = event["role"]
        self._cut_query_short(role)
        within, own = self._run, None
        if role != "agent":
            said = {**self._operation("invoke_agent", role), "gen_ai.agent.name": role}
            within = own = self._start(f"invoke_agent {role}", event, self._run, said)
        said = {**self._operation("chat", role), "foldingagent.role": role}
        chat = self._start(f"chat {self._model_of(role)}", event, within, said, SpanKind.CLIENT)
        self._queries[role] = _QuerySpans(chat, own)

    def _reply(self, event: Event) -> None:
        """A query ends, by a reply that can be read or not."""
        query = self._queries.pop(event["role"], None)
        if query is None:
            return
        usage = event["usage"]
        self._tokens.update(input_tokens=usage["input_tokens"], output_tokens=usage["output_tokens"])
        query.chat.set_attribute("gen_ai.usage.input_tokens", usage["input_tokens"])
        query.chat.set_attribute("gen_ai.usage.output_tokens", usage["output_tokens"])
        query.chat.set_attribute("gen_ai.usage.cache_read.input_tokens", usage["cached_tokens"])
        if event["kind"] == "unreadable":
            _fail(query.chat, "unreadable", event["reason"])
        else:
            query.chat.set_attribute("gen_ai.response.finish_reasons", [event["finish_reason"]])
        self._end_query(query)

    def _cut_query_short(self, role: str) -> None:
        query = self._queries.pop(role, None)
        if query is not None:
            _fail(query.chat, CUT_SHORT, "")
            self._end_query(query)

    def _end_query(self, query: _QuerySpans) -> None:
        query.chat.end(self._now)
        if query.role is not None:
            query.role.end(self._now)

    def _call(self, event: Event) -> None:
        """A call of a tool begins, for the agent or for the client itself."""
        self._cut_tool_short()
        said = {
            "gen_ai.operation.name": "execute_tool",
            "gen_ai.tool.name": event["name"],
            "gen_ai.tool.type": "function",
            "foldingagent.by": event["by"],
            **({"gen_ai.tool.call.id": event["id"]} if event["id"] else {}),
        }
        self._tool = self._start(f"execute_tool {event['name']}", event, self._run, said)

    def _result(self, event: Event) -> None:
        """The call under way is answered."""
        if self._tool is None:
            return
        if event["is_error"]:
            _fail(self._tool, "refused", event["text"])
        self._tool.end(self._now)
        self._tool = None

    def _cut_tool_short(self) -> None:
        if self._tool is not None:
            _fail(self._tool, CUT_SHORT, "")
            self._tool.end(self._now)
            self._tool = None

    def _start(
        self,
        name: str,
        event: Event,
        within: Span | None,
        attributes: Mapping[str, Any],
        kind: SpanKind = SpanKind.INTERNAL,
    ) -> Span:
        """A span that begins with an event, within another."""
        self._ids.beginning = f"{event['seq']} {name}"
        context = None if within is None else set_span_in_context(within)
        return self._tracer.start_span(
            name, context, kind=kind, attributes=attributes, start_time=_nanoseconds(event)
        )

    def _operation(self, name: str, role: str) -> dict[str, Any]:
        """What every span of a model says."""
        model = self._model_of(role)
        asks_nobody = model in WITHOUT_ASKING or model.startswith("scripted:")
        provider = model.removeprefix("hybrid:").removeprefix("litellm/").partition("/")[0]
        return {
            "gen_ai.operation.name": name,
            "gen_ai.provider.name": AGENT_NAME if asks_nobody else provider,
            "gen_ai.request.model": model,
        }

    def _model_of(self, role: str) -> str:
        return str(self._about["models"].get(role, role))


def _fail(span: Span, kind: str, why: str) -> None:
    span.set_attribute("error.type", kind)
    span.set_status(Status(StatusCode.ERROR, redact(why)))


def _nanoseconds(event: Event) -> int:
    """The time of an event."""
    return int(datetime.fromisoformat(event["time"]).timestamp() * 1_000_000) * 1000
