"""The folding server as evaluation uses it: states in, measures out."""

import tempfile
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from folding_schemas.actions import Actions, Program
from folding_schemas.state_measures import StateMeasures

from folding_client.evaluation.compared_state import ComparedState, compared_state
from folding_client.interrupts import ConnectionLost, ServerGone, ToolRefused
from folding_client.protocol.connection import Connection, ServerAddress


class MeasuringServer:
    """Measures states on an open connection."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    async def of_fold_file(self, text: str) -> ComparedState:
        """The state in a FOLD file. ToolRefused if it cannot be read."""
        return await self._measured({"fold": text})

    async def of_steps(
        self, steps: Sequence[Actions], sheet: tuple[float, float] = (1.0, 1.0)
    ) -> list[ComparedState]:
        """The state after each step, folded from the flat sheet (width and height), which is not among them. Ends before the
        first step that is refused.
        """
        states: list[ComparedState] = []
        for count in range(1, len(steps) + 1):
            program = Program(sheet=sheet, steps=tuple(steps[:count]))
            given = program.model_dump(mode="json", exclude_none=True)
            try:
                states.append(await self._measured({"program": given}))
            except ToolRefused:
                break
        return states

    async def _measured(self, arguments: Mapping[str, Any]) -> ComparedState:
        return compared_state(StateMeasures.model_validate(await self._ask("measure_state", arguments)))

    async def _ask(self, tool: str, arguments: Mapping[str, Any]) -> dict[str, Any]:
        """The data of an answer. ToolRefused if the call is refused, ServerGone if the server ends."""
        try:
            result = await self._connection.call(tool, arguments)
        except ConnectionLost as loss:
            message = f"The folding server ended while it measured states: {loss}."
            raise ServerGone(message) from loss
        if result.is_error:
            raise ToolRefused(result.text)
        return dict(result.data or {})


@asynccontextmanager
async def measuring_server() -> AsyncIterator[MeasuringServer]:
    """A server of its own, which keeps nothing."""
    with tempfile.TemporaryDirectory() as folder, (Path(folder) / "server.log").open("w") as log:
        address = ServerAddress(Path(folder), Path(folder), options=("--for-evaluation",))
        connection = Connection(address, log)
        try:
            await connection.open()
            yield MeasuringServer(connection)
        except ConnectionLost as loss:
            message = f"The folding server does not start: {loss}."
            raise ServerGone(message) from loss
        finally:
            await connection.close()
