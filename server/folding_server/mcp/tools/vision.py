"""Vision: what may have happened between two frames, read off the photos."""

from typing import Annotated

from folding_schemas.actions import Actions, action_text
from folding_schemas.results import CreaseRefinement, Proposals
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.errors import RunError
from folding_server.mcp import icons
from folding_server.mcp.context import AppContext, ToolContext, app_context
from folding_server.mcp.parameters import READ_WHOLE, LaterFrame, RunId
from folding_server.mcp.results import call_tool_result
from folding_server.mcp.services.long_calls import aside, compute_long
from folding_server.mcp.services.run_status import UNIT_SQUARE, check_between, known_steps
from folding_server.mcp.services.vision_jobs import (
    KnownState,
    SequencePlace,
    propose_actions_for,
    refine_creases_for,
)
from folding_server.mcp.tool_record import LOOKS, tool

Count = Annotated[
    int, Field(ge=1, le=10, description="how many proposals to give, from 1 to 10; left out, 3"), READ_WHOLE
]


@tool("Propose actions", LOOKS, icons.CHECK_ICON, long=True)
async def propose_actions(
    ctx: ToolContext, frame: LaterFrame, count: Count = 3, run_id: RunId = None
) -> Annotated[CallToolResult, Proposals]:
    """Propose what happened before a frame."""
    place, known = await aside(_given, app_context(ctx), frame, run_id)
    found = await compute_long(
        ctx, "propose_actions", 2, propose_actions_for, place, known, frame, count, place=place.key
    )
    return call_tool_result(_in_words(found), found)


@tool("Refine creases", LOOKS, icons.CHECK_ICON, long=True)
async def refine_creases(
    ctx: ToolContext, frame: LaterFrame, run_id: RunId = None
) -> Annotated[CallToolResult, CreaseRefinement]:
    """Fit the creases up to a frame to all photos."""
    place, steps = await aside(_made, app_context(ctx), frame, run_id)
    found = await compute_long(ctx, "refine_creases", 2, refine_creases_for, place, steps, place=place.key)
    return call_tool_result(_refined_in_words(found), found)


def _made(app: AppContext, frame: int, run_id: str | None) -> tuple[SequencePlace, tuple[Actions, ...]]:
    """The photos, and the actions between each two of them up to a frame that the current state shows."""
    run = app.run(run_id)
    photos = app.sequence(run)
    photos.require(frame)
    if run.sheet != UNIT_SQUARE:
        raise RunError(
            f"The sheet of run {run.run_id} is {run.sheet[0]} by {run.sheet[1]}; creases are refined on a square."
        )
    if run.base != frame or run.pending:
        check_between(run, frame)
    steps = run.current_program().steps
    return SequencePlace.of(photos), steps if len(steps) == frame - 1 else (*steps, ())


def _refined_in_words(found: CreaseRefinement) -> str:
    """What the photos tell of the creases, and the steps that would be others."""
    if not found.told:
        return f"The photos up to frame {found.frame} do not tell that creases lie elsewhere."
    lines = [
        f"Step to frame {number}: {', then '.join(action_text(action) for action in step) or 'nothing'}."
        for number, step in enumerate(found.steps, 2)
    ]
    moved = f"The photos up to frame {found.frame} tell that creases lie up to {found.moved:.3f} sides of the sheet elsewhere."
    return "\n".join([moved, *lines])


def _given(app: AppContext, frame: int, run_id: str | None) -> tuple[SequencePlace, KnownState]:
    """The photos and the state that a call means."""
    run = app.run(run_id)
    photos = app.sequence(run)
    photos.require(frame)
    check_between(run, frame)
    return SequencePlace.of(photos), KnownState(app.paper(run), known_steps(run))


def _in_words(found: Proposals) -> str:
    """The proposals, best first, as calls to make."""
    lines = [
        f"{each.rank}. {', then '.join(action_text(action) for action in each.actions) or 'nothing'} "
        f"explains {each.agreement:.1%} of the photo."
        for each in found.proposals
    ]
    if not lines:
        return f"No explanation of frame {found.frame} was found from the current state."
    lead = "The first stands clear of the rest." if found.confident else "No clear favourite."
    trust = "" if found.confidence is None else f" Confidence in the first: {found.confidence:.0%}."
    return "\n".join([*lines, lead + trust, *(f"Warning: {each}." for each in found.warnings)])
