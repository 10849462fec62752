"""Which OpenTelemetry collector takes the spans of runs: the one that the environment names."""

import os
from collections.abc import Mapping

ENDPOINT_VARIABLES = ("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT")
"""The variables that name a collector, as OpenTelemetry has them; the first that is set counts."""


def collector_address(environment: Mapping[str, str] = os.environ) -> str | None:
    """The address of the collector as the environment gives it, None if it names none."""
    return next(filter(None, map(environment.get, ENDPOINT_VARIABLES)), None)
