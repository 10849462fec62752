"""Verification: the evidence for a critic, the comparison with a photo, and flat-foldability."""

from collections.abc import Iterator
from collections.abc import Sequence as ListOf
from typing import TYPE_CHECKING, Annotated

from folding_schemas.pictures import PictureMeta
from folding_schemas.results import Comparison, CriticGrid, Foldability
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.errors import RunError
from folding_server.mcp import icons
from folding_server.mcp.context import ToolContext, app_context
from folding_server.mcp.parameters import READ_WHOLE, Frame, ImageSize, LaterFrame, RunId
from folding_server.mcp.results import AnswerPicture, call_tool_result, picture_result
from folding_server.mcp.services import picture_metas, presenters
from folding_server.mcp.services.images import diagram, photo_beside_others
from folding_server.mcp.services.run_status import checkpoint_at
from folding_server.mcp.tool_progress import ToolProgress
from folding_server.mcp.tool_record import LOOKS, tool
from folding_server.simulator import Paper, folded_state
from folding_server.store.rules import find_attempt
from folding_server.store.views import RunView

if TYPE_CHECKING:
    from folding_server.frames.sequences import Sequence
    from folding_server.vision.comparison import Match
    from folding_server.vision.outline import Outline
    from folding_server.vision.seeing import SeenFrame

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


@tool("Compare with a frame", LOOKS, icons.CHECK_ICON, within="standard", pictures=True)
def compare_to_frame(
    ctx: ToolContext,
    frame: Frame,
    attempt: AttemptNumber = None,
    images: ImageSize = "full",
    run_id: RunId = None,
) -> Annotated[CallToolResult, Comparison]:
    """Measure how well the current state, or what an attempt at the frame came to, explains a photo."""
    from folding_server.vision.comparison import compare  # noqa: PLC0415  (loads OpenCV)

    app = app_context(ctx)
    run = app.run(run_id)
    photos = app.sequence(run)
    photos.require(frame)
    actions = run.actions if attempt is None else find_attempt(run, frame, attempt).path
    paper = app.replays.after(run.sheet, actions)
    progress = ToolProgress(ctx, total=2)
    progress.step("finding the sheet in the photos")
    with app.observing(photos) as eyes:
        progress.step(f"comparing with frame {frame}")
        seen = eyes.frame(frame)
        match = compare(paper, seen)
        outlines = eyes.outlines(frame)
    found = presenters.comparison(seen, match, outlines)
    said = _in_words(found)
    shown = _overlay(paper, seen, match, outlines, picture_metas.overlay_on(frame, attempt))
    return picture_result(said if attempt is None else f"Attempt {attempt}: {said}", found, shown, images)


def _overlay(
    paper: Paper, seen: "SeenFrame", match: "Match", outlines: "ListOf[Outline]", meta: PictureMeta
) -> Iterator[AnswerPicture]:
    """The paper drawn over the photo."""
    from folding_server.frames.image_files import encode_for_model  # noqa: PLC0415
    from folding_server.vision.overlay import draw_overlay  # noqa: PLC0415  (loads OpenCV)

    yield AnswerPicture(encode_for_model(draw_overlay(paper, seen, match, outlines=outlines)), meta)


@tool("Check flat-foldability", LOOKS, icons.CHECK_ICON)
def check_foldability(ctx: ToolContext, run_id: RunId = None) -> Annotated[CallToolResult, Foldability]:
    """Check whether the crease pattern can be folded flat."""
    from folding_server.simulator.foldability import check_paper  # noqa: PLC0415  (loads shapely)

    app = app_context(ctx)
    found = presenters.foldability(check_paper(app.paper(app.run(run_id))))
    return call_tool_result(found.reason, found)


def _in_words(found: Comparison) -> str:
    """The verdict and what disagrees."""
    said = f"{found.verdict} with frame {found.frame}: {found.agreement:.1%} of the paper agrees."
    return " ".join([said, *(f"{each}." for each in found.discrepancies)])
