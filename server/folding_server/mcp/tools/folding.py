"""The five folding primitives and ``undo``: record in the store, apply to the paper, commit, answer."""

from typing import Annotated

from folding_schemas import actions
from folding_schemas.actions import action_text
from folding_schemas.results import ActionResult
from mcp.types import CallToolResult

from folding_server.mcp import icons
from folding_server.mcp.context import ToolContext, app_context
from folding_server.mcp.parameters import Axis, Crease, Degrees, Fraction, RunId, Side, VertexIds
from folding_server.mcp.results import call_tool_result
from folding_server.mcp.services.run_status import attempt_in_words
from folding_server.mcp.tool_record import ADDS, GIVES_UP, tool
from folding_server.simulator import Paper, folded_state
from folding_server.simulator.state_diff import StateDifference, state_difference
from folding_server.simulator.vertices import id_ranges
from folding_server.store.views import RunView

_Answer = Annotated[CallToolResult, ActionResult]


@tool("Add a vertex", ADDS, icons.ACTION_ICON, within="paper", brief=True)
def add_vertex(ctx: ToolContext, edge: VertexIds, position: Fraction, run_id: RunId = None) -> _Answer:
    """Subdivide an edge."""
    return _act(ctx, run_id, actions.AddVertex(edge=edge, position=position))


@tool("Fold", ADDS, icons.ACTION_ICON, within="paper", brief=True)
def fold(ctx: ToolContext, edge: VertexIds, direction: Side, run_id: RunId = None) -> _Answer:
    """Fold along the line through two vertices."""
    return _act(ctx, run_id, actions.Fold(edge=edge, direction=direction))


@tool("Unfold", ADDS, icons.ACTION_ICON, within="paper", brief=True)
def unfold(ctx: ToolContext, edge: Crease = None, run_id: RunId = None) -> _Answer:
    """Open a fold again."""
    return _act(ctx, run_id, actions.Unfold(edge=edge))


@tool("Rotate the model", ADDS, icons.ACTION_ICON, within="paper", brief=True)
def rotate(ctx: ToolContext, angle: Degrees, run_id: RunId = None) -> _Answer:
    """Turn the model in the plane."""
    return _act(ctx, run_id, actions.Rotate(angle=angle))


@tool("Turn the model over", ADDS, icons.ACTION_ICON, within="paper", brief=True)
def flip(ctx: ToolContext, axis: Axis, run_id: RunId = None) -> _Answer:
    """Turn the model over."""
    return _act(ctx, run_id, actions.Flip(axis=axis))


@tool("Undo the last action", GIVES_UP, icons.ACTION_ICON, within="standard")
def undo(ctx: ToolContext, run_id: RunId = None) -> _Answer:
    """Take back the last action."""
    app = app_context(ctx)
    with app.change(ctx, run_id) as change:
        after = change.undo()
    before = change.view
    said = f"Took back {action_text(before.pending[-1])}."
    return _answer(said, after, app.paper(before), app.paper(after))


def _act(ctx: ToolContext, run_id: str | None, action: actions.Action) -> CallToolResult:
    """Apply one action: what the simulator refuses is taken back, and nothing is answered that is not stored."""
    app = app_context(ctx)
    with app.change(ctx, run_id) as change:
        after = change.act(action)
        paper = app.paper(after)
    return _answer(f"Done: {action_text(action)}.", after, app.paper(change.view), paper)


def _answer(said: str, run: RunView, before: Paper, after: Paper) -> CallToolResult:
    """The answer to an action: what it changed, and the new state."""
    made = state_difference(before, after)
    attempt = run.open_attempt
    summary = " ".join(part for part in (said, _in_words(made, after), attempt_in_words(run)) if part)
    result = ActionResult(
        run_id=run.run_id,
        summary=summary,
        new_vertices=made.new_vertices,
        new_faces=made.new_faces,
        moved_faces=made.moved_faces,
        frame=attempt.frame if attempt else None,
        attempt=attempt.number if attempt else None,
        state=folded_state(after),
    )
    return call_tool_result(summary, result)


def _in_words(made: StateDifference, after: Paper) -> str:
    """What is new and what moved."""
    parts = []
    if made.new_vertices:
        parts.append(f"New vertices: {id_ranges(made.new_vertices)}.")
    if made.new_faces:
        parts.append(f"New faces: {id_ranges(made.new_faces)}.")
    if len(made.moved_faces) == len(after.faces):
        parts.append("Every face moved.")
    elif made.moved_faces:
        parts.append(f"Moved faces: {id_ranges(made.moved_faces)}.")
    return " ".join(parts)
