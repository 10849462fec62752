"""Attempts: what was tried for a frame, and settling it for good."""

from typing import Annotated

from folding_schemas.results import AttemptCommitted, AttemptInfo, AttemptList
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.mcp import icons
from folding_server.mcp.context import AppContext, ToolContext, app_context
from folding_server.mcp.parameters import READ_WHOLE, ImageSize, LaterFrame, RunId
from folding_server.mcp.results import AnswerPicture, call_tool_result, picture_result
from folding_server.mcp.services import picture_metas
from folding_server.mcp.services.images import SMALL_SIZE, diagram
from folding_server.mcp.services.run_status import next_step
from folding_server.mcp.tool_record import LOOKS, SETTLES, tool
from folding_server.simulator import folded_state
from folding_server.store.views import Attempt, RunView

Number = Annotated[
    int, Field(ge=1, description="the number of an attempt, as list_attempts shows it, from 1"), READ_WHOLE
]


@tool("List attempts", LOOKS, icons.CHECKPOINT_ICON, within="paper", pictures=True)
def list_attempts(
    ctx: ToolContext, frame: LaterFrame, images: ImageSize = "full", run_id: RunId = None
) -> Annotated[CallToolResult, AttemptList]:
    """Show the attempts made at a frame, with a diagram of each."""
    app = app_context(ctx)
    run = app.run(run_id)
    app.sequence(run).require(frame)
    made = run.attempts.get(frame, ())
    drawn = (_diagram(app, run, each) for each in made)
    listed = AttemptList(frame=frame, budget=run.budget or 0, attempts=[_info(each) for each in made])
    order = f"; the diagrams are those of {', '.join(each.label for each in made)}" if made else ""
    text = f"{len(made)} of {run.budget} attempts at frame {frame}{order}."
    return picture_result(text, listed, drawn, images)


@tool("Commit an attempt", SETTLES, icons.CHECKPOINT_ICON, within="paper")
def commit_attempt(
    ctx: ToolContext, frame: LaterFrame, attempt: Number, run_id: RunId = None
) -> Annotated[CallToolResult, AttemptCommitted]:
    """Settle a frame with one of its attempts."""
    app = app_context(ctx)
    with app.change(ctx, run_id) as change:
        run = change.commit(frame, attempt)
    committed = AttemptCommitted(
        frame=frame,
        attempt=attempt,
        locked_to=run.locked_to,
        next_frame=run.next_frame,
        complete=run.complete,
        state=folded_state(app.paper(run)),
    )
    return call_tool_result(f"Frame {frame} is settled with attempt {attempt}. {next_step(run)}", committed)


def _diagram(app: AppContext, run: RunView, attempt: Attempt) -> AnswerPicture:
    """What an attempt came to."""
    drawn = diagram(run, app.replays.after(run.sheet, attempt.path), size=SMALL_SIZE)
    return AnswerPicture(drawn, picture_metas.diagram_of_attempt(attempt.frame, attempt.number))


def _info(attempt: Attempt) -> AttemptInfo:
    """An attempt as hosts see it."""
    return AttemptInfo(
        attempt=attempt.number, label=attempt.label, actions=list(attempt.actions), outcome=attempt.outcome
    )
