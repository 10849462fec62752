"""A provider on a local port: it answers each request with the next turn of its script, and checks what it is
sent.
"""

import contextlib
import json
import socket
import struct
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Any, Self

Body = dict[str, Any]


@dataclass(frozen=True)
class Says:
    """A reply of the model: text, tool calls as (name, arguments), thinking; ``finish`` in the provider's
    words.

    ``silent`` leaves out the reply altogether (OpenAI), ``meanwhile`` is done before it is sent.
    """

    text: str = ""
    calls: Sequence[tuple[str, Body | str]] = ()
    thinking: str = ""
    finish: str | None = None
    cached: int = 0
    silent: bool = False
    meanwhile: Callable[[], object] = lambda: None


@dataclass(frozen=True)
class Fails:
    """An HTTP error; ``code`` is the provider's own word for it, where it has one."""

    status: int
    message: str = "an error of the provider"
    code: str | None = None
    headers: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Resets:
    """The connection is reset before anything is answered."""


@dataclass(frozen=True)
class Truncates:
    """The answer stops in the middle of its JSON."""


@dataclass(frozen=True)
class Hangs:
    """Nothing is answered for a while."""

    seconds: float


Turn = Says | Fails | Resets | Truncates | Hangs


class Provider:
    """A context manager. ``received`` holds the requests' bodies, ``problems`` what was wrong with them."""

    def __init__(self, *turns: Turn) -> None:
        self.turns = list(turns)
        self.received: list[Body] = []
        self.headers: list[dict[str, str]] = []
        self.times: list[float] = []
        self.problems: list[str] = []
        self._lock = threading.Lock()
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), _handler_for(self))
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.02,), daemon=True)

    @property
    def url(self) -> str:
        """The address to give as ``api_base``."""
        return f"http://127.0.0.1:{self._server.server_address[1]}"

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
        if kind is None:
            assert not self.problems, self.problems

    def next_turn(self, path: str, body: Body, headers: dict[str, str]) -> Turn:
        """The turn for a request, which is checked and kept. A request that the provider would refuse is refused,
        and a problem; so is one beyond the script.
        """
        with self._lock:
            self.received.append(body)
            self.headers.append(headers)
            self.times.append(time.monotonic())
            try:
                self.check(path, body)
            except (AssertionError, KeyError, TypeError, ValueError) as error:
                self.problems.append(f"request {len(self.received)}: {type(error).__name__}: {error}")
                return Fails(400, str(error))
            if not self.turns:
                self.problems.append(f"request {len(self.received)} goes beyond the script")
                return Fails(400, "the script is over")
            return self.turns.pop(0)

    def check(self, path: str, body: Body) -> None:
        """Raise AssertionError if the request is not what the provider's documentation asks for."""
        raise NotImplementedError

    def answer(self, turn: Says, number: int) -> Body:
        """The provider's JSON for a reply."""
        raise NotImplementedError

    def encoded(self, path: str, body: Body, answer: Body) -> tuple[str, bytes]:  # noqa: ARG002 - decide elsewhere
        """The type and bytes of the answer to a request: JSON, unless the provider can stream and is asked to."""
        return "application/json", json.dumps(answer).encode()

    def error(self, turn: Fails) -> Body:
        """The provider's JSON for an error."""
        return {"error": {"message": turn.message, "type": "error", "code": turn.code or str(turn.status)}}


def _handler_for(provider: Provider) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = json.loads(self.rfile.read(int(self.headers["content-length"])))
            turn = provider.next_turn(self.path, body, {k.lower(): v for k, v in self.headers.items()})
            match turn:
                case Says():
                    turn.meanwhile()
                    answer = provider.answer(turn, len(provider.received))
                    self._send_data(200, *provider.encoded(self.path, body, answer))
                case Fails():
                    self._send(turn.status, provider.error(turn), turn.headers)
                case Truncates():
                    self._send(200, provider.answer(Says("cut off"), 0), cut=20)
                case Resets():
                    self._reset()
                case Hangs():
                    time.sleep(turn.seconds)
                    self.close_connection = True

        def _send(
            self, status: int, body: Body, headers: Mapping[str, str] | None = None, cut: int = 0
        ) -> None:
            data = json.dumps(body).encode()
            self._send_data(status, "application/json", data[: len(data) - cut], headers)

        def _send_data(
            self, status: int, kind: str, data: bytes, headers: Mapping[str, str] | None = None
        ) -> None:
            self.send_response(status)
            for name, value in {"content-type": kind, **(headers or {})}.items():
                self.send_header(name, value)
            self.send_header("content-length", str(len(data)))
            self.end_headers()
            self.wfile.write(data)

        def _reset(self) -> None:
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            self.close_connection = True
            self.connection.close()

        def finish(self) -> None:
            with contextlib.suppress(OSError, ValueError):
                super().finish()

        def log_message(self, *_: object) -> None:
            pass

    return Handler
