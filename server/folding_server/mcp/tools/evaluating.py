"""Evaluation: what scores of a state are computed from."""

from typing import Annotated

from folding_schemas.state_measures import StateMeasures
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.mcp import icons
from folding_server.mcp.context import ToolContext, app_context
from folding_server.mcp.parameters import RunId
from folding_server.mcp.results import call_tool_result
from folding_server.mcp.services.long_calls import aside, compute_long
from folding_server.mcp.services.vision_jobs import measure_for_evaluation
from folding_server.mcp.tool_record import LOOKS, tool

FoldText = Annotated[
    str | None, Field(description="the text of a FOLD file; left out, the current state of the run")
]


@tool("Measure a state", LOOKS, icons.CHECK_ICON, long=True)
async def measure_state(
    ctx: ToolContext, fold: FoldText = None, run_id: RunId = None
) -> Annotated[CallToolResult, StateMeasures]:
    """Give what a state is scored by."""
    app = app_context(ctx)
    measured = fold if fold is not None else await aside(lambda: app.paper(app.run(run_id)))
    found = await compute_long(ctx, "measure_state", 1, measure_for_evaluation, measured)
    text = "The crease pattern compiles." if found.compiles else f"It does not compile: {found.problem}"
    return call_tool_result(text, found)
