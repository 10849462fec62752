"""What is wrong with an answer to a hostile call, for ``benchmarks/fuzz.py``: one sentence, or nothing."""

import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

INTERNAL_ERROR = -32603
"""What a server answers for a fault of its own."""
UNTYPED = (
    "Traceback",
    "Error executing",
    "Internal server error",
    "object at 0x",
    "site-packages",
    "sqlalchemy",
    "sqlite3",
)
"""What no answer may say: it would be the server's own business."""
STATUSES = frozenset({200, 202, 204, 307, 400, 401, 403, 404, 405, 406, 411, 413, 415, 421, 431})
CONTINUE = b"HTTP/1.1 100 Continue\r\n\r\n"
"""What comes before the answer where the request asks for it."""
_SHOWN = 300

Place = Iterable[str]


def http_fault(data: bytes, places: Place) -> str | None:
    """What is wrong with an HTTP answer as it came, if anything; ``places`` are paths of the machine."""
    head, _, body = data.removeprefix(CONTINUE).partition(b"\r\n\r\n")
    found = re.match(rb"HTTP/1\.1 (\d{3})", head)
    if not found:
        return f"no answer of HTTP: {data[:_SHOWN]!r}"
    status = int(found.group(1))
    if status not in STATUSES:
        return f"status {status}: {body[:_SHOWN]!r}"
    if shown := _shows(data, places):
        return f"shows {shown}: {body[:_SHOWN]!r}"
    if b"transfer-encoding: chunked" in head.lower():
        body = _without_chunks(body)
    if b"text/event-stream" in head.lower():
        texts = re.findall(rb"^data: ?(\{.*)\r?$", body, re.MULTILINE)
    else:
        texts = [body] if b"application/json" in head.lower() else []
    return next((fault for text in texts if (fault := _message_fault(text))), None)


def line_fault(line: str, places: Place) -> str | None:
    """What is wrong with a line that a server wrote over stdio, if anything."""
    if shown := _shows(line.encode(errors="surrogatepass"), places):
        return f"shows {shown}: {line[:_SHOWN]!r}"
    return _message_fault(line.encode(errors="surrogatepass"))


def _shows(data: bytes, places: Place) -> str | None:
    """What an answer says that it may not."""
    return next((word for word in (*UNTYPED, *places) if word.encode() in data), None)


def _without_chunks(body: bytes) -> bytes:
    parts, rest = [], body
    while rest:
        size, _, rest = rest.partition(b"\r\n")
        length = int(size or b"0", 16)
        parts.append(rest[:length])
        rest = rest[length + 2 :]
    return b"".join(parts)


def _message_fault(text: bytes) -> str | None:
    try:
        message = json.loads(text.decode(), parse_constant=_no_number)
    except ValueError as error:
        return f"no JSON ({error}): {text[:_SHOWN]!r}"
    if not isinstance(message, dict):
        return f"no message: {text[:_SHOWN]!r}"
    if "error" in message:
        return _error_fault(message["error"])
    return _result_fault(message.get("result"))


def _no_number(name: str) -> float:
    message = f"{name} is no JSON"
    raise ValueError(message)


def _error_fault(error: object) -> str | None:
    """An error of the protocol has a code and a message; the refusals of HTTP's own layer have a name."""
    match error:
        case {"code": int(code), "message": str()} if code != INTERNAL_ERROR:
            return None
        case str():
            return None
        case _:
            return f"an error that is not typed: {error!r:.300}"


def _result_fault(result: object) -> str | None:
    """A refusal of a tool is one sentence."""
    match result:
        case {"isError": True, "content": [{"type": "text", "text": str(text)}]}:
            return _sentence_fault(text)
        case {"isError": True}:
            return f"a refusal that is no sentence: {result!r:.300}"
        case _:
            return None


def _sentence_fault(text: str) -> str | None:
    if "\n" in text or not text.endswith((".", "!", "?")) or len(text) > 2000:
        return f"a refusal that is no sentence: {text[:_SHOWN]!r}"
    return None


def told(fault: str | None, what: Mapping[str, Any]) -> list[str]:
    """A fault with what was asked, as a list of one; an empty list where there is none."""
    return [] if fault is None else [f"{fault} <- {json.dumps(what)[:_SHOWN]}"]
