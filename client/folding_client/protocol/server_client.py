"""The folding server as the client uses it: typed questions, one run, every call on record, one restart."""

import time
from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager
from typing import Any, TextIO, TypeVar
from uuid import uuid4

from folding_schemas.actions import Action
from folding_schemas.results import RunInfo
from folding_schemas.wire import Wire
from pydantic import ValidationError

from folding_client.interrupts import ConnectionLost, ServerGone, ToolRefused, UsageError
from folding_client.messages import JsonObject, Picture, ToolCall, ToolResult, ToolSpec
from folding_client.protocol.connection import Connection, ServerAddress
from folding_client.protocol.requests import Request
from folding_client.record.recorder import Recorder
from folding_client.record.redaction import without_keys

_Answer = TypeVar("_Answer", bound=Wire)

CLIENTS_OWN = frozenset({"run_id", "images"})
"""Arguments that models are not offered: the client names the run, and thins out pictures itself."""


class ServerClient:
    """Calls the tools of a folding server for one run, which every call names.

    A server that dies is started again once and the run goes on from its store; the call that it took with it
    is sent again, with the same request id, under which the server carries it out once. ServerGone if it dies
    twice in a row.
    """

    def __init__(self, address: ServerAddress, recorder: Recorder, log: TextIO) -> None:
        self.run_id: str | None = None
        self._address = address
        self._recorder = recorder
        self._log = log
        self._connection = Connection(address, log)
        self._losses = 0
        self._under_way: Request | None = None

    @property
    def version(self) -> str:
        """The server's version as it states it."""
        return self._connection.server_version

    def specs(self) -> list[ToolSpec]:
        """Every tool of the server as it can be offered to a model: without the arguments that are the client's."""
        return [
            ToolSpec(
                tool.name,
                tool.description or "",
                _offered_schema(tool.input_schema),
                bool(tool.annotations and tool.annotations.read_only_hint),
            )
            for tool in self._connection.tools
        ]

    async def start(self) -> None:
        """Connect. A process that ends while it starts is started once more. ServerGone if the server does not start."""
        try:
            await self._connection.open()
        except ConnectionLost as error:
            if self._address.url is not None:
                message = (
                    f"The folding server cannot be reached at {self._address.url} ({error}); mend that or give another "
                    "--server-url, then resume."
                )
                raise ServerGone(message) from error
            if self._is_lost_again(str(error), None):
                message = f"The folding server does not start ({error}); see server.log in the run folder."
                raise ServerGone(message) from error
            await self._reconnect()
            await self.start()

    def require(self, tools: Iterable[str]) -> None:
        """UsageError, naming them, if the server lacks tools."""
        there = {tool.name for tool in self._connection.tools}
        if missing := [name for name in tools if name not in there]:
            where = self._address.url or "that was started"
            message = (
                f"The folding server at {where} does not offer {', '.join(missing)}, which this run needs; start it with "
                "--tools all and without --read-only, or leave out --server-url."
            )
            raise UsageError(message)

    async def close(self) -> None:
        """Disconnect."""
        await self._connection.close()

    async def open_run(
        self, sequence: str | None, run_id: str | None = None, attempts: int | None = None
    ) -> RunInfo:
        """Open a new run on a sequence, with so many attempts a frame, or an earlier one again."""
        new = {"sequence": sequence} | ({} if attempts is None else {"attempts": attempts})
        arguments = new if run_id is None else {"run_id": run_id}
        info, _ = await self.ask(RunInfo, "open_run", **arguments)
        self.run_id = info.run_id
        return info

    @asynccontextmanager
    async def another_run(self, sequence: str | None) -> AsyncIterator[RunInfo]:
        """Within the context, calls go to a fresh run of a sequence; afterwards to the run at hand again."""
        kept, self.run_id = self.run_id, None
        try:
            yield await self.open_run(sequence)
        finally:
            self.run_id = kept

    async def where(self) -> RunInfo:
        """Where the run stands."""
        return (await self.ask(RunInfo, "get_run"))[0]

    async def return_to(self, frame: int) -> None:
        """Restore a checkpoint for a technical reason, which costs no attempt as long as the server takes it.

        ToolRefused if it is refused.
        """
        result = await self.call("restore_checkpoint", {"frame": frame}, technical=True)
        if result.is_error:
            result = await self.call("restore_checkpoint", {"frame": frame})
        if result.is_error:
            raise ToolRefused(result.text)

    async def act(self, action: Action) -> ToolResult:
        """Carry out a folding action for the client itself."""
        arguments = action.model_dump(mode="json", exclude_none=True, exclude={"action"})
        return await self.call(action.action, arguments)

    async def ask(
        self, kind: type[_Answer], tool: str, **arguments: object
    ) -> tuple[_Answer, tuple[Picture, ...]]:
        """A call of the client's own: its answer as a model, with its pictures. ToolRefused if it is
        refused.
        """
        result = await self.call(tool, arguments)
        if result.is_error:
            raise ToolRefused(result.text)
        try:
            return kind.model_validate(result.data), result.pictures
        except ValidationError as error:
            message = (
                f"The folding server's answer to {tool} is not a {kind.__name__}: {error.errors()[0]['msg']}."
            )
            raise ServerGone(message) from error

    async def call(
        self,
        name: str,
        arguments: Mapping[str, Any],
        by: str = "client",
        call: ToolCall | None = None,
        *,
        technical: bool = False,
    ) -> ToolResult:
        """Call a tool on behalf of the agent or the client. ServerGone if the server died twice in a row."""
        full = without_keys(arguments if self.run_id is None else {**arguments, "run_id": self.run_id})
        request = Request(by, name, full, None if self._only_reads(name) else str(uuid4()), technical)
        self._recorder.call(by, call, name, full, request.id, technical=technical)
        self._under_way = request
        return await self.answer(request)

    async def settle(self) -> None:
        """Have the last call answered if it may have changed the run and whoever made it was cut short."""
        if self._under_way is not None and self._under_way.id is not None:
            await self.answer(self._under_way)

    async def answer(self, request: Request) -> ToolResult:
        """Have a call that is on record answered, and record the result. ServerGone if the server died twice in
        a row.
        """
        started = time.monotonic()
        while True:
            try:
                result = await self._connection.call(request.tool, request.arguments, request.meta)
            except ConnectionLost as loss:
                await self._restart(str(loss), request)
            else:
                self._losses = 0
                self._under_way = None
                self._recorder.result(request.by, request.tool, result, time.monotonic() - started)
                return result

    def _only_reads(self, name: str) -> bool:
        return any(
            tool.name == name and tool.annotations and tool.annotations.read_only_hint
            for tool in self._connection.tools
        )

    async def _restart(self, why: str, request: Request) -> None:
        """Start the server that died on a request again, and open its run, if there is one by now."""
        if self._is_lost_again(why, request.tool):
            message = f"The folding server ended twice in a row ({why}); the run can be resumed."
            raise ServerGone(message)
        await self._reconnect()
        await self.start()
        run_id = request.arguments.get("run_id")
        if run_id is not None:
            await self._reopen(run_id)
        self._recorder.event("server_restarted", call=request.tool)

    def _is_lost_again(self, why: str, tool: str | None) -> bool:
        """Whether the server, which has just died on a call or while it started, has died before without an answer."""
        self._losses += 1
        self._recorder.event("server_lost", reason=why, call=tool, in_a_row=self._losses)
        return self._losses > 1

    async def _reconnect(self) -> None:
        await self._connection.close()
        self._connection = Connection(self._address, self._log)

    async def _reopen(self, run_id: str) -> None:
        try:
            opened = await self._connection.call("open_run", {"run_id": run_id})
        except ConnectionLost as loss:
            message = f"The folding server ended twice in a row ({loss}); the run can be resumed."
            raise ServerGone(message) from loss
        if opened.is_error:
            message = f"The folding server does not know the run any more: {opened.text}"
            raise ServerGone(message)


def _offered_schema(schema: JsonObject) -> JsonObject:
    properties = {key: value for key, value in schema.get("properties", {}).items() if key not in CLIENTS_OWN}
    required = [key for key in schema.get("required", []) if key not in CLIENTS_OWN]
    return {**schema, "properties": properties, "required": required}
