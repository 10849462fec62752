"""Instructions: a run as steps for people to fold by, and whole programs tried without a run."""

from typing import Annotated

from folding_schemas.results import Instructions, ProgramTrial
from mcp.types import CallToolResult
from pydantic import Field, WithJsonSchema

from folding_server.mcp import icons
from folding_server.mcp.context import ToolContext, app_context
from folding_server.mcp.parameters import READ_PROGRAM, READ_WHOLE, ImageSize, RunId
from folding_server.mcp.results import AnswerPicture, picture_result
from folding_server.mcp.services import picture_metas
from folding_server.mcp.services.instruction_jobs import instruct, try_whole
from folding_server.mcp.services.long_calls import aside, compute_long
from folding_server.mcp.tool_record import LOOKS, tool

DrawnStep = Annotated[
    int | None, Field(ge=1, description="the step to draw, from 1; left out, all"), READ_WHOLE
]
ProgramGiven = Annotated[
    str,
    READ_PROGRAM,
    WithJsonSchema({"type": "object"}),
    Field(description="a program: name and steps, each a list of actions"),
]


@tool("Instructions to fold by", LOOKS, icons.FILE_ICON, pictures=True)
async def get_instructions(
    ctx: ToolContext, step: DrawnStep = None, images: ImageSize = "full", run_id: RunId = None
) -> Annotated[CallToolResult, Instructions]:
    """Draw a run as steps to fold by."""
    app = app_context(ctx)
    run = await aside(app.run, run_id)
    told, picture = await compute_long(ctx, "get_instructions", 1, instruct, run.current_program(), step)
    text = told.steps[step - 1] if step else "\n".join(told.steps)
    shown = AnswerPicture(picture, picture_metas.instructions_of(step))
    return picture_result(text, told, [shown], images)


@tool("Try a program", LOOKS, icons.ACTION_ICON, pictures=True)
async def try_program(
    ctx: ToolContext, program: ProgramGiven, images: ImageSize = "full"
) -> Annotated[CallToolResult, ProgramTrial]:
    """Fold a whole program without keeping it."""
    tried, picture = await compute_long(ctx, "try_program", 1, try_whole, program)
    text = tried.error or f"All {tried.steps_done} steps can be folded."
    pictures = [AnswerPicture(picture, picture_metas.states_of_program())] if picture else []
    return picture_result(text, tried, pictures, images)
