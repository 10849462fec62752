"""``foldingagent-server check`` and ``convert``: crease patterns in files."""

import json
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from folding_server.command_options import Json, file_to_write
from folding_server.errors import FoldingError
from folding_server.pattern_text import pattern_text_in
from folding_server.progress_line import ProgressLine
from folding_server.typed_path import typed_path

if TYPE_CHECKING:
    from folding_schemas.foldability_results import Foldability

    from folding_server.interchange.pattern_files import ReadPattern
    from folding_server.simulator.foldability import Counting, FoldabilityReport

BRIEFLY = 0.5
"""Seconds for which layer orders are counted when nobody asks for their number."""

_PatternPath = Annotated[
    Path,
    typer.Argument(
        metavar="FILE", parser=typed_path, help="A crease pattern as FOLD, .cp, .opx, .ori, .svg or .dxf."
    ),
]
_Gap = Annotated[
    float,
    typer.Option(
        metavar="SHARE",
        min=0.0,
        max=0.05,
        help="How far ends of lines may miss what they meet and be joined to it, in units of the longer side.",
    ),
]
_Frame = Annotated[
    str | None,
    typer.Option(
        metavar="N|all",
        help="The frame of a FOLD file, 1 for its key frame; left out, that of its crease pattern.",
    ),
]
_Count = Annotated[bool, typer.Option("--count", help="Count all layer orders, however long it takes.")]
_MostOrders = Annotated[
    int | None,
    typer.Option(
        "--limit", metavar="N", min=1, help="Count up to N orders of each part that depends on no other."
    ),
]
_Time = Annotated[
    float | None, typer.Option("--time", metavar="SECONDS", min=0.0, help="Stop counting after so long.")
]
_Svg = Annotated[Path | None, file_to_write("the pattern as SVG, its faults and joined ends marked")]
GAP_OF_READERS = 0.002
"""What readers join when they are not told otherwise (``interchange.gaps.GAP``, which loads shapely)."""


def check(
    pattern: _PatternPath,
    svg: _Svg = None,
    gap: _Gap = GAP_OF_READERS,
    frame: _Frame = None,
    count: _Count = False,
    limit: _MostOrders = None,
    time: _Time = None,
    as_json: Json = False,
) -> None:
    """Check whether a crease pattern folds flat; exit 1 if it does not."""
    from folding_server.interchange.pattern_files import read_patterns, require_read
    from folding_server.mcp.services.presenters import foldability
    from folding_server.simulator.foldability import check_pattern

    asked = _asked_frame(frame)
    counting = _counting(count=count, limit=limit, seconds=time)
    require_read(pattern.suffix)
    reads = read_patterns(pattern_text_in(pattern), pattern.suffix, asked, gap)
    reports = [check_pattern(read.pattern, counting=counting) for read in reads]
    answers = [foldability(report, read) for report, read in zip(reports, reads, strict=True)]
    if svg:
        _draw(svg, reads, reports)
    if as_json:
        documents = [answer.model_dump(mode="json") for answer in answers]
        typer.echo(json.dumps(documents if asked == "all" else documents[0], indent=1))
    else:
        for answer in answers:
            _say(answer)
    if not all(answer.foldable for answer in answers):
        raise typer.Exit(1)


def convert(
    pattern: _PatternPath,
    out: Annotated[
        Path, typer.Argument(metavar="OUT", parser=typed_path, help="What to write, as .fold, .cp or .svg.")
    ],
    gap: _Gap = GAP_OF_READERS,
    frame: _Frame = None,
    as_json: Json = False,
) -> None:
    """Write a crease pattern in another format."""
    from folding_server.interchange.pattern_files import read_patterns, require_read, written_pattern
    from folding_server.mcp.services.presenters import notes_of

    asked = _asked_frame(frame)
    if asked == "all":
        raise FoldingError("One frame is converted at a time; give --frame a number, 1 for the key frame.")
    require_read(pattern.suffix)
    (read,) = read_patterns(pattern_text_in(pattern), pattern.suffix, asked, gap)
    _write(out, written_pattern(read.pattern, out.suffix))
    edges = len(read.pattern.edges_vertices)
    if as_json:
        typer.echo(json.dumps({"written": str(out), "edges": edges, "notes": notes_of(read)}, indent=1))
    else:
        for note in notes_of(read):
            typer.echo(note)
        typer.echo(f"wrote {edges} edges to {out}")


def _asked_frame(frame: str | None) -> int | Literal["all"] | None:
    if frame is None or frame == "all":
        return frame  # type: ignore[return-value]
    with suppress(ValueError):
        return int(frame)
    raise typer.BadParameter(f"{frame!r} is no frame; give a number from 1, or all")


def _counting(*, count: bool, limit: int | None, seconds: float | None) -> "Counting":
    from folding_server.simulator.foldability import Counting

    if not (count or limit or seconds is not None):
        return Counting(seconds=BRIEFLY)
    progress = ProgressLine("counting")
    return Counting(limit, seconds, lambda done, whole, _: progress.tell(done / whole))


def _say(answer: "Foldability") -> None:
    """The answer in words: the reason, each fault with its places, and what was read otherwise than it stands."""
    typer.echo(answer.reason)
    for fault in answer.faults if len(answer.faults) > 1 or len(answer.violations) else ():
        at = ", ".join(f"({', '.join(f'{c:.6g}' for c in place)})" for place in fault.places)
        names = f"vertex {fault.vertices[0]} at {at}: " if len(fault.vertices) == 1 else ""
        typer.echo(f"{names}{fault.kind}: {fault.detail}")
    for note in answer.notes:
        typer.echo(f"note: {note}")


def _draw(file: Path, reads: "list[ReadPattern]", reports: "list[FoldabilityReport]") -> None:
    """The pattern of the first frame that does not fold flat, else of the first, with marks."""
    from folding_server.interchange.fault_svg import marked_svg

    k = next((k for k, report in enumerate(reports) if not report.foldable), 0)
    _write(file, marked_svg(reads[k].pattern, reports[k].faults))


def _write(file: Path, text: str) -> None:
    try:
        file.write_text(text, encoding="utf-8")
    except OSError as error:
        raise FoldingError(
            f"{file} cannot be written ({error.strerror}); give a file in a folder that can."
        ) from error
