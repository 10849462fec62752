"""Under which names the server may be called: Host and Origin headers, and what a browser is told of them.

A web page can have its own name resolve to this machine and so reach a local server (DNS rebinding); its requests
then carry the page's name as Host, and as Origin.
"""

import logging
import re
from collections.abc import Sequence
from dataclasses import dataclass

from mcp.server.transport_security import TransportSecuritySettings
from mcp.types import INVALID_REQUEST
from starlette.datastructures import Headers
from starlette.middleware.cors import CORSMiddleware
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Receive, Scope, Send

LOCAL_NAMES = ("127.0.0.1", "localhost", "[::1]")
METHODS = ("GET", "POST", "DELETE")
"""The methods of Streamable HTTP; GET and DELETE are of protocol versions with sessions."""
READABLE = ("Mcp-Session-Id", "WWW-Authenticate")
"""The headers of an answer that a page's script may read."""
MOST_LOGGED = 20
"""Refused names that are logged; later ones are refused in silence, so that nobody fills the log."""
LONGEST_LOGGED = 80
"""Characters of a refused name that are logged."""

_logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class AcceptedNames:
    """The host names that requests may carry, with any port, as URLs write them."""

    names: tuple[str, ...]

    @classmethod
    def of(cls, host: str, known_as: Sequence[str] = ()) -> "AcceptedNames":
        """The local names, that of the address served on, and those given."""
        return cls(tuple(dict.fromkeys([*LOCAL_NAMES, host, *known_as])))

    @property
    def host_pattern(self) -> str:
        """A regular expression for the accepted Host headers."""
        return rf"(?:{'|'.join(map(re.escape, self.names))})(?::\d+)?"

    @property
    def origin_pattern(self) -> str:
        """A regular expression for the accepted Origin headers."""
        return rf"https?://{self.host_pattern}"

    def settings(self) -> TransportSecuritySettings:
        """The same as the SDK writes it, whose own check stays on."""
        hosts = [form for name in self.names for form in (name, f"{name}:*")]
        return TransportSecuritySettings(
            allowed_hosts=hosts,
            allowed_origins=[f"{scheme}://{form}" for scheme in ("http", "https") for form in hosts],
        )


class NameCheck:
    """Refuses requests under other names, and logs each such name once with what to do about it.

    Requests for ``exempt`` paths pass, so that whatever watches the process may call it by any name.
    """

    def __init__(self, app: ASGIApp, accepted: AcceptedNames, exempt: Sequence[str] = ()) -> None:
        self._app = app
        self._host = re.compile(accepted.host_pattern)
        self._origin = re.compile(accepted.origin_pattern)
        self._exempt = frozenset(exempt)
        self._logged: set[str] = set()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer it 421 for its Host or 403 for its Origin."""
        refusal = None
        if scope["type"] == "http" and scope["path"] not in self._exempt:
            refusal = self._refusal(Headers(scope=scope))
        await (refusal or self._app)(scope, receive, send)

    def _refusal(self, headers: Headers) -> JSONResponse | None:
        host, origin = headers.get("host", ""), headers.get("origin")
        if not self._host.fullmatch(host):
            self._log("host", host, host)
            return _refused(421, "The server is not known by the name in the Host header; see its log.")
        if origin is not None and not self._origin.fullmatch(origin):
            self._log("web origin", origin, origin.partition("://")[2])
            return _refused(403, "Pages of this Origin may not use the server; see its log.")
        return None

    def _log(self, what: str, refused: str, place: str) -> None:
        name = place if place.endswith("]") else re.sub(r":\d*$", "", place)
        if name in self._logged or len(self._logged) == MOST_LOGGED:
            return
        self._logged.add(name)
        _logger.warning(
            "Refused requests for the %s %r; if they are meant, start the server with --known-as %s.",
            what,
            refused[:LONGEST_LOGGED],
            name[:LONGEST_LOGGED] or "NAME",
        )


def _refused(status: int, sentence: str) -> JSONResponse:
    """A refusal that clients of the protocol pass on to their user: a JSON-RPC error."""
    error = {"code": INVALID_REQUEST, "message": sentence}
    return JSONResponse({"jsonrpc": "2.0", "id": None, "error": error}, status)


def guarded(app: ASGIApp, accepted: AcceptedNames, exempt: Sequence[str] = ()) -> ASGIApp:
    """An application that answers under accepted names alone, and lets pages of accepted origins call it."""
    shared = CORSMiddleware(
        app,
        allow_origin_regex=accepted.origin_pattern,
        allow_methods=METHODS,
        allow_headers=("*",),
        expose_headers=READABLE,
    )
    return NameCheck(shared, accepted, exempt)
