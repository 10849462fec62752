"""Verification: the evidence for a critic, the comparison with a photo, and flat-foldability."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

from folding_schemas.actions import Actions
from folding_schemas.foldability_results import Foldability
from folding_schemas.results import Comparison, CriticGrid
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.errors import RunError
from folding_server.mcp import icons
from folding_server.mcp.context import AppContext, ToolContext, app_context
from folding_server.mcp.parameters import READ_WHOLE, Frame, ImageSize, LaterFrame, RunId, StateOfAttempt
from folding_server.mcp.results import AnswerPicture, call_tool_result, picture_result
from folding_server.mcp.services import picture_metas
from folding_server.mcp.services.images import diagram, photo_beside_others
from folding_server.mcp.services.long_calls import aside, compute_long
from folding_server.mcp.services.run_status import checkpoint_at
from folding_server.mcp.services.vision_jobs import (
    SequencePlace,
    check_folding_flat,
    check_text_folding_flat,
    compare_paper,
)
from folding_server.mcp.tool_record import LOOKS, tool
from folding_server.simulator import Paper, folded_state
from folding_server.store.rules import find_attempt, find_state
from folding_server.store.views import RunView

if TYPE_CHECKING:
    from folding_server.frames.sequences import Sequence

AttemptNumber = Annotated[
    int | None,
    Field(ge=1, description="the number of an attempt at the frame, from 1; left out, the current state"),
    READ_WHOLE,
]


@tool("Gather evidence for a critic", LOOKS, icons.CHECK_ICON, pictures=True)
def critic_grid(
    ctx: ToolContext, frame: LaterFrame, images: ImageSize = "full", run_id: RunId = None
) -> Annotated[CallToolResult, CriticGrid]:
    """Gather what a critic needs to judge the current state as a frame's."""
    app = app_context(ctx)
    run = app.run(run_id)
    photos = app.sequence(run)
    for each in (frame - 1, frame):
        photos.require(each)
    source_path = checkpoint_at(run, frame - 1).path
    _check_grown_from(run, frame)
    source, candidate = app.replays.after(run.sheet, source_path), app.paper(run)
    grid = CriticGrid(
        frame=frame,
        source_state=folded_state(source),
        candidate_state=folded_state(candidate),
        candidate_actions=list(run.actions[len(source_path) :]),
    )
    text = (
        f"Photo of frame {frame - 1}, photo of frame {frame}, diagram of checkpoint {frame - 1}, "
        f"diagram of the current state as candidate for frame {frame}."
    )
    return picture_result(text, grid, _four_pictures(run, photos, frame, source, candidate), images)


def _four_pictures(
    run: RunView, photos: "Sequence", frame: int, source: Paper, candidate: Paper
) -> Iterator[AnswerPicture]:
    """Both photos, then the diagrams of both states."""
    for each in (frame - 1, frame):
        yield AnswerPicture(photo_beside_others(photos, each), picture_metas.photo_of(each))
    yield AnswerPicture(diagram(run, source), picture_metas.diagram_of_frame(frame - 1))
    yield AnswerPicture(diagram(run, candidate), picture_metas.diagram_of_candidate(frame))


def _check_grown_from(run: RunView, frame: int) -> None:
    """Raise RunError unless the current state grew from the frame before, or is the frame itself."""
    if run.base not in (frame - 1, frame):
        raise RunError(
            f"The current state grew from checkpoint {run.base}, so it is no candidate for frame {frame}; "
            f"call restore_checkpoint({frame - 1}) and act from there."
        )


@tool("Compare with a frame", LOOKS, icons.CHECK_ICON, within="standard", pictures=True, long=True)
async def compare_to_frame(
    ctx: ToolContext,
    frame: Frame,
    attempt: AttemptNumber = None,
    state: StateOfAttempt = None,
    images: ImageSize = "full",
    run_id: RunId = None,
) -> Annotated[CallToolResult, Comparison]:
    """Measure how well the current state, or what an attempt at the frame came to, explains a photo."""
    place, paper = await aside(_to_compare, app_context(ctx), frame, attempt, state, run_id)
    draw = images != "none"
    found, overlay = await compute_long(
        ctx, "compare_to_frame", 2, compare_paper, place, paper, frame, draw, place=place.key
    )
    said = _in_words(found)
    meta = picture_metas.overlay_on(frame, attempt, state)
    shown = [AnswerPicture(overlay, meta)] if overlay else []
    text = said if attempt is None else f"Attempt {attempt}: {said}"
    return await aside(picture_result, text, found, shown, images)


def _to_compare(
    app: AppContext, frame: int, attempt: int | None, state: int | None, run_id: str | None
) -> tuple[SequencePlace, Paper]:
    """The photos and the paper that a call means."""
    run = app.run(run_id)
    photos = app.sequence(run)
    photos.require(frame)
    actions = _compared_actions(run, frame, attempt, state)
    return SequencePlace.of(photos), app.replays.after(run.sheet, actions)


def _compared_actions(run: RunView, frame: int, attempt: int | None, state: int | None) -> Actions:
    """The actions to what is compared: the current state, or one that an attempt came to. RunError if there is none."""
    if attempt is not None:
        return find_state(find_attempt(run, frame, attempt), state).path
    if state is not None:
        raise RunError(
            "A state is compared of an attempt; give the number of the attempt too, or leave state out."
        )
    return run.actions


PatternFile = Annotated[
    str | None,
    Field(description="text of a FOLD, .cp, .ori, SVG or DXF file; left out, the state"),
]


@tool("Check flat-foldability", LOOKS, icons.CHECK_ICON, long=True)
async def check_foldability(
    ctx: ToolContext, pattern: PatternFile = None, run_id: RunId = None
) -> Annotated[CallToolResult, Foldability]:
    """Check whether a crease pattern can be folded flat."""
    if pattern is None:
        paper = await aside(_current_paper, app_context(ctx), run_id)
        found = await compute_long(ctx, "check_foldability", 1, check_folding_flat, paper)
    else:
        found = await compute_long(ctx, "check_foldability", 1, check_text_folding_flat, pattern)
    return call_tool_result(" ".join([found.reason, *found.notes]), found)


def _current_paper(app: AppContext, run_id: str | None) -> Paper:
    return app.paper(app.run(run_id))


def _in_words(found: Comparison) -> str:
    """The verdict and what disagrees."""
    said = f"{found.verdict} with frame {found.frame}: {found.agreement:.1%} of the paper agrees."
    warned = [f"Warning: {each}." for each in found.warnings]
    return " ".join([said, *warned, *(f"{each}." for each in found.discrepancies)])
