"""Recorded runs as OpenTelemetry spans, by OTLP over HTTP to the collector that the environment names."""

import os
from collections.abc import Iterable, Mapping
from typing import Any

from folding_client.exports.collectors import ENDPOINT_VARIABLES, collector_address
from folding_client.exports.exported_run import ExportedRun
from folding_client.interrupts import UsageError


def send_spans(runs: Iterable[ExportedRun], environment: Mapping[str, str] = os.environ) -> int:
    """Send the spans of runs; how many. UsageError without the packages or a collector's address, or if it does not take
    them.
    """
    if collector_address(environment) is None:
        message = f"No collector is named; set {ENDPOINT_VARIABLES[-1]} to its address, such as http://localhost:4318."
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
    from opentelemetry.sdk.trace.export import SimpleSpanProcessor
    from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter

    from folding_client.exports.event_spans import EventSpans

    kept = InMemorySpanExporter()
    spans = EventSpans(run.about, SimpleSpanProcessor(kept))
    for event in run.events:
        spans.told(event)
    spans.close()
    return list(kept.get_finished_spans())
