"""The spans of a run while it works, where the environment names a collector for them.

A collector that is away, or packages that are missing, are told once in a process, and neither stop nor slow a run.
"""

import logging
import os
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

from folding_client.exports.collectors import ENDPOINT_VARIABLES, collector_address
from folding_client.record.event_log import Event, EventListener
from folding_client.record.redaction import redact

_LOG = logging.getLogger(__name__)


def span_listeners(
    about: Mapping[str, Any], before: Iterable[Event], environment: Mapping[str, str] = os.environ
) -> tuple[EventListener, ...]:
    """What has to be told the events of a run so that its spans are sent; nothing if no collector is named.

    ``about`` is what ``run.json`` says, ``before`` what is on record of the run if it is resumed.
    """
    address = collector_address(environment)
    if address is None:
        return ()
    try:
        from folding_client.exports.span_sending import LiveSpans, span_collector
    except ImportError:
        tell_once(
            f"{' or '.join(ENDPOINT_VARIABLES)} is set, but no spans are sent, since OpenTelemetry is not installed; "
            "pip install 'foldingagent-mcp[telemetry]' brings it."
        )
        return ()
    try:
        return (LiveSpans(about, before, span_collector(address)),)
    except (ValueError, RuntimeError, OSError) as error:
        tell_once(f"No spans are sent to {address}: {error} Correct the variables that begin with OTEL_.")
        return ()


@cache
def tell_once(sentence: str) -> None:
    """Log a sentence as a warning, which a person sees on stderr; the same one not again in this process."""
    _LOG.warning("%s", redact(sentence))
