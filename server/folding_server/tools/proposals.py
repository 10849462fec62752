"""Vision: what may have happened between two frames."""

from typing import Annotated

from folding_schemas.results import Proposals
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.tools.answers import answer
from folding_server.tools.arguments import LaterFrame, RunId
from folding_server.tools.desk import Call, desk_of

Count = Annotated[int, Field(ge=1, le=10, description="how many proposals to give, from 1 to 10")]


def propose_actions(
    call: Call, frame: LaterFrame, count: Count = 3, run_id: RunId = None
) -> Annotated[CallToolResult, Proposals]:
    """Propose what happened before a frame."""
    raise NotImplementedError
