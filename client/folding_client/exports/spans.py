"""Recorded runs as OpenTelemetry spans, by its conventions for generative AI: invoke_agent, chat, execute_tool.

They go by OTLP over HTTP to the collector that ``OTEL_EXPORTER_OTLP_ENDPOINT`` names. The ids are made from the run's, so a run
that is exported twice is the same trace.
"""

import os
from collections.abc import Iterable, Mapping
from datetime import datetime
from hashlib import sha256
from typing import TYPE_CHECKING, Any

from folding_client.exports.exported_run import ExportedRun, ModelTurn, ToolTurn, when
from folding_client.interrupts import UsageError
from folding_client.record.event_log import Event
from folding_client.settings import WITHOUT_ASKING

if TYPE_CHECKING:
    from opentelemetry.context import Context
    from opentelemetry.sdk.trace.id_generator import IdGenerator
    from opentelemetry.trace import Tracer

ENDPOINT_VARIABLES = ("OTEL_EXPORTER_OTLP_ENDPOINT", "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT")
"""The variables that name a collector, as OpenTelemetry has them."""
AGENT_NAME = "foldingagent"


def send_spans(runs: Iterable[ExportedRun], environment: Mapping[str, str] = os.environ) -> int:
    """Send the spans of runs; how many. UsageError without the packages or a collector's address, or if it does not take
    them.
    """
    if not any(environment.get(name) for name in ENDPOINT_VARIABLES):
        message = f"No collector is named; set {ENDPOINT_VARIABLES[0]} to its address, such as http://localhost:4318."
        raise UsageError(message)
    try:
        from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
        from opentelemetry.sdk.trace.export import SpanExportResult
    except ImportError as error:
        message = (
            "Spans need OpenTelemetry, which is not installed; install it with "
            "pip install 'foldingagent-mcp[telemetry]'."
        )
        raise UsageError(message) from error
    exporter = OTLPSpanExporter()
    sent = 0
    try:
        for run in runs:
            spans = run_spans(run)
            if exporter.export(spans) is not SpanExportResult.SUCCESS:
                message = f"The collector did not take the spans of {run.folder}; see that it runs, then give the same command again."
                raise UsageError(message)
            sent += len(spans)
    finally:
        exporter.shutdown()
    return sent


def run_spans(run: ExportedRun) -> list[Any]:
    """The spans of a run, as OpenTelemetry's SDK has them."""
    from opentelemetry.sdk.resources import Resource
    from opentelemetry.sdk.trace import TracerProvider
    from opentelemetry.sdk.trace.export import SimpleSpanProcessor
    from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter

    kept = InMemorySpanExporter()
    service = Resource({"service.name": AGENT_NAME})
    provider = TracerProvider(resource=service, id_generator=_ids(run), shutdown_on_exit=False)
    provider.add_span_processor(SimpleSpanProcessor(kept))
    _trace(run, provider.get_tracer("folding_client"))
    return list(kept.get_finished_spans())


def _ids(run: ExportedRun) -> "IdGenerator":
    """Ids that are the same whenever a run is exported."""
    from opentelemetry.sdk.trace.id_generator import IdGenerator

    name = str(run.about.get("run_id") or run.folder.resolve())

    class _OfRun(IdGenerator):
        def __init__(self) -> None:
            self._count = 0

        def generate_trace_id(self) -> int:
            return int.from_bytes(sha256(f"{name} trace".encode()).digest()[:16], "big")

        def generate_span_id(self) -> int:
            self._count += 1
            return int.from_bytes(sha256(f"{name} {self._count}".encode()).digest()[:8], "big")

    return _OfRun()


def _trace(run: ExportedRun, tracer: "Tracer") -> None:
    """The agent's invocation, and within it every query and every call."""
    from opentelemetry.trace import SpanKind, set_span_in_context

    if run.first is None or run.last is None:
        return
    root = tracer.start_span(
        f"invoke_agent {AGENT_NAME}",
        kind=SpanKind.INTERNAL,
        attributes=_about(run),
        start_time=_nanoseconds(run.first),
    )
    within = set_span_in_context(root)
    for turn in run.turns:
        if isinstance(turn, ToolTurn):
            _execute_tool(run, turn, tracer, within)
        elif turn.role == "agent":
            _chat(run, turn, tracer, within)
        else:
            _invoke_role(run, turn, tracer, within)
    if run.entry.status != "complete":
        _fail(root, run.entry.status, run.entry.reason)
    root.end(_nanoseconds(run.last))


def _about(run: ExportedRun) -> dict[str, Any]:
    """What the span of the whole run says."""
    entry = run.entry
    return {
        **_operation("invoke_agent", run, "agent"),
        "gen_ai.agent.name": AGENT_NAME,
        "gen_ai.conversation.id": str(run.about.get("run_id", "")),
        "gen_ai.usage.input_tokens": _total(run, "input_tokens"),
        "gen_ai.usage.output_tokens": _total(run, "output_tokens"),
        "foldingagent.sequence": entry.sequence,
        "foldingagent.status": entry.status,
        "foldingagent.frames": entry.frames,
        "foldingagent.frames_saved": entry.frames_saved,
    }


def _invoke_role(run: ExportedRun, turn: ModelTurn, tracer: "Tracer", parent: "Context") -> None:
    """A query of another role than the agent's: that role's own invocation within the agent's."""
    from opentelemetry.trace import set_span_in_context

    span = tracer.start_span(
        f"invoke_agent {turn.role}",
        parent,
        attributes={**_operation("invoke_agent", run, turn.role), "gen_ai.agent.name": turn.role},
        start_time=_nanoseconds(when(turn.request)),
    )
    _chat(run, turn, tracer, set_span_in_context(span))
    span.end(_over(run, turn.request, turn.reply))


def _chat(run: ExportedRun, turn: ModelTurn, tracer: "Tracer", parent: "Context") -> None:
    """A query of a model."""
    from opentelemetry.trace import SpanKind

    span = tracer.start_span(
        f"chat {run.model_of(turn.role)}",
        parent,
        kind=SpanKind.CLIENT,
        attributes={**_operation("chat", run, turn.role), "foldingagent.role": turn.role},
        start_time=_nanoseconds(when(turn.request)),
    )
    if turn.reply is None:
        _fail(span, "cut_short", "")
    else:
        usage = turn.reply["usage"]
        span.set_attribute("gen_ai.usage.input_tokens", usage["input_tokens"])
        span.set_attribute("gen_ai.usage.output_tokens", usage["output_tokens"])
        span.set_attribute("gen_ai.usage.cache_read.input_tokens", usage["cached_tokens"])
        if turn.reply["kind"] == "unreadable":
            _fail(span, "unreadable", turn.reply["reason"])
        else:
            span.set_attribute("gen_ai.response.finish_reasons", [turn.reply["finish_reason"]])
    span.end(_over(run, turn.request, turn.reply))


def _execute_tool(run: ExportedRun, turn: ToolTurn, tracer: "Tracer", parent: "Context") -> None:
    """A call of a tool, for the agent or for the client itself."""
    call, result = turn.call, turn.result
    attributes = {
        "gen_ai.operation.name": "execute_tool",
        "gen_ai.tool.name": call["name"],
        "gen_ai.tool.type": "function",
        "foldingagent.by": call["by"],
        **({"gen_ai.tool.call.id": call["id"]} if call["id"] else {}),
    }
    span = tracer.start_span(
        f"execute_tool {call['name']}", parent, attributes=attributes, start_time=_nanoseconds(when(call))
    )
    if result is None:
        _fail(span, "cut_short", "")
    elif result["is_error"]:
        _fail(span, "refused", result["text"])
    span.end(_over(run, call, result))


def _over(run: ExportedRun, begun: Event, ended: Event | None) -> int:
    """When something ended: with the record, if the run was cut short."""
    return _nanoseconds(when(ended) if ended else run.last or when(begun))


def _operation(name: str, run: ExportedRun, role: str) -> dict[str, Any]:
    """What every span of a model says."""
    model = run.model_of(role)
    asks_nobody = model in WITHOUT_ASKING or model.startswith("scripted:")
    provider = model.removeprefix("hybrid:").removeprefix("litellm/").partition("/")[0]
    return {
        "gen_ai.operation.name": name,
        "gen_ai.provider.name": AGENT_NAME if asks_nobody else provider,
        "gen_ai.request.model": model,
    }


def _total(run: ExportedRun, name: str) -> int:
    return sum(totals[name] for totals in run.about.get("totals", {}).values())


def _fail(span: Any, kind: str, why: str) -> None:  # noqa: ANN401 - a span of the SDK
    from opentelemetry.trace import Status, StatusCode

    span.set_attribute("error.type", kind)
    span.set_status(Status(StatusCode.ERROR, why))


def _nanoseconds(time: datetime) -> int:
    return int(time.timestamp() * 1_000_000) * 1000
