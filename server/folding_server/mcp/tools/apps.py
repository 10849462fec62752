"""MCP Apps: the tool that opens a view of the model in hosts that render one, and tells all others in words."""

from typing import Annotated, Any

from folding_schemas.actions import Program
from folding_schemas.model_view import ModelShown
from mcp.server.apps import APP_MIME_TYPE, Apps
from mcp.server.mcpserver.resources import FunctionResource
from mcp.types import CallToolResult, TextContent

from folding_server.errors import PhotoError
from folding_server.mcp import icons
from folding_server.mcp.context import AppContext, ToolContext, app_context
from folding_server.mcp.parameters import RunId
from folding_server.mcp.services.long_calls import aside, compute_long
from folding_server.mcp.services.vision_jobs import SequencePlace, view_program
from folding_server.mcp.tool_record import LOOKS, tool
from folding_server.view.page import page_html

PAGE_URI = "ui://folding/model.html"
VIEW_KEY = "foldingagent/view"
"""Where the answer's metadata hold what the page shows: hosts hand it to the page and not to their model."""

TOOL_META: dict[str, dict[str, Any]] = {"show_model": {"ui": {"resourceUri": PAGE_URI}}}
"""What the list of tools says of a tool beside its schema, by the tool's name."""


@tool("Show the model", LOOKS, icons.FILE_ICON)
async def show_model(ctx: ToolContext, run_id: RunId = None) -> Annotated[CallToolResult, ModelShown]:
    """Open a view of the run's model."""
    from folding_server.view.stops import model_shown

    program, known_as, place = await aside(_given, app_context(ctx), run_id)
    view = await compute_long(ctx, "show_model", 1, view_program, program, known_as, place)
    shown = model_shown(view)
    return CallToolResult(
        content=[TextContent(text="\n".join([shown.summary, *shown.stops]))],
        structured_content=shown.model_dump(mode="json"),
        meta={VIEW_KEY: view.model_dump(mode="json")},
    )


def model_app() -> Apps:
    """The extension that says that this server has a view, and the page itself; it is read when a host asks."""
    apps = Apps()
    page = FunctionResource(
        uri=PAGE_URI,
        name="model_view",
        title="The folded model",
        description="Folded state and crease pattern side by side, step by step, beside the photos.",
        mime_type=APP_MIME_TYPE,
        meta={"ui": {"prefersBorder": True}},
        fn=page_html,
    )
    apps.add_resource(page)
    return apps


def _given(app: AppContext, run_id: str | None) -> tuple[Program, str, SequencePlace | None]:
    """The program that a call means and its run, and where its photos are.

    No photos in a free fold, or where the sequence is not served any more.
    """
    run = app.run(run_id)
    if run.free:
        return run.current_program(), run.run_id, None
    try:
        place = SequencePlace.of(app.sequence(run))
    except PhotoError:
        place = None
    return run.current_program(), run.run_id, place
