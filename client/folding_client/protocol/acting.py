"""Carrying out actions for the client itself."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from folding_schemas.actions import Action

from folding_client.interrupts import ToolRefused

if TYPE_CHECKING:
    from folding_client.protocol.server_client import ServerClient

ACTIONS = frozenset({"add_vertex", "fold", "unfold", "rotate", "flip"})
"""The tools that carry out an action; each has the name of its action."""


async def carry_out(server: "ServerClient", actions: Sequence[Action]) -> None:
    """Carry out actions in order. ToolRefused at the first that is refused."""
    for action in actions:
        result = await server.act(action)
        if result.is_error:
            raise ToolRefused(result.text)
