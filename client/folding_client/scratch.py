"""A second run of the same sequence, to try states out without touching the run that is recorded."""

from collections.abc import Sequence

from folding_schemas.actions import Action
from folding_schemas.results import CheckpointRestored, CheckpointSaved, Comparison

from folding_client.interrupts import ToolRefused
from folding_client.server import FoldingServer


async def walk(server: FoldingServer, steps: Sequence[Sequence[Action]]) -> None:
    """Carry out the steps of a program from the flat sheet, saving each frame. ToolRefused if one is
    refused.
    """
    await server.ask(CheckpointSaved, "save_checkpoint", frame=1)
    for frame, actions in enumerate(steps, start=2):
        await carry_out(server, actions)
        await server.ask(CheckpointSaved, "save_checkpoint", frame=frame)


async def carry_out(server: FoldingServer, actions: Sequence[Action]) -> None:
    """Carry out actions in order. ToolRefused at the first that is refused."""
    for action in actions:
        result = await server.act(action)
        if result.is_error:
            raise ToolRefused(result.text)


async def agreement_of(server: FoldingServer, frame: int, actions: Sequence[Action]) -> float | None:
    """How well the actions from checkpoint ``frame - 1`` explain the photo, None if they cannot be carried
    out; the checkpoint is restored afterwards.
    """
    try:
        await carry_out(server, actions)
        comparison, _ = await server.ask(Comparison, "compare_to_frame", frame=frame)
        agreement: float | None = comparison.agreement
    except ToolRefused:
        agreement = None
    await server.ask(CheckpointRestored, "restore_checkpoint", frame=frame - 1)
    return agreement
