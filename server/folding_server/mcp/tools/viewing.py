"""Viewing: the photos, the movement between two of them, the current state as numbers and as a diagram."""

from typing import Annotated

from folding_schemas.results import FrameView, MovementView, RenderView, StateView
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.mcp import icons
from folding_server.mcp.context import ToolContext, app_context
from folding_server.mcp.parameters import Frame, ImageSize, LaterFrame, RunId
from folding_server.mcp.results import AnswerPicture, call_tool_result, picture_result
from folding_server.mcp.services import picture_metas
from folding_server.mcp.services.images import diagram
from folding_server.mcp.tool_record import LOOKS, tool
from folding_server.simulator import folded_state

Labels = Annotated[bool, Field(description="true to write the vertex ids in")]


@tool("View a frame", LOOKS, icons.PHOTO_ICON, within="paper", pictures=True)
def view_frame(
    ctx: ToolContext, frame: Frame, images: ImageSize = "full", run_id: RunId = None
) -> Annotated[CallToolResult, FrameView]:
    """Show the photo of a keyframe."""
    app = app_context(ctx)
    photos = app.sequence(app.run(run_id))
    photo = photos.photo_for_model(frame)
    view = FrameView(frame=frame, width=photo.width, height=photo.height)
    shown = AnswerPicture(photo, picture_metas.photo_of(frame))
    return picture_result(f"{photo.caption}.", view, [shown], images)


@tool("Observe the movement", LOOKS, icons.PHOTO_ICON, within="paper", pictures=True)
def observe_movement(
    ctx: ToolContext, frame: LaterFrame, images: ImageSize = "full", run_id: RunId = None
) -> Annotated[CallToolResult, MovementView]:
    """Show what happened between two keyframes."""
    app = app_context(ctx)
    photos = app.sequence(app.run(run_id))
    strip = photos.filmstrip(frame)
    view = MovementView(frame=frame, images=photos.between(frame))
    shown = AnswerPicture(strip, picture_metas.filmstrip_to(frame))
    return picture_result(f"{strip.caption}.", view, [shown], images)


@tool("Read the current state", LOOKS, icons.PHOTO_ICON, within="paper", brief=True)
def get_current_state(ctx: ToolContext, run_id: RunId = None) -> Annotated[CallToolResult, StateView]:
    """Give the current state as numbers."""
    app = app_context(ctx)
    run = app.run(run_id)
    state = folded_state(app.paper(run))
    text = f"{len(state.vertices)} vertices, {len(state.faces)} faces in {len(state.layers)} layers."
    return call_tool_result(text, StateView(run_id=run.run_id, state=state))


@tool("Draw the current state", LOOKS, icons.PHOTO_ICON, within="paper", pictures=True)
def render_current(
    ctx: ToolContext, labels: Labels = False, images: ImageSize = "full", run_id: RunId = None
) -> Annotated[CallToolResult, RenderView]:
    """Draw the current state."""
    app = app_context(ctx)
    run = app.run(run_id)
    drawn = diagram(run, app.paper(run), labels=labels)
    view = RenderView(run_id=run.run_id, width=drawn.width, height=drawn.height, labels=labels)
    text = f"The current state from above, {'with' if labels else 'without'} labels."
    return picture_result(
        text, view, [AnswerPicture(drawn, picture_metas.diagram_of_current_state())], images
    )
