"""Verification: the evidence for a critic, the comparison with a photo, and flat-foldability."""

from typing import Annotated

from folding_schemas.results import Comparison, CriticGrid, Foldability
from mcp.types import CallToolResult

from folding_server.errors import RunError
from folding_server.simulator import folded_state
from folding_server.store.views import RunView
from folding_server.tools.answers import answer
from folding_server.tools.arguments import Frame, LaterFrame, RunId
from folding_server.tools.desk import Call, desk_of
from folding_server.tools.pictures import diagram
from folding_server.tools.standing import checkpoint_at


def critic_grid(call: Call, frame: LaterFrame, run_id: RunId = None) -> Annotated[CallToolResult, CriticGrid]:
    """Gather what a critic needs to judge the current state as a frame's."""
    desk = desk_of(call)
    run = desk.run(run_id)
    photos = desk.sequence(run)
    shown = photos.photo_for_model(frame - 1), photos.photo_for_model(frame)
    source_path = checkpoint_at(run, frame - 1).path
    _check_grown_from(run, frame)
    source, candidate = desk.papers.after(run.sheet, source_path), desk.paper(run)
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
    return answer(text, grid, *shown, diagram(run, source), diagram(run, candidate))


def _check_grown_from(run: RunView, frame: int) -> None:
    """Raise RunError unless the current state is a candidate for the frame: one step from the frame before, or saved."""
    if run.base not in (frame - 1, frame):
        raise RunError(
            f"The current state grew from checkpoint {run.base}, so it is no candidate for frame {frame}; "
            f"call restore_checkpoint({frame - 1}) and act from there."
        )


def compare_to_frame(call: Call, frame: Frame, run_id: RunId = None) -> Annotated[CallToolResult, Comparison]:
    """Measure how well the current state explains a photo."""
    raise NotImplementedError


def check_foldability(call: Call, run_id: RunId = None) -> Annotated[CallToolResult, Foldability]:
    """Check whether the crease pattern can be folded flat."""
    raise NotImplementedError
