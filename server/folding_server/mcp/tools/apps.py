"""MCP Apps: the tool that opens a view of the model in hosts that render one, and tells all others in words."""

from typing import Annotated, Any

from folding_schemas.model_view import ModelShown
from mcp.server.apps import APP_MIME_TYPE, Apps
from mcp.server.mcpserver.resources import FunctionResource
from mcp.types import CallToolResult, TextContent

from folding_server.errors import PhotoError
from folding_server.mcp import icons
from folding_server.mcp.context import AppContext, ToolContext, app_context
from folding_server.mcp.parameters import RunId
from folding_server.mcp.tool_record import LOOKS, tool
from folding_server.store.views import RunView
from folding_server.view.page import page_html

PAGE_URI = "ui://folding/model.html"
VIEW_KEY = "foldingagent/view"
"""Where the answer's metadata hold what the page shows: hosts hand it to the page and not to their model."""

TOOL_META: dict[str, dict[str, Any]] = {"show_model": {"ui": {"resourceUri": PAGE_URI}}}
"""What the list of tools says of a tool beside its schema, by the tool's name."""


@tool("Show the model", LOOKS, icons.FILE_ICON)
def show_model(ctx: ToolContext, run_id: RunId = None) -> Annotated[CallToolResult, ModelShown]:
    """Open a view of the run's model."""
    from folding_server.view.stops import model_shown, model_view, program_window

    app = app_context(ctx)
    run = app.run(run_id)
    program = run.current_program()
    photos = _photos(app, run, program_window(program, app.replays), len(program.steps) + 1)
    view = model_view(program, app.replays, photos, run.run_id)
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


def _photos(app: AppContext, run: RunView, window: tuple[float, float, float], frames: int) -> dict[int, str]:
    """The photos up to a frame; none in a free fold, or where the sequence is not served any more."""
    from folding_server.view.photo_strip import photos_of

    if run.free:
        return {}
    try:
        return photos_of(app.sequence(run), range(1, frames + 1), window)
    except PhotoError:
        return {}
