"""The addresses under which a run's parts can be read, and links to them in answers."""

from collections.abc import Iterable

from mcp.types import ResourceLink

from folding_server.mcp import icons

SEQUENCE_LIST = "folding://sequences"
RUN_LIST = "folding://runs"
RUN = "folding://runs/{run_id}"
STATE = RUN + "/state"
PROGRAM = RUN + "/program"
DIAGRAM_SVG = RUN + "/diagram.svg"
DIAGRAM_PNG = RUN + "/diagram.png"
MODEL = RUN + "/model.fold"
CREASE_PATTERN = RUN + "/crease_pattern.fold"
CREASE_PATTERN_SVG = RUN + "/crease_pattern.svg"
CHECKPOINT = RUN + "/checkpoints/{frame}"
VERTEX = RUN + "/vertices/{vertex}"

JSON = "application/json"

_CURRENT = (STATE, PROGRAM, DIAGRAM_SVG, DIAGRAM_PNG, MODEL, CREASE_PATTERN, CREASE_PATTERN_SVG)
_LINKED = (
    (MODEL, "model.fold", "Folded model (FOLD)"),
    (CREASE_PATTERN, "crease_pattern.fold", "Crease pattern (FOLD)"),
    (PROGRAM, "program.json", "Folding program"),
)


def changed_addresses(run_id: str, frames: Iterable[int] = ()) -> list[str]:
    """What reads otherwise when a run has changed and the checkpoints of ``frames`` with it."""
    current = [address.format(run_id=run_id) for address in (RUN, *_CURRENT)]
    saved = [CHECKPOINT.format(run_id=run_id, frame=frame) for frame in frames]
    return [RUN_LIST, *current, *saved]


def run_of(uri: str) -> str | None:
    """The id of the run that an address belongs to; None if it is of no run."""
    before = RUN.partition("{")[0]
    return uri.removeprefix(before).partition("/")[0] if uri.startswith(before) else None


def file_links(run_id: str) -> list[ResourceLink]:
    """Links to the FOLD file, the crease pattern and the program of a run's current state."""
    return [_link(address.format(run_id=run_id), name, title) for address, name, title in _LINKED]


def checkpoint_links(run_id: str, frames: Iterable[int]) -> list[ResourceLink]:
    """Links to the checkpoints of frames."""
    return [
        _link(
            CHECKPOINT.format(run_id=run_id, frame=frame),
            f"checkpoint_{frame}.json",
            f"Checkpoint of frame {frame}",
        )
        for frame in frames
    ]


def _link(uri: str, name: str, title: str) -> ResourceLink:
    return ResourceLink(uri=uri, name=name, title=title, mime_type=JSON, icons=[icons.FILE_ICON])
