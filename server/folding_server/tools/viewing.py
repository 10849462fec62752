"""Viewing: the photos, the movement between two of them, the current state as numbers and as a diagram."""

from typing import Annotated

from folding_schemas.results import FrameView, MovementView, RenderView, StateView
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.simulator import folded_state
from folding_server.tools.answers import answer
from folding_server.tools.arguments import Frame, LaterFrame, RunId
from folding_server.tools.desk import Call, desk_of
from folding_server.tools.pictures import diagram

Labels = Annotated[bool, Field(description="true to write the vertex ids in")]


def view_frame(call: Call, frame: Frame, run_id: RunId = None) -> Annotated[CallToolResult, FrameView]:
    """Show the photo of a keyframe."""
    desk = desk_of(call)
    photos = desk.sequence(desk.run(run_id))
    photo = photos.photo_for_model(frame)
    return answer(f"{photo.caption}.", FrameView(frame=frame, width=photo.width, height=photo.height), photo)


def observe_movement(
    call: Call, frame: LaterFrame, run_id: RunId = None
) -> Annotated[CallToolResult, MovementView]:
    """Show what happened between two keyframes."""
    desk = desk_of(call)
    photos = desk.sequence(desk.run(run_id))
    strip = photos.filmstrip(frame)
    return answer(f"{strip.caption}.", MovementView(frame=frame, images=photos.between(frame)), strip)


def get_current_state(call: Call, run_id: RunId = None) -> Annotated[CallToolResult, StateView]:
    """Give the current state as numbers."""
    desk = desk_of(call)
    run = desk.run(run_id)
    state = folded_state(desk.paper(run))
    text = f"{len(state.vertices)} vertices, {len(state.faces)} faces in {len(state.layers)} layers."
    return answer(text, StateView(run_id=run.run_id, state=state))


def render_current(
    call: Call, labels: Labels = False, run_id: RunId = None
) -> Annotated[CallToolResult, RenderView]:
    """Draw the current state."""
    desk = desk_of(call)
    run = desk.run(run_id)
    drawn = diagram(run, desk.paper(run), labels=labels)
    view = RenderView(run_id=run.run_id, width=drawn.width, height=drawn.height, labels=labels)
    return answer(
        "The current state from above, " + ("with" if labels else "without") + " labels.", view, drawn
    )
