"""Evaluation: what scores of a state are computed from."""

from typing import Annotated

from folding_schemas.state_measures import StateMeasures
from mcp.types import CallToolResult
from pydantic import Field, WithJsonSchema

from folding_server.errors import ProgramError
from folding_server.interchange.programs import load_program
from folding_server.mcp import icons
from folding_server.mcp.context import AppContext, ToolContext, app_context
from folding_server.mcp.parameters import READ_PROGRAM, RunId
from folding_server.mcp.results import call_tool_result
from folding_server.mcp.services.long_calls import aside, compute_long
from folding_server.mcp.services.vision_jobs import measure_for_evaluation
from folding_server.mcp.tool_record import LOOKS, tool
from folding_server.simulate import run_steps
from folding_server.simulator import Paper

FoldText = Annotated[
    str | None, Field(description="the text of a FOLD file; left out, the current state of the run")
]

MeasuredProgram = Annotated[
    str | None,
    READ_PROGRAM,
    WithJsonSchema({"type": "object"}),
    Field(description="a program, whose state after its last step is measured, on the sheet that it gives"),
]


@tool("Measure a state", LOOKS, icons.CHECK_ICON, long=True)
async def measure_state(
    ctx: ToolContext, fold: FoldText = None, program: MeasuredProgram = None, run_id: RunId = None
) -> Annotated[CallToolResult, StateMeasures]:
    """Give what a state is scored by."""
    measured = await aside(lambda: _measured(app_context(ctx), fold, program, run_id))
    found = await compute_long(ctx, "measure_state", 1, measure_for_evaluation, measured)
    text = "The crease pattern compiles." if found.compiles else f"It does not compile: {found.problem}"
    return call_tool_result(text, found)


def _measured(app: AppContext, fold: str | None, program: str | None, run_id: str | None) -> Paper | str:
    """The state that is meant. ProgramError if a program cannot be folded, or comes with a file."""
    if program is None:
        return app.paper(app.run(run_id)) if fold is None else fold
    if fold is not None:
        raise ProgramError(
            "A state is measured from a file or from a program; give fold or program, not both."
        )
    *_, last = run_steps(load_program(program))
    return last.paper
