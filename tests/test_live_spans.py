"""The spans of a run that a collector gets over HTTP while the run works."""

import asyncio
import logging
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from client_runs import MATCH, act, ask, events, resume, run, save, sequence, server_url, settings
from folding_client.exports.live_spans import span_listeners, tell_once
from folding_client.exports.span_sending import LAST_SPANS_SECONDS
from folding_client.progress import Silent
from folding_client.reconstruct import new_job, reconstruct
from folding_client.record.folder import RunFolder
from folding_client.record.totals import Totals
from providers.openai import OpenAI
from test_client_commands import command, script
from test_client_commands import save as save_call
from test_exports import MODEL, TURN, Collector, attributes, collector

COMES_WITHIN = 5.0
"""Seconds until a span that was sent is at a collector on this machine, however busy it is."""


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ended spans are sent at once, not every five seconds."""
    monkeypatch.setenv("OTEL_BSP_SCHEDULE_DELAY", "20")
    tell_once.cache_clear()


def told_of(spans: list[Any]) -> dict[bytes, Any]:
    """What is told of each span by its id; no span may come twice."""
    assert len({span.span_id for span in spans}) == len(spans)
    return {
        span.span_id: (
            span.trace_id,
            span.parent_span_id,
            span.name,
            span.start_time_unix_nano,
            span.end_time_unix_nano,
            span.status.message,
            attributes(span),
        )
        for span in spans
    }


def exported(kept: Collector, out: Path) -> list[Any]:
    """The spans that are sent from the record of a run."""
    before = len(kept.spans)
    assert command("export-logs", out, "--spans").returncode == 0
    return kept.spans[before:]


def test_a_run_at_work_sends_the_spans_that_its_record_makes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with (
        collector(monkeypatch) as kept,
        OpenAI(save(1), act(TURN), ask(2, "rotate"), MATCH, save(2)) as provider,
    ):
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
        live = kept.spans
        assert told_of(live) == told_of(exported(kept, tmp_path / "run"))
    assert len({span.trace_id for span in live}) == 1
    assert {"invoke_agent foldingagent", "invoke_agent critic", "execute_tool rotate"} <= {
        span.name for span in live
    }


class _Watching(Silent):
    """Keeps what had come to a collector by the time the second frame was saved."""

    def __init__(self, kept: Collector) -> None:
        self._kept = kept
        self.seen: list[str] = []

    def told(self, kind: str, data: Mapping[str, Any], totals: Mapping[str, Totals]) -> None:
        """Wait for the spans, which another thread sends."""
        super().told(kind, data, totals)
        until = time.monotonic() + COMES_WITHIN
        while kind == "step_over" and data["frame"] == 2 and time.monotonic() < until:
            self.seen = [span.name for span in self._kept.spans]
            if "execute_tool rotate" in self.seen:
                return
            time.sleep(0.02)


def test_spans_come_before_the_run_is_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = script(tmp_path, [save_call(1)], [{"tool": "rotate", "arguments": {"angle": 45}}, save_call(2)])
    with collector(monkeypatch) as kept:
        watching = _Watching(kept)
        asyncio.run(reconstruct(new_job(sequence(2), tmp_path / "run", settings(model=model)), watching))
    assert "execute_tool rotate" in watching.seen
    assert "invoke_agent foldingagent" not in watching.seen


def test_a_resumed_run_goes_on_with_its_trace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "run"
    with collector(monkeypatch) as kept:
        with OpenAI(save(1), act(TURN)) as provider:
            assert run(2, out, model=MODEL, api_base=provider.url, max_queries=2).status == "stopped"
        with OpenAI(act(TURN), save(2)) as provider:
            resumed = resume(out, api_base=provider.url, max_queries=9)
            assert resumed.status == "complete"
        live = kept.spans
        assert told_of(live) == told_of(exported(kept, out))
    first, second = [span for span in live if span.name == "invoke_agent foldingagent"]
    assert (first.trace_id, first.span_id) == (second.trace_id, second.parent_span_id)
    assert [attributes(span)["foldingagent.status"] for span in (first, second)] == ["stopped", "complete"]
    assert "limit of 2 queries" in first.status.message


def test_what_was_under_way_when_a_run_was_killed_is_sent_when_it_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The process that was killed sent what had ended; the one that goes on sends the rest, and nothing twice."""
    out = tmp_path / "run"
    with OpenAI(save(1), act(TURN)) as provider:
        run(2, out, model=MODEL, api_base=provider.url, max_queries=2)
    with OpenAI(act(TURN), save(2)) as provider:
        resume(out, api_base=provider.url, max_queries=9)
    about, recorded = RunFolder(out).description(), events(out)
    killed = next(at for at, event in enumerate(recorded) if event["kind"] == "reply")
    resumed = next(at for at, event in enumerate(recorded) if event["kind"] == "resumed")
    left = [*recorded[:killed], *recorded[resumed:]]
    with collector(monkeypatch) as kept:
        (listener,) = span_listeners(about, left[:killed])
        for event in left[killed:]:
            listener.told(event)
        listener.close()
    cut = {span.name for span in kept.spans if attributes(span).get("error.type") == "cut_short"}
    assert cut == {"invoke_agent foldingagent", f"chat {MODEL}"}
    assert len(told_of(kept.spans)) == len(kept.spans)
    assert {event["seq"] for event in left[:killed] if event["kind"] == "result"}
    assert "execute_tool open_run" not in {span.name for span in kept.spans}, "it had ended before the kill"


def free_port() -> int:
    """A port on which nothing listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.mark.slow
def test_a_collector_that_is_away_is_told_once_on_stderr_and_the_run_is_complete(tmp_path: Path) -> None:
    model = script(tmp_path, [save_call(1)], [{"tool": "rotate", "arguments": {"angle": 45}}, save_call(2)])
    address = f"http://127.0.0.1:{free_port()}"
    words = ["run", sequence(2), "--model", model, "--out", tmp_path / "run", "--server-url", server_url()]
    done = subprocess.run(
        [sys.executable, "-m", "folding_client", *map(str, words), "--quiet"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "OTEL_EXPORTER_OTLP_ENDPOINT": address, "OTEL_BSP_SCHEDULE_DELAY": "20"},
    )
    assert done.returncode in {0, 4}
    assert done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith(f"The collector at {address} does not take spans")


@pytest.mark.slow
def test_a_collector_that_never_answers_keeps_no_run_waiting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    model = script(tmp_path, [save_call(1)])
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"http://127.0.0.1:{silent.getsockname()[1]}"
        monkeypatch.setenv("OTEL_EXPORTER_OTLP_ENDPOINT", address)
        waited = []
        for number in (1, 2):
            run(2, tmp_path / f"run{number}", model=model)
            ended = events(tmp_path / f"run{number}", "ended")[0]["time"]
            waited.append(time.time() - _seconds(ended))
    assert waited[0] < LAST_SPANS_SECONDS + 1
    assert waited[1] < 1, "it is known to be away by then"
    told = [record for record in caplog.records if "does not take spans" in record.getMessage()]
    assert len(told) == 1


def _seconds(time_of_event: str) -> float:
    from datetime import datetime

    return datetime.fromisoformat(time_of_event).timestamp()


@pytest.mark.parametrize(
    ("missing", "variables", "says"),
    [
        (True, {}, "is set, but no spans are sent, since OpenTelemetry is not installed"),
        (
            False,
            {"OTEL_BSP_MAX_EXPORT_BATCH_SIZE": "999999"},
            "Correct the variables that begin with OTEL_.",
        ),
    ],
    ids=["missing", "variable"],
)
def test_what_keeps_spans_from_being_sent_is_told_once_and_stops_nothing(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    missing: bool,
    variables: dict[str, str],
    says: str,
) -> None:
    if missing:
        monkeypatch.setitem(sys.modules, "folding_client.exports.span_sending", None)
    monkeypatch.setenv("OTEL_EXPORTER_OTLP_ENDPOINT", f"http://127.0.0.1:{free_port()}")
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    model = script(tmp_path, [save_call(1)], [save_call(2)])
    with caplog.at_level(logging.WARNING):
        for number in (1, 2):
            assert run(2, tmp_path / f"run{number}", model=model).status == "complete"
    assert len([record for record in caplog.records if says in record.getMessage()]) == 1


def test_without_a_collector_nothing_of_opentelemetry_is_loaded_and_no_thread_begins(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("OTEL_EXPORTER_OTLP_ENDPOINT", raising=False)
    threads = threading.active_count()
    assert span_listeners({}, ()) == ()
    assert threading.active_count() == threads
