"""HTTP requests that no host should send, for ``benchmarks/fuzz.py``: messages under odd headers, cut, too large, to odd places."""

import random
from base64 import b64encode
from collections.abc import Callable
from dataclasses import dataclass

from hostile_messages import Message
from hostile_values import TEXTS
from mcp.types import LATEST_PROTOCOL_VERSION

PATH = "/mcp"
TOO_LARGE = 5_000_000
"""Bytes of a body over the SDK's limit, 4 MiB."""
LONG_HEADER = 70_000
"""Bytes of a header over uvicorn's limit, 64 KiB."""
ODD_SHARE = 0.3
"""How many messages travel in a request that is itself not as it should be."""

Headers = list[tuple[str, str]]


@dataclass(frozen=True)
class HttpRequest:
    """The bytes of a request. After ``cut`` ones the sender goes away, without waiting for an answer."""

    kind: str
    data: bytes
    cut: bool = False


def hostile_request(rng: random.Random, host: str, message: Message, token: str, legacy: bool) -> HttpRequest:
    """A message as a request, now and then one that is odd itself; with ``legacy`` as hosts of earlier protocols send it."""
    headers = _headers(host, message, token, legacy)
    if rng.random() > ODD_SHARE:
        return HttpRequest(message.kind, _post(headers, message.text))
    return rng.choice(_ODD)(rng, headers, message)


def _headers(host: str, message: Message, token: str, legacy: bool) -> Headers:
    headers = [
        ("Host", host),
        ("Connection", "close"),
        ("Content-Type", "application/json"),
        ("Accept", "application/json, text/event-stream"),
        ("Authorization", f"Bearer {token}"),
    ]
    if legacy:
        return headers
    routed = [("Mcp-Method", message.method), ("Mcp-Name", message.name)]
    return [
        *headers,
        ("MCP-Protocol-Version", LATEST_PROTOCOL_VERSION),
        *((n, _carried(v)) for n, v in routed if v),
    ]


def _carried(value: str) -> str:
    """A value as a header carries it: as it is, or in base64 as the protocol has it for what headers cannot hold."""
    if value.isascii() and value.isprintable() and value == value.strip():
        return value
    return f"=?base64?{b64encode(value.encode(errors='surrogatepass')).decode()}?="


def _post(
    headers: Headers, body: bytes, length: int | None = None, start: str = f"POST {PATH} HTTP/1.1"
) -> bytes:
    lines = [start, *(f"{name}: {value}" for name, value in headers)]
    lines.append(f"Content-Length: {len(body) if length is None else length}")
    return _latin("\r\n".join(lines)) + b"\r\n\r\n" + body


def _latin(text: str) -> bytes:
    return text.encode("latin-1", errors="replace")


def _with(headers: Headers, name: str, value: str | None) -> Headers:
    """The headers with one of another value, or without it."""
    kept = [(n, v) for n, v in headers if n != name]
    return kept if value is None else [*kept, (name, value)]


def _other_header(name: str, values: tuple[str | None, ...]) -> Callable[..., HttpRequest]:
    def other(rng: random.Random, headers: Headers, message: Message) -> HttpRequest:
        value = rng.choice([*values, rng.choice(TEXTS).replace("\r\n", " ").replace("\n", " ")])
        return HttpRequest(f"header {name}", _post(_with(headers, name, value), message.text))

    return other


def _twice(rng: random.Random, headers: Headers, message: Message) -> HttpRequest:
    return HttpRequest("header twice", _post([*headers, rng.choice(headers)], message.text))


def _long_header(_rng: random.Random, headers: Headers, message: Message) -> HttpRequest:
    return HttpRequest("long header", _post([*headers, ("X-Long", "x" * LONG_HEADER)], message.text))


def _cut_short(rng: random.Random, headers: Headers, message: Message) -> HttpRequest:
    whole = _post(headers, message.text)
    return HttpRequest("cut", whole[: rng.randrange(1, max(len(whole), 2))], cut=True)


def _too_few(rng: random.Random, headers: Headers, message: Message) -> HttpRequest:
    length = rng.randrange(len(message.text) + 1)
    return HttpRequest("short length", _post(headers, message.text, length))


def _too_many(rng: random.Random, headers: Headers, message: Message) -> HttpRequest:
    return HttpRequest(
        "long length", _post(headers, message.text, len(message.text) + rng.randrange(1, 10**6)), cut=True
    )


def _odd_length(rng: random.Random, headers: Headers, message: Message) -> HttpRequest:
    lengths = ("-1", "1e3", "99999999999999999999", "0x10", "", "1, 2")
    odd = [*headers, ("Content-Length", rng.choice(lengths))]
    head = _latin("\r\n".join([f"POST {PATH} HTTP/1.1", *(f"{name}: {value}" for name, value in odd)]))
    return HttpRequest("odd length", head + b"\r\n\r\n" + message.text, cut=True)


def _chunked(rng: random.Random, headers: Headers, message: Message) -> HttpRequest:
    size = rng.choice([f"{len(message.text):x}", "zz", "-1", "ffffffffffffffff", ""])
    head = _latin("\r\n".join([f"POST {PATH} HTTP/1.1", *(f"{n}: {v}" for n, v in headers)]))
    body = _latin(size) + b"\r\n" + message.text + b"\r\n0\r\n\r\n"
    return HttpRequest("chunked", head + b"\r\nTransfer-Encoding: chunked\r\n\r\n" + body, cut=True)


def _odd_start(rng: random.Random, headers: Headers, message: Message) -> HttpRequest:
    method = rng.choice(["GET", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "BREW", "post", "POST"])
    paths = (
        "/",
        "/mcp/",
        "//mcp",
        "/mcp/..",
        "/../etc/passwd",
        "/mcp?x=1",
        "/health",
        "/mcp%00",
        "/.well-known/x",
        "*",
    )
    protocol = rng.choice(["HTTP/1.1", "HTTP/1.1", "HTTP/1.0", "HTTP/9.9", "FTP"])
    start = f"{method} {rng.choice(paths)} {protocol}"
    return HttpRequest("start line", _post(headers, message.text, start=start))


def _noise(rng: random.Random, _headers: Headers, _message: Message) -> HttpRequest:
    return HttpRequest("noise", rng.randbytes(rng.randrange(1, 3000)), cut=True)


def _large(rng: random.Random, headers: Headers, message: Message) -> HttpRequest:
    if rng.random() < 0.9:  # few of them: each travels
        return _too_few(rng, headers, message)
    return HttpRequest("too large", _post(headers, b'"' + b"x" * TOO_LARGE + b'"'), cut=True)


_ODD: tuple[Callable[[random.Random, Headers, Message], HttpRequest], ...] = (
    _other_header(
        "Content-Type", (None, "text/plain", "application/json; charset=utf-16", "multipart/form-data")
    ),
    _other_header("Accept", (None, "text/html", "*/*", "application/json", "text/event-stream")),
    _other_header("MCP-Protocol-Version", (None, "2025-06-18", "2024-11-05", "1.0", "2099-01-01")),
    _other_header("Mcp-Method", (None, "tools/list", "=?base64?!?=")),
    _other_header("Mcp-Name", (None, "fold", "=?base64?!?=", "=?base64?/////w==?=")),
    _other_header("Mcp-Session-Id", ("0" * 32, "x" * 1000)),
    _other_header("Host", (None, "example.org", "127.0.0.1.example.org")),
    _other_header("Origin", ("http://example.org", "null", "file://")),
    _other_header(
        "Authorization", (None, "Bearer", "Bearer wrong-token-of-nobody", "Basic YTpi", "bearer \xe9")
    ),
    _other_header("Content-Encoding", ("gzip", "br")),
    _other_header("Expect", ("100-continue", "nothing")),
    _other_header("Upgrade", ("websocket", "h2c")),
    _other_header("Last-Event-ID", ("1", "../1")),
    _other_header("X-Forwarded-For", ("127.0.0.1",)),
    _twice,
    _long_header,
    _cut_short,
    _too_few,
    _too_many,
    _odd_length,
    _chunked,
    _odd_start,
    _noise,
    _large,
)
