"""Crease patterns as files of three kinds, told apart by how the file's name ends: FOLD, SVG, and .cp."""

from folding_server.interchange.crease_pattern import crease_pattern_of
from folding_server.interchange.crease_pattern_svg import crease_pattern_svg
from folding_server.interchange.fold_format import crease_pattern_document, fold_text
from folding_server.interchange.fold_reading import read_crease_pattern
from folding_server.interchange.oripa import oripa_text, read_oripa
from folding_server.simulator import Paper
from folding_server.simulator.foldability import CreasePattern


def pattern_text(paper: Paper, ending: str, title: str | None = None) -> str:
    """The crease pattern of a paper: a drawing for ``.svg``, ORIPA's lines for ``.cp``, else FOLD with the title."""
    match ending.lower():
        case ".svg":
            return crease_pattern_svg(crease_pattern_of(paper), legend=True)
        case ".cp":
            return oripa_text(crease_pattern_of(paper))
    return fold_text(crease_pattern_document(paper, title))


def read_pattern(text: str, ending: str) -> CreasePattern:
    """The crease pattern in the text of a file: of ORIPA or Oriedita for ``.cp``, else FOLD. ProgramError if it is not."""
    return read_oripa(text) if ending.lower() == ".cp" else read_crease_pattern(text)


def place_in_file(pattern: CreasePattern, vertex: int, ending: str) -> str:
    """Where the file that a pattern was read from has a vertex, named as messages name it: ``(x, y)``."""
    x, y = pattern.vertices_coords[pattern.names.index(vertex) if pattern.names else vertex]
    return f"({x:.6g}, {-y + 0.0 if ending.lower() == '.cp' else y:.6g})"
