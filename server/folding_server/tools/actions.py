"""The five folding primitives and ``undo``: refuse early, apply to the paper, append to the store, answer."""

from typing import Annotated

from folding_schemas import actions
from folding_schemas.results import ActionResult
from mcp.types import CallToolResult

from folding_server.simulator import Paper, folded_state
from folding_server.simulator.vertices import listed
from folding_server.store.rules import check_may_act
from folding_server.store.views import RunView
from folding_server.tools.answers import answer
from folding_server.tools.arguments import Axis, Crease, Degrees, Fraction, RunId, Side, VertexIds
from folding_server.tools.changes import Change, change
from folding_server.tools.desk import Call, desk_of
from folding_server.tools.standing import attempt_in_words, described

Answer = Annotated[CallToolResult, ActionResult]


def add_vertex(call: Call, edge: VertexIds, position: Fraction, run_id: RunId = None) -> Answer:
    """Subdivide an edge."""
    return _act(call, run_id, actions.AddVertex(edge=edge, position=position))


def fold(call: Call, edge: VertexIds, direction: Side, run_id: RunId = None) -> Answer:
    """Fold along the line through two vertices."""
    return _act(call, run_id, actions.Fold(edge=edge, direction=direction))


def unfold(call: Call, edge: Crease = None, run_id: RunId = None) -> Answer:
    """Open a fold again."""
    return _act(call, run_id, actions.Unfold(edge=edge))


def rotate(call: Call, angle: Degrees, run_id: RunId = None) -> Answer:
    """Turn the model in the plane."""
    return _act(call, run_id, actions.Rotate(angle=angle))


def flip(call: Call, axis: Axis, run_id: RunId = None) -> Answer:
    """Turn the model over."""
    return _act(call, run_id, actions.Flip(axis=axis))


def undo(call: Call, run_id: RunId = None) -> Answer:
    """Take back the last action."""
    desk = desk_of(call)
    with desk.holding(run_id) as before:
        after = desk.store.undo(before.run_id, after=before.seq)
    said = f"Took back {described(before.pending[-1])}."
    return _answer(said, after, desk.paper(before), desk.paper(after))


def _act(call: Call, run_id: str | None, action: actions.Action) -> CallToolResult:
    """Apply one action: nothing is stored that the simulator refuses, nothing answered that is not stored."""
    desk = desk_of(call)
    with desk.holding(run_id) as before:
        check_may_act(before)
        paper = desk.papers.after(before.sheet, (*before.actions, action))
        after = desk.store.act(before.run_id, action, after=before.seq)
    return _answer(f"Done: {described(action)}.", after, desk.paper(before), paper)


def _answer(said: str, run: RunView, before: Paper, after: Paper) -> CallToolResult:
    """The answer to an action: what it changed, and the new state."""
    made = change(before, after)
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
    return answer(summary, result)


def _in_words(made: Change, after: Paper) -> str:
    """What is new and what moved."""
    parts = []
    if made.new_vertices:
        parts.append(f"New vertices: {listed(made.new_vertices)}.")
    if made.new_faces:
        parts.append(f"New faces: {listed(made.new_faces)}.")
    if len(made.moved_faces) == len(after.faces):
        parts.append("Every face moved.")
    elif made.moved_faces:
        parts.append(f"Moved faces: {listed(made.moved_faces)}.")
    return " ".join(parts)
