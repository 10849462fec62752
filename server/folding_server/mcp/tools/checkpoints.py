"""Checkpoints: saving and restoring frames, reading what is saved, the overview of photos and diagrams."""

from typing import Annotated

from folding_schemas.results import (
    CheckpointOverview,
    CheckpointRestored,
    CheckpointSaved,
    CheckpointState,
    OverviewFrame,
)
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.mcp import icons
from folding_server.mcp.context import AppContext, ToolContext, app_context, is_technical
from folding_server.mcp.parameters import Frame, ImageSize, RunId
from folding_server.mcp.results import AnswerPicture, call_tool_result, picture_result
from folding_server.mcp.services import picture_metas
from folding_server.mcp.services.long_calls import aside, compute_long
from folding_server.mcp.services.run_addresses import checkpoint_links
from folding_server.mcp.services.run_status import attempt_in_words, checkpoint_state, next_step
from folding_server.mcp.services.vision_jobs import OverviewColumn, SequencePlace, SheetColors, draw_overview
from folding_server.mcp.tool_record import ADDS, GIVES_UP, LOOKS, tool
from folding_server.simulator import folded_state
from folding_server.store.views import RunView

Notes = Annotated[str | None, Field(description="a remark to keep with the checkpoint, in words")]


@tool("Save a checkpoint", ADDS, icons.CHECKPOINT_ICON, within="paper", brief=True)
def save_checkpoint(
    ctx: ToolContext, frame: Frame, notes: Notes = None, run_id: RunId = None
) -> Annotated[CallToolResult, CheckpointSaved]:
    """Record the current state as a keyframe's solution."""
    app = app_context(ctx)
    with app.change(ctx, run_id) as change:
        run = change.save(frame, notes)
    saved = CheckpointSaved(
        frame=frame,
        actions=list(run.checkpoints[frame].actions),
        next_frame=run.next_frame,
        remaining=max(run.frames - len(run.checkpoints), 0),
        complete=run.complete,
    )
    links = checkpoint_links(run.run_id, [frame])
    return call_tool_result(f"Saved frame {frame}. {next_step(run)}", saved, *links)


@tool("Restore a checkpoint", GIVES_UP, icons.CHECKPOINT_ICON, within="paper")
def restore_checkpoint(
    ctx: ToolContext, frame: Frame, run_id: RunId = None
) -> Annotated[CallToolResult, CheckpointRestored]:
    """Go back to a saved frame."""
    app = app_context(ctx)
    with app.change(ctx, run_id) as change:
        run = change.restore(frame, technical=is_technical(ctx))
    restored = CheckpointRestored(
        frame=frame,
        next_attempt=run.next_attempt,
        restore_count=run.restores[frame],
        state=folded_state(app.paper(run)),
        attempts_used=run.used(frame + 1),
        attempts_left=run.attempts_left,
    )
    said = f"Back at frame {frame}, restore {run.restores[frame]} of this checkpoint."
    return call_tool_result(
        " ".join(part for part in (said, next_step(run), attempt_in_words(run)) if part), restored
    )


@tool("Read a checkpoint", LOOKS, icons.CHECKPOINT_ICON, within="paper")
def get_checkpoint_state(
    ctx: ToolContext, frame: Frame, run_id: RunId = None
) -> Annotated[CallToolResult, CheckpointState]:
    """Read a saved state without going back to it."""
    app = app_context(ctx)
    run = app.run(run_id)
    saved = checkpoint_state(app, run, frame)
    text = f"Checkpoint {frame}, reached by {len(saved.actions)} actions."
    return call_tool_result(text, saved, *checkpoint_links(run.run_id, [frame]))


@tool("Show all checkpoints", LOOKS, icons.CHECKPOINT_ICON, within="paper", pictures=True, long=True)
async def generate_checkpoint_overview(
    ctx: ToolContext, images: ImageSize = "full", run_id: RunId = None
) -> Annotated[CallToolResult, CheckpointOverview]:
    """Show photos above and saved diagrams below, one column for each frame."""
    run, place = await aside(_sequence_run, app_context(ctx), run_id)
    columns = [_column(run, frame) for frame in range(1, run.frames + 1)]
    shown: list[AnswerPicture] = []
    if images != "none":
        drawn = await aside(_to_draw, app_context(ctx), run, columns)
        colors = SheetColors(run.front_color, run.back_color)
        picture = await compute_long(
            ctx, "generate_checkpoint_overview", len(drawn), draw_overview, place, colors, drawn
        )
        shown = [AnswerPicture(picture, picture_metas.overview_of_checkpoints())]
    text = f"{len(run.checkpoints)} of {run.frames} frames saved; photos above, saved diagrams below."
    return await aside(picture_result, text, CheckpointOverview(frames=columns), shown, images)


def _sequence_run(app: AppContext, run_id: str | None) -> tuple[RunView, SequencePlace]:
    """The run that a call means, and where its photos are."""
    run = app.run(run_id)
    return run, SequencePlace.of(app.sequence(run))


def _to_draw(app: AppContext, run: RunView, columns: list[OverviewFrame]) -> list[OverviewColumn]:
    """The columns of the picture, with the saved papers."""
    papers = {frame: app.replays.after(run.sheet, saved.path) for frame, saved in run.checkpoints.items()}
    return [
        OverviewColumn(
            each.frame,
            papers.get(each.frame),
            f"frame {each.frame}" + ("" if each.saved else " (not saved)"),
        )
        for each in columns
    ]


def _column(run: RunView, frame: int) -> OverviewFrame:
    """What the overview tells of one frame."""
    saved = run.checkpoints.get(frame)
    return OverviewFrame(
        frame=frame,
        saved=saved is not None,
        notes=saved.notes if saved else None,
        restores=run.restores.get(frame, 0),
        attempts=len(run.attempts.get(frame, ())),
    )
