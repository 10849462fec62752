"""Viewing: the photos, the movement between two of them, the current state as numbers and as a diagram."""

from typing import Annotated

from folding_schemas.results import FrameView, MovementView, RenderView, StateView
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.mcp.context import ToolContext, app_context
from folding_server.mcp.parameters import Frame, LaterFrame, RunId
from folding_server.mcp.results import AnswerPicture, call_tool_result
from folding_server.mcp.services import picture_metas
from folding_server.mcp.services.images import diagram
from folding_server.simulator import folded_state

Labels = Annotated[bool, Field(description="true to write the vertex ids in")]


def view_frame(ctx: ToolContext, frame: Frame, run_id: RunId = None) -> Annotated[CallToolResult, FrameView]:
    """Show the photo of a keyframe."""
    app = app_context(ctx)
    photos = app.sequence(app.run(run_id))
    photo = photos.photo_for_model(frame)
    return call_tool_result(
        f"{photo.caption}.",
        FrameView(frame=frame, width=photo.width, height=photo.height),
        AnswerPicture(photo, picture_metas.photo_of(frame)),
    )


def observe_movement(
    ctx: ToolContext, frame: LaterFrame, run_id: RunId = None
) -> Annotated[CallToolResult, MovementView]:
    """Show what happened between two keyframes."""
    app = app_context(ctx)
    photos = app.sequence(app.run(run_id))
    strip = photos.filmstrip(frame)
    return call_tool_result(
        f"{strip.caption}.",
        MovementView(frame=frame, images=photos.between(frame)),
        AnswerPicture(strip, picture_metas.filmstrip_to(frame)),
    )


def get_current_state(ctx: ToolContext, run_id: RunId = None) -> Annotated[CallToolResult, StateView]:
    """Give the current state as numbers."""
    app = app_context(ctx)
    run = app.run(run_id)
    state = folded_state(app.paper(run))
    text = f"{len(state.vertices)} vertices, {len(state.faces)} faces in {len(state.layers)} layers."
    return call_tool_result(text, StateView(run_id=run.run_id, state=state))


def render_current(
    ctx: ToolContext, labels: Labels = False, run_id: RunId = None
) -> Annotated[CallToolResult, RenderView]:
    """Draw the current state."""
    app = app_context(ctx)
    run = app.run(run_id)
    drawn = diagram(run, app.paper(run), labels=labels)
    view = RenderView(run_id=run.run_id, width=drawn.width, height=drawn.height, labels=labels)
    return call_tool_result(
        "The current state from above, " + ("with" if labels else "without") + " labels.",
        view,
        AnswerPicture(drawn, picture_metas.diagram_of_current_state()),
    )
