"""Recorded runs in other people's formats, read back by their own programs."""

import gzip
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from client_runs import MATCH, PLANTED_KEY, act, ask, run, save, sequence
from inspect_ai.log import EvalLog, read_eval_log
from opentelemetry.proto.collector.trace.v1.trace_service_pb2 import ExportTraceServiceRequest
from providers.openai import OpenAI
from test_client_commands import command

TURN = {"action": "rotate", "angle": 45.0}
MODEL = "litellm/openai/gpt-4o"


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A complete run with a critic, and one that a limit stopped."""
    home = tmp_path_factory.mktemp("runs")
    with OpenAI(save(1), act(TURN), ask(2, "rotate"), MATCH, save(2)) as provider:
        assert run(2, home / "whole" / "plain2", model=MODEL, api_base=provider.url).status == "complete"
    with OpenAI(save(1), act(TURN)) as provider:
        stopped = run(3, home / "whole" / "plain3", model=MODEL, api_base=provider.url, max_queries=2)
        assert stopped.status == "stopped"
    return home


@pytest.mark.parametrize("kind", ["eval", "json"])
def test_inspect_reads_the_log_of_a_condition_with_messages_calls_and_scores(
    tmp_path: Path, runs: Path, kind: str
) -> None:
    done = command("export-logs", runs, "-o", tmp_path / "logs", "--format", kind)
    assert done.returncode == 0, done.stderr
    (file,) = (tmp_path / "logs").iterdir()
    assert done.stdout.strip() == str(file)
    assert file.name == f"litellm-openai-gpt-4o.{kind}"
    log: EvalLog = read_eval_log(str(file))
    assert (log.status, log.eval.model) == ("success", MODEL)
    assert log.results is not None
    assert (log.results.total_samples, log.results.completed_samples) == (2, 1)
    assert log.samples is not None
    whole, stopped = log.samples
    assert (whole.id, stopped.id) == (sequence(2).name, sequence(3).name)
    assert whole.scores is not None and whole.scores["saved"].value == 1
    assert stopped.scores is not None and stopped.scores["saved"].as_float() == pytest.approx(1 / 3)
    assert "limit of 2 queries" in stopped.metadata["reason"]


@pytest.fixture(scope="module")
def sample(runs: Path, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The sample of the complete run."""
    logs = tmp_path_factory.mktemp("logs")
    assert command("export-logs", runs, "-o", logs).returncode == 0
    (file,) = logs.iterdir()
    samples = read_eval_log(str(file), resolve_attachments=True).samples
    assert samples is not None
    return samples[0]


def test_a_transcript_has_every_step_s_opening_replies_and_results_with_pictures(sample: Any) -> None:
    roles = [message.role for message in sample.messages]
    assert roles[0] == "system"
    assert roles.count("system") == 2, "each step begins anew"
    called = [
        call.function for message in sample.messages for call in getattr(message, "tool_calls", None) or []
    ]
    assert called == ["save_checkpoint", "rotate", "ask_critic", "save_checkpoint"]
    answered = [message.function for message in sample.messages if message.role == "tool"]
    assert answered == called
    pictures = [
        part.image
        for message in sample.messages
        if isinstance(message.content, list)
        for part in message.content
        if part.type == "image"
    ]
    assert pictures and all(picture.startswith("data:image/") for picture in pictures)


def test_its_events_are_the_queries_of_every_role_and_the_calls_of_tools(sample: Any) -> None:
    models = [event for event in sample.events if event.event == "model"]
    assert [event.role for event in models] == ["agent", "agent", "agent", "critic", "agent"]
    assert models[0].output.usage.input_tokens > 0
    tools = [event.function for event in sample.events if event.event == "tool" and event.agent == "agent"]
    assert tools == ["save_checkpoint", "rotate", "save_checkpoint"]


def test_pictures_can_be_left_out(tmp_path: Path, runs: Path) -> None:
    assert (
        command("export-logs", runs, "-o", tmp_path / "without", "--no-images", "--format", "json").returncode
        == 0
    )
    (file,) = (tmp_path / "without").iterdir()
    assert "data:image/" not in file.read_text()


class Collector(ThreadingHTTPServer):
    """An OTLP collector over HTTP that keeps what it is sent."""

    def __init__(self, status: int = 200) -> None:
        super().__init__(("127.0.0.1", 0), _Takes)
        self.status = status
        self.requests: list[ExportTraceServiceRequest] = []

    @property
    def spans(self) -> list[Any]:
        """All spans that came."""
        return [
            span
            for request in self.requests
            for of_resource in request.resource_spans
            for of_scope in of_resource.scope_spans
            for span in of_scope.spans
        ]


class _Takes(BaseHTTPRequestHandler):
    server: Collector

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["Content-Length"]))
        if self.headers.get("Content-Encoding") == "gzip":
            body = gzip.decompress(body)
        assert self.path == "/v1/traces"
        self.server.requests.append(ExportTraceServiceRequest.FromString(body))
        self.send_response(self.server.status)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *_: object) -> None:
        """Nothing."""


@contextmanager
def collector(monkeypatch: pytest.MonkeyPatch, status: int = 200) -> Iterator[Collector]:
    server = Collector(status)
    threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
    monkeypatch.setenv("OTEL_EXPORTER_OTLP_ENDPOINT", f"http://127.0.0.1:{server.server_port}")
    try:
        yield server
    finally:
        server.shutdown()
        server.server_close()


def attributes(span: Any) -> dict[str, Any]:
    """A span's attributes by name."""
    return {each.key: getattr(each.value, each.value.WhichOneof("value")) for each in span.attributes}


def test_a_collector_gets_the_run_as_nested_spans_with_tokens(
    runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with collector(monkeypatch) as kept:
        done = command("export-logs", runs / "whole" / "plain2", "--spans")
        first = kept.spans
        again = command("export-logs", runs / "whole" / "plain2", "--spans")
    assert (done.returncode, again.returncode) == (0, 0)
    assert done.stdout == f"{len(first)} spans sent.\n"
    by_id = {span.span_id: span for span in first}
    (root,) = [span for span in first if not span.parent_span_id]
    assert root.name == "invoke_agent foldingagent"
    chats = [span for span in first if attributes(span)["gen_ai.operation.name"] == "chat"]
    parents = [by_id[span.parent_span_id].name for span in chats]
    agent = "invoke_agent foldingagent"
    assert parents == [agent, agent, agent, "invoke_agent critic", agent]
    said = attributes(chats[0])
    assert (said["gen_ai.provider.name"], said["gen_ai.request.model"]) == ("openai", MODEL)
    tokens = sum(attributes(span)["gen_ai.usage.input_tokens"] for span in chats)
    assert attributes(root)["gen_ai.usage.input_tokens"] == tokens > 0
    tools = [span for span in first if span.name.startswith("execute_tool ")]
    assert {"execute_tool rotate", "execute_tool critic_grid"} <= {span.name for span in tools}
    assert all(by_id[span.parent_span_id] is root for span in tools)
    assert all(
        root.start_time_unix_nano
        <= span.start_time_unix_nano
        <= span.end_time_unix_nano
        <= root.end_time_unix_nano
        for span in first
    )
    ids = [(span.trace_id, span.span_id) for span in first]
    assert [(span.trace_id, span.span_id) for span in kept.spans[len(first) :]] == ids, "the same trace again"


def test_a_run_that_was_stopped_is_a_span_in_error(runs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with collector(monkeypatch) as kept:
        assert command("export-logs", runs / "whole" / "plain3", "--spans").returncode == 0
    (root,) = [span for span in kept.spans if not span.parent_span_id]
    assert root.status.code == 2
    assert "limit of 2 queries" in root.status.message


def test_a_collector_that_refuses_is_one_sentence(runs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with collector(monkeypatch, status=400):
        refused = command("export-logs", runs / "whole" / "plain3", "--spans")
    assert refused.returncode == 2
    assert refused.stderr.strip().splitlines()[-1].startswith("The collector did not take the spans of")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--spans"], "No collector is named; set OTEL_EXPORTER_OTLP_ENDPOINT"),
        ([], "Name a folder for the logs with -o, or give --spans."),
    ],
)
def test_what_is_missing_is_named(
    runs: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], says: str
) -> None:
    monkeypatch.delenv("OTEL_EXPORTER_OTLP_ENDPOINT", raising=False)
    refused = command("export-logs", runs, *words)
    assert refused.returncode == 2
    assert says in refused.stderr
    assert refused.stderr.count("\n") == 1


def test_a_folder_without_runs_is_refused(tmp_path: Path) -> None:
    refused = command("export-logs", tmp_path, "-o", tmp_path / "logs")
    assert refused.returncode == 2
    assert "holds no recorded run" in refused.stderr


@pytest.mark.parametrize(
    ("package", "words", "extra"),
    [
        ("inspect_ai", ["-o", "logs"], "logs"),
        ("opentelemetry.exporter.otlp.proto.http.trace_exporter", ["--spans"], "telemetry"),
    ],
)
def test_without_its_package_an_export_names_the_extra(
    tmp_path: Path, runs: Path, package: str, words: list[str], extra: str
) -> None:
    """In a process of its own, since modules that are loaded stay loaded."""
    script = (
        f"import sys; sys.modules[{package!r}] = None; from folding_client.cli import main; "
        f"main(['export-logs', {str(runs)!r}, *{words!r}])"
    )
    environment = {**os.environ, "OTEL_EXPORTER_OTLP_ENDPOINT": "http://127.0.0.1:9"}
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env=environment,
    )
    assert done.returncode == 2
    assert f"pip install 'foldingagent-mcp[{extra}]'" in done.stderr
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_no_key_is_in_a_log(tmp_path: Path, runs: Path) -> None:
    assert command("export-logs", runs, "-o", tmp_path, "--format", "json").returncode == 0
    assert PLANTED_KEY not in next(tmp_path.iterdir()).read_text()
