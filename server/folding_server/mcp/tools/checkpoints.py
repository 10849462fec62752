"""Checkpoints: saving and restoring frames, reading what is saved, the overview of photos and diagrams."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

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
from folding_server.mcp.context import ToolContext, app_context
from folding_server.mcp.parameters import Frame, ImageSize, RunId
from folding_server.mcp.results import AnswerPicture, call_tool_result, picture_result
from folding_server.mcp.services import picture_metas
from folding_server.mcp.services.images import SMALL_SIZE, diagram, overview
from folding_server.mcp.services.run_addresses import checkpoint_links
from folding_server.mcp.services.run_status import checkpoint_state, next_step
from folding_server.mcp.tool_progress import ToolProgress
from folding_server.mcp.tool_record import ADDS, GIVES_UP, LOOKS, tool
from folding_server.simulator import folded_state
from folding_server.store.views import RunView

if TYPE_CHECKING:
    from folding_server.frames.sequences import Sequence

Notes = Annotated[str | None, Field(description="a remark to keep with the checkpoint, in words")]


@tool("Save a checkpoint", ADDS, icons.CHECKPOINT_ICON, within="paper")
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
        run = change.restore(frame)
    restored = CheckpointRestored(
        frame=frame,
        next_attempt=run.next_attempt,
        restore_count=run.restores[frame],
        state=folded_state(app.paper(run)),
    )
    return call_tool_result(
        f"Back at frame {frame}, restore {run.restores[frame]} of this checkpoint. {next_step(run)}", restored
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


@tool("Show all checkpoints", LOOKS, icons.CHECKPOINT_ICON, within="paper", pictures=True)
def generate_checkpoint_overview(
    ctx: ToolContext, images: ImageSize = "full", run_id: RunId = None
) -> Annotated[CallToolResult, CheckpointOverview]:
    """Show photos above and saved diagrams below, one column for each frame."""
    app = app_context(ctx)
    run = app.run(run_id)
    photos = app.sequence(run)
    columns = [_column(run, frame) for frame in range(1, run.frames + 1)]
    text = f"{len(run.checkpoints)} of {run.frames} frames saved; photos above, saved diagrams below."
    shown = _overview(ctx, run, photos, columns)
    return picture_result(text, CheckpointOverview(frames=columns), shown, images)


def _overview(
    ctx: ToolContext, run: RunView, photos: "Sequence", columns: list[OverviewFrame]
) -> Iterator[AnswerPicture]:
    """Photos above, saved states below."""
    app, progress = app_context(ctx), ToolProgress(ctx, total=len(columns))
    pixels, diagrams = [], []
    for column in columns:
        progress.step(f"frame {column.frame}")
        pixels.append(photos.source.read(photos.index(column.frame), SMALL_SIZE))
        saved = run.checkpoints.get(column.frame)
        paper = app.replays.after(run.sheet, saved.path) if saved else None
        diagrams.append(diagram(run, paper, size=SMALL_SIZE) if paper else None)
    captions = [f"frame {each.frame}" + ("" if each.saved else " (not saved)") for each in columns]
    yield AnswerPicture(overview(pixels, diagrams, captions), picture_metas.overview_of_checkpoints())


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
