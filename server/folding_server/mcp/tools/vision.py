"""Vision: what may have happened between two frames, read off the photos."""

from typing import Annotated

from folding_schemas.actions import action_text
from folding_schemas.results import Proposals
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.mcp import icons
from folding_server.mcp.context import ToolContext, app_context
from folding_server.mcp.parameters import READ_WHOLE, LaterFrame, RunId
from folding_server.mcp.results import call_tool_result
from folding_server.mcp.services import presenters
from folding_server.mcp.services.run_status import check_between
from folding_server.mcp.tool_progress import ToolProgress
from folding_server.mcp.tool_record import LOOKS, tool

Count = Annotated[
    int, Field(ge=1, le=10, description="how many proposals to give, from 1 to 10; left out, 3"), READ_WHOLE
]


@tool("Propose actions", LOOKS, icons.CHECK_ICON)
def propose_actions(
    ctx: ToolContext, frame: LaterFrame, count: Count = 3, run_id: RunId = None
) -> Annotated[CallToolResult, Proposals]:
    """Propose what happened before a frame."""
    from folding_server.vision.solver import clearly_best, propose  # noqa: PLC0415  (loads OpenCV)

    app = app_context(ctx)
    run = app.run(run_id)
    photos = app.sequence(run)
    photos.require(frame)
    check_between(run, frame)
    progress = ToolProgress(ctx, total=2)
    progress.step("finding the sheet in the photos")
    with app.observing(photos) as eyes:
        progress.step(f"explaining frame {frame}")
        plans = propose(app.paper(run), eyes, frame, max(count, 2))
    shown = presenters.proposals(plans[:count])
    found = Proposals(frame=frame, proposals=shown, confident=clearly_best(plans))
    return call_tool_result(_in_words(found), found)


def _in_words(found: Proposals) -> str:
    """The proposals, best first, as calls to make."""
    lines = [
        f"{each.rank}. {', then '.join(action_text(action) for action in each.actions) or 'nothing'} "
        f"explains {each.agreement:.1%} of the photo."
        for each in found.proposals
    ]
    if not lines:
        return f"No explanation of frame {found.frame} was found from the current state."
    return "\n".join(
        [*lines, "The first stands clear of the rest." if found.confident else "No clear favourite."]
    )
