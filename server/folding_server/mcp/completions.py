"""Completing what a user types for a prompt or a resource's address: sequences, runs, frames and vertices."""

from collections.abc import Iterable, Mapping

from mcp.types import Completion

from folding_server.errors import FoldingError
from folding_server.mcp.context import AppContext
from folding_server.mcp.services.run_list import MOST_LISTED, newest_ids
from folding_server.simulator import folded_state


def completion(app: AppContext, argument: str, start: str, chosen: Mapping[str, str]) -> Completion:
    """The values of an argument that start like this, given the arguments chosen before; none where they cannot be told."""
    try:
        values = [value for value in _values(app, argument, chosen) if value.startswith(start)]
    except FoldingError:
        values = []
    return Completion(values=values[:MOST_LISTED], total=len(values), has_more=len(values) > MOST_LISTED)


def _values(app: AppContext, argument: str, chosen: Mapping[str, str]) -> Iterable[str]:
    """All values of an argument. FoldingError where the run or the sequence chosen is not there."""
    match argument:
        case "sequence" | "name":
            return [each.name for each in app.library.sequences()]
        case "run_id":
            return newest_ids(app)
        case "frame":
            return map(str, _frames(app, chosen))
        case "vertex":
            return folded_state(app.paper(app.run(chosen.get("run_id")))).vertices
        case _:
            return ()


def _frames(app: AppContext, chosen: Mapping[str, str]) -> Iterable[int]:
    """The frames of the sequence chosen; else the saved ones of the run chosen; else those of the run opened last."""
    if (name := chosen.get("name") or chosen.get("sequence")) is not None:
        return range(1, app.library.open(name).frame_count + 1)
    if (run_id := chosen.get("run_id")) is not None:
        return sorted(app.run(run_id).checkpoints)
    return range(2, app.run(None).frames + 1)
