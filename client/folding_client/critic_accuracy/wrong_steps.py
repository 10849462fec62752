"""Steps that are wrong by one kind of mistake, folded through the server, which has the geometry."""

from collections.abc import Iterator
from typing import Literal

from folding_schemas.actions import Action, Actions, AddVertex, Flip, FlipAxis, Fold
from folding_schemas.results import ActionResult, StateView
from folding_schemas.state import FoldedState

from folding_client.interrupts import ToolRefused
from folding_client.protocol.acting import carry_out
from folding_client.protocol.server_client import ServerClient

WrongKind = Literal["line", "side", "layer", "flip"]
KINDS: tuple[WrongKind, ...] = ("line", "side", "layer", "flip")
"""What is wrong: the line of the fold is off, the other side moved, other layers moved (the paper was folded behind
instead of in front), a flip is missing or too many.
"""
LINE_OFF = 0.2
"""How far along an edge, as a share of its length, one end of a fold's line is moved."""
_UPRIGHT = 1e-6
"""A line whose ends are as close as this in x is upright: the simulator folds its right side, not its upper one."""


def kinds_for(step: Actions) -> tuple[WrongKind, ...]:
    """The mistakes that can be made in a step: without a fold, the flip alone."""
    return KINDS if any(isinstance(action, Fold) for action in step) else ("flip",)


async def carry_out_wrongly(server: ServerClient, step: Actions, kind: WrongKind) -> None:
    """Carry out a step with one mistake in it. ToolRefused if the server refuses every way of making it."""
    if kind == "flip":
        await carry_out(server, _wrongly_flipped(step))
        return
    last = max(index for index, action in enumerate(step) if isinstance(action, Fold))
    fold = step[last]
    assert isinstance(fold, Fold), "the last fold is a fold"
    await carry_out(server, step[:last])
    if kind == "line":
        await _fold_off_the_line(server, fold)
    else:
        state = (await server.ask(StateView, "get_current_state"))[0].state
        await carry_out(server, _other_side(fold) if kind == "side" else _behind(fold, state))
    await carry_out(server, step[last + 1 :])


def _wrongly_flipped(step: Actions) -> Actions:
    kept = tuple(action for action in step if not isinstance(action, Flip))
    return kept if len(kept) < len(step) else (*step, Flip(axis="x"))


def _other_side(fold: Fold) -> Actions:
    return (Fold(edge=fold.edge, direction=-1 if fold.direction == 1 else 1),)


def _behind(fold: Fold, state: FoldedState) -> Actions:
    """The same paper folded over the same line, to the back: a flip about an axis that keeps the side's name."""
    one, other = (state.vertices[str(vertex)] for vertex in fold.edge)
    axis: FlipAxis = "y" if abs(one[0] - other[0]) < _UPRIGHT else "x"
    return (Flip(axis=axis), fold, Flip(axis=axis))


async def _fold_off_the_line(server: ServerClient, fold: Fold) -> None:
    """Fold along a line that ends beside the right one's end, on an edge there. ToolRefused if no edge lends itself."""
    state = (await server.ask(StateView, "get_current_state"))[0].state
    why = ToolRefused("no edge ends where the fold's line does")
    for moved, edge in _edges_at_the_ends(state, fold):
        try:
            added = await _act(server, AddVertex(edge=edge, position=LINE_OFF))
            kept = fold.edge[0] if moved == fold.edge[1] else fold.edge[1]
            await _act(server, Fold(edge=(kept, added.new_vertices[0]), direction=fold.direction))
        except ToolRefused as refusal:
            why = refusal
        else:
            return
    raise why


def _edges_at_the_ends(state: FoldedState, fold: Fold) -> Iterator[tuple[int, tuple[int, int]]]:
    """Edges that begin at an end of a fold's line and do not run along it, each with that end."""
    for end in reversed(fold.edge):
        for one, other, _ in state.edges:
            if end in (one, other) and {one, other} != set(fold.edge):
                yield end, (end, other if end == one else one)


async def _act(server: ServerClient, action: Action) -> ActionResult:
    answer = await server.act(action)
    if answer.is_error:
        raise ToolRefused(answer.text)
    return ActionResult.model_validate(answer.data)
