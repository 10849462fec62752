"""What a server tells its hosts unasked: that a run they watch has changed, and what calls came to, as log messages.

Hosts of the protocol of 2026-07-28 say with each request what they want to hear, and the SDK keeps to it. Earlier ones
say it once for their connection, with ``resources/subscribe`` and ``logging/setLevel``; that is kept here. A change is
told by the process that made it.
"""

import warnings
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, get_args
from weakref import WeakKeyDictionary

import anyio.to_thread
from mcp.server.connection import Connection, allowed_log_levels
from mcp.server.context import ServerRequestContext
from mcp.server.subscriptions import InMemorySubscriptionBus, ListenHandler, ServerEvent
from mcp.shared.exceptions import MCPError
from mcp.types import (
    INVALID_PARAMS,
    EmptyResult,
    LoggingLevel,
    SetLevelRequestParams,
    SubscribeRequestParams,
    SubscriptionsListenRequestParams,
    SubscriptionsListenResult,
    UnsubscribeRequestParams,
)

from folding_server.errors import FoldingError
from folding_server.mcp import errors
from folding_server.mcp.services.run_addresses import run_of

if TYPE_CHECKING:
    from mcp.server.lowlevel.server import Server
    from mcp.server.mcpserver import Context

    from folding_server.mcp.context import AppContext

LOG_LEVELS: tuple[LoggingLevel, ...] = get_args(LoggingLevel)
"""From the least important to the most."""
FIRST_MODERN = "2026-07-28"
"""The version of the protocol from which requests say for themselves what log messages they want."""

MOST_WATCHED = 1000
"""How many addresses one connection may watch: those of some eighty runs, so that no host fills the server's memory."""
LONGEST_WATCHED = 4000
"""Characters of the longest address that may be watched: the longest name of a sequence, encoded, takes 2,400."""

_Request = ServerRequestContext[Any, Any]


class ListenerBus(InMemorySubscriptionBus):
    """The SDK's bus of updates for hosts of today, which costs nothing while none listens.

    The SDK's own gives way to other tasks at each publication, and a change of a run is nine of them.
    """

    def __init__(self) -> None:
        super().__init__()
        self._listening = 0

    @property
    def listened(self) -> bool:
        """Whether anyone listens."""
        return self._listening > 0

    async def publish(self, event: ServerEvent) -> None:
        """Tell those who listen."""
        if self.listened:
            await super().publish(event)

    def subscribe(self, listener: Callable[[ServerEvent], None]) -> Callable[[], None]:
        """Tell a listener from now on, until what is returned is called, once or more often."""
        end = super().subscribe(listener)
        self._listening += 1
        ended = False

        def unsubscribe() -> None:
            nonlocal ended
            end()
            self._listening -= not ended
            ended = True

        return unsubscribe


class Subscriptions:
    """What each connection wants to hear. It is forgotten with the connection.

    An owner of tokens may watch the runs of their own alone; whoever calls without a token may watch all.
    """

    def __init__(self, app: "AppContext", bus: ListenerBus) -> None:
        self._app = app
        self._bus = bus
        self._listen = ListenHandler(bus)
        self._watched: WeakKeyDictionary[Connection, set[str]] = WeakKeyDictionary()
        self._levels: WeakKeyDictionary[Connection, LoggingLevel] = WeakKeyDictionary()

    def register(self, server: "Server[AppContext]") -> None:
        """Have the server answer the four requests."""
        listen = "subscriptions/listen"
        server.add_request_handler(listen, SubscriptionsListenRequestParams, self._checked_listen)
        server.add_request_handler("resources/subscribe", SubscribeRequestParams, self._subscribe)
        server.add_request_handler("resources/unsubscribe", UnsubscribeRequestParams, self._unsubscribe)
        server.add_request_handler("logging/setLevel", SetLevelRequestParams, self._set_level)

    @property
    def heard(self) -> bool:
        """Whether anyone may want to hear of changes."""
        return self._bus.listened or bool(self._watched)

    async def changed(self, ctx: "Context[AppContext, Any]", addresses: Iterable[str]) -> None:
        """Tell everyone who watches one of the addresses that it reads otherwise now."""
        watched = list(self._watched.items())
        for uri in addresses:
            await ctx.notify_resource_updated(uri)
            for connection, theirs in watched:
                if uri in theirs:
                    await connection.send_resource_updated(uri)

    async def log(self, request: _Request, level: LoggingLevel, text: str) -> None:
        """Send the host a log message, if it asked for messages of this level."""
        if not self._wanted(request, level):
            return
        with warnings.catch_warnings():
            # The SDK warns of log messages, which the protocol of 2026-07-28 advises against and still has.
            warnings.simplefilter("ignore")
            sending = request.session.send_log_message(
                level, text, logger="folding", related_request_id=request.request_id
            )
        await sending

    def _wanted(self, request: _Request, level: LoggingLevel) -> bool:
        """Whether the host asked for messages of this level: with the request, or earlier for its connection."""
        if request.protocol_version >= FIRST_MODERN:
            return level in allowed_log_levels(request.protocol_version, request.meta)
        least = self._levels.get(_connection(request))
        return least is not None and LOG_LEVELS.index(level) >= LOG_LEVELS.index(least)

    async def _checked_listen(
        self, request: _Request, params: SubscriptionsListenRequestParams
    ) -> SubscriptionsListenResult:
        """What the SDK answers to hosts of 2026-07-28, for addresses that the caller may watch."""
        uris = {str(uri) for uri in params.notifications.resource_subscriptions or ()}
        _check_room(len(uris))
        await self._check_may_watch(uris)
        return await self._listen(request, params)

    async def _subscribe(self, request: _Request, params: SubscribeRequestParams) -> EmptyResult:
        uri = str(params.uri)
        await self._check_may_watch([uri])
        watched = self._watched.setdefault(_connection(request), set())
        _check_room(len(watched | {uri}))
        watched.add(uri)
        return EmptyResult()

    async def _check_may_watch(self, uris: Iterable[str]) -> None:
        """Raise MCPError (invalid params) for an address that is too long, or of a run that is not the caller's."""
        for uri in uris:
            if len(uri) > LONGEST_WATCHED:
                raise MCPError(INVALID_PARAMS, errors.unknown_address(uri))
            if (run_id := run_of(uri)) is not None:
                try:
                    await anyio.to_thread.run_sync(self._app.require_own, run_id)
                except FoldingError as error:
                    raise MCPError(INVALID_PARAMS, errors.sentence(self._app.told(error))) from error

    async def _unsubscribe(self, request: _Request, params: UnsubscribeRequestParams) -> EmptyResult:
        self._watched.get(_connection(request), set()).discard(str(params.uri))
        return EmptyResult()

    async def _set_level(self, request: _Request, params: SetLevelRequestParams) -> EmptyResult:
        self._levels[_connection(request)] = params.level
        return EmptyResult()


def _check_room(watched: int) -> None:
    """Raise MCPError (invalid params) if a connection would watch more addresses than it may."""
    if watched > MOST_WATCHED:
        raise MCPError(
            INVALID_PARAMS,
            f"At most {MOST_WATCHED} addresses can be watched over one connection; end the subscriptions that are not needed.",
        )


def _connection(request: _Request) -> Connection:
    """The connection of a request: the SDK makes a session for each request and shows what they share in no other way."""
    return request.session._connection  # noqa: SLF001
