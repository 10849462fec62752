"""Sends spans in the background while a run works. Needs OpenTelemetry, as :mod:`folding_client.exports.event_spans` does."""

import logging
import threading
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

from opentelemetry.context import Context
from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
from opentelemetry.sdk.trace import ReadableSpan, Span, SpanProcessor
from opentelemetry.sdk.trace.export import BatchSpanProcessor, SpanExporter, SpanExportResult

from folding_client.exports.event_spans import EventSpans
from folding_client.exports.live_spans import tell_once
from folding_client.record.event_log import Event

LAST_SPANS_SECONDS = 2.0
"""How long the end of a run waits for a collector that answers to take the last spans. A collector in the same network takes
some milliseconds.
"""


class SpanCollector(SpanExporter):
    """Hands spans to the collector at an address and knows whether it took the last ones. For all runs of a process."""

    def __init__(self, address: str) -> None:
        self._address = address
        self._exporter = OTLPSpanExporter()
        self.away = False

    def export(self, spans: Sequence[ReadableSpan]) -> SpanExportResult:
        """Send spans; if they are not taken, that is told, once."""
        result = self._exporter.export(spans)
        self.away = result is not SpanExportResult.SUCCESS
        if self.away:
            self.tell()
        return result

    def tell(self) -> None:
        """Say that spans are missing."""
        tell_once(
            f"The collector at {self._address} does not take spans, so some are missing there; see that it runs. "
            "foldingagent export-logs RUN --spans sends those of a run from its record."
        )

    def shutdown(self) -> None:
        """Nothing: other runs go on."""


@cache
def span_collector(address: str) -> SpanCollector:
    """The collector that the environment names. ValueError, RuntimeError or OSError if its variables say what cannot be."""
    logging.getLogger("opentelemetry").addHandler(logging.NullHandler())
    return SpanCollector(address)


class _SendsWhatIsNew(SpanProcessor):
    """Passes spans on, but for those that ended before the run was resumed, which were sent then."""

    def __init__(self, sends: BatchSpanProcessor) -> None:
        self._sends = sends
        self.resuming = True

    def on_start(self, span: Span, parent_context: Context | None = None) -> None:
        """Pass a beginning on."""
        self._sends.on_start(span, parent_context)

    def on_end(self, span: ReadableSpan) -> None:
        """Pass a span on."""
        if not self.resuming:
            self._sends.on_end(span)


class LiveSpans:
    """Told the events of a run as they are recorded, has its spans sent by a thread of its own."""

    def __init__(self, about: Mapping[str, Any], before: Iterable[Event], collector: SpanCollector) -> None:
        self._collector = collector
        self._sends = BatchSpanProcessor(collector)
        new = _SendsWhatIsNew(self._sends)
        self._spans = EventSpans(about, new)
        for event in before:
            self._spans.told(event)
        new.resuming = False

    def told(self, event: Event) -> None:
        """Take an event that was put on record."""
        self._spans.told(event)

    def close(self) -> None:
        """End the spans; wait for the last to be sent, unless the collector is known to be away."""
        self._spans.close()
        last = threading.Thread(target=self._sends.shutdown, daemon=True)
        last.start()
        last.join(0 if self._collector.away else LAST_SPANS_SECONDS)
        if last.is_alive():
            self._collector.away = True
            self._collector.tell()
