"""Every export format of the server behind one function."""

import re
from dataclasses import dataclass

from folding_schemas.actions import Program
from folding_schemas.results import ExportFormat

from folding_server.diagram import Colors, draw_svg, rasterise
from folding_server.diagram.palette import DEFAULT_COLORS
from folding_server.errors import ProgramError
from folding_server.interchange.crease_pattern import crease_pattern_of
from folding_server.interchange.crease_pattern_svg import crease_pattern_svg
from folding_server.interchange.fold_format import crease_pattern_document, fold_document, fold_text
from folding_server.interchange.obj import obj_text
from folding_server.interchange.oripa import oripa_text
from folding_server.interchange.programs import program_text
from folding_server.interchange.step_files import steps_document
from folding_server.simulator import Paper

EXPORT_FILES: dict[ExportFormat, tuple[str, str]] = {
    "fold": ("application/json", ".fold"),
    "crease-pattern": ("application/json", "-crease-pattern.fold"),
    "crease-pattern-svg": ("image/svg+xml", "-crease-pattern.svg"),
    "cp": ("text/plain", ".cp"),
    "svg": ("image/svg+xml", ".svg"),
    "png": ("image/png", ".png"),
    "obj": ("model/obj", ".obj"),
    "program": ("application/json", ".json"),
    "steps": ("application/json", "-steps.fold"),
}
"""Format -> media type and how the file's name ends."""


@dataclass(frozen=True)
class ExportedFile:
    """A file ready to be written or sent: text, or bytes for a PNG."""

    format: ExportFormat
    media_type: str
    filename: str
    content: str | bytes


def export(
    paper: Paper, file_format: ExportFormat, colors: Colors = DEFAULT_COLORS, program: Program | None = None
) -> ExportedFile:
    """The paper (or the program that made it) in one of the formats. The file is named after the program.

    ProgramError for an unknown format, or for the program of a paper that has none.
    """
    if file_format not in EXPORT_FILES:
        raise ProgramError(
            f"There is no export format {file_format!r}; the formats are {', '.join(EXPORT_FILES)}."
        )
    media_type, ending = EXPORT_FILES[file_format]
    name = program.name if program else "model"
    return ExportedFile(
        file_format, media_type, _stem(name) + ending, _content(paper, file_format, colors, program)
    )


def _content(paper: Paper, file_format: ExportFormat, colors: Colors, program: Program | None) -> str | bytes:
    title = program.name if program else None
    match file_format:
        case "fold":
            return fold_text(fold_document(paper, title))
        case "crease-pattern":
            return fold_text(crease_pattern_document(paper, title))
        case "crease-pattern-svg":
            return crease_pattern_svg(crease_pattern_of(paper), legend=True)
        case "cp":
            return oripa_text(crease_pattern_of(paper))
        case "svg":
            return draw_svg(paper, colors)
        case "png":
            return rasterise(draw_svg(paper, colors))
        case "obj":
            return obj_text(paper)
        case "program" if program is not None:
            return program_text(program)
        case "steps" if program is not None:
            return fold_text(steps_document(program))
    raise ProgramError(
        "This paper was not made by a program, so there is none to export; use another format."
    )


def _stem(name: str) -> str:
    """A name as a safe file name."""
    return re.sub(r"[^\w.-]+", "-", name).strip("-.") or "model"
