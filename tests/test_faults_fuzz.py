"""Malformed and hostile calls over the protocol; ``benchmarks/fuzz.py`` sends as many as one likes."""

import json

import pytest
from fuzz import fuzz
from fuzz_verdicts import http_fault, line_fault

PLACES = ("/srv/data",)


@pytest.mark.slow
def test_hostile_calls_are_answered_by_typed_errors() -> None:
    reports = fuzz(calls=300, seed=1)
    assert [fault for report in reports.values() for fault in report["faults"]] == []
    assert sum(report["calls"] for report in reports.values()) == 300
    assert all(len(report["kinds"]) > 5 for report in reports.values())


def answer(status: int, body: object, kind: str = "application/json") -> bytes:
    text = body if isinstance(body, str) else json.dumps(body)
    return f"HTTP/1.1 {status} Whatever\r\ncontent-type: {kind}\r\n\r\n{text}".encode()


def refusal(text: str) -> dict[str, object]:
    return {
        "jsonrpc": "2.0",
        "id": 1,
        "result": {"isError": True, "content": [{"type": "text", "text": text}]},
    }


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "no answer"),
        (answer(500, "Internal Server Error", "text/plain"), "status 500"),
        (answer(200, {"jsonrpc": "2.0", "id": 1, "error": {"code": -32603, "message": "Oh."}}), "not typed"),
        (answer(200, {"jsonrpc": "2.0", "id": 1, "error": {"message": "Oh."}}), "not typed"),
        (answer(200, refusal("Error executing tool fold")), "shows Error executing"),
        (answer(200, refusal("It is at /srv/data/photos.")), "shows /srv/data"),
        (answer(200, refusal("2 validation errors\nfield required")), "no sentence"),
        (answer(200, '{"jsonrpc": "2.0", "id": 1, "result": {"x": NaN}}'), "no JSON"),
        (answer(200, "[1"), "no JSON"),
        (
            answer(200, f"event: message\r\ndata: {json.dumps(refusal('no stop'))}\r\n", "text/event-stream"),
            "no sentence",
        ),
    ],
)
def test_an_answer_that_is_not_typed_would_be_noticed(data: bytes, said: str) -> None:
    fault = http_fault(data, PLACES)
    assert fault is not None
    assert said in fault


@pytest.mark.parametrize(
    "data",
    [
        answer(200, refusal("There is no vertex 9; the vertices are 1 to 4.")),
        answer(400, {"jsonrpc": "2.0", "id": None, "error": {"code": -32700, "message": "Parse error"}}),
        answer(404, "Not Found", "text/plain"),
        answer(200, {"jsonrpc": "2.0", "id": 1, "result": {"tools": []}}),
    ],
)
def test_typed_errors_and_answers_pass(data: bytes) -> None:
    assert http_fault(data, PLACES) is None


def test_lines_are_judged_like_bodies() -> None:
    assert line_fault(json.dumps(refusal("There is no run 'x'.")), PLACES) is None
    assert line_fault("Traceback (most recent call last):", PLACES) is not None
    assert line_fault("something printed", PLACES) is not None
