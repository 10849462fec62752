"""Crease patterns as files: which kinds are read and written, told apart by the name's ending or by how the text begins."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from folding_server.errors import ProgramError
from folding_server.interchange.crease_pattern import crease_pattern_of
from folding_server.interchange.dxf import read_dxf
from folding_server.interchange.fold_format import crease_pattern_document, fold_text, pattern_document
from folding_server.interchange.fold_frames import read_frames
from folding_server.interchange.fold_reading import pattern_frame, read_crease_pattern
from folding_server.interchange.gaps import GAP
from folding_server.interchange.opx import read_opx
from folding_server.interchange.oriedita import read_oriedita
from folding_server.interchange.oripa import oripa_text, read_oripa
from folding_server.interchange.svg_reading import read_svg
from folding_server.simulator import Paper
from folding_server.simulator.foldability import CreasePattern

LINE_READERS: Mapping[str, Callable[[str, float], CreasePattern]] = {
    ".cp": read_oripa,
    ".opx": read_opx,
    ".ori": read_oriedita,
    ".svg": read_svg,
    ".dxf": read_dxf,
}
"""Readers of files that list lines, by the file's ending; FOLD is read apart, for its frames."""
FOLD_ENDINGS = frozenset({".fold", ".json", ""})
UNREAD_FILES: Mapping[str, str] = {
    ".orh": "Orihime; open it in Oriedita and export FOLD or .cp",
    ".tmd5": "TreeMaker; export the crease pattern as DXF or SVG",
    ".tmd4": "TreeMaker; export the crease pattern as DXF or SVG",
    ".pdf": "a page; export the drawing as SVG",
    ".ai": "Illustrator; export SVG",
    ".eps": "PostScript; export SVG",
    ".dwg": "AutoCAD; save it as ASCII DXF",
    ".png": "an image; a crease pattern has to be drawn as lines, in FOLD, .cp or SVG",
    ".jpg": "an image; a crease pattern has to be drawn as lines, in FOLD, .cp or SVG",
    ".jpeg": "an image; a crease pattern has to be drawn as lines, in FOLD, .cp or SVG",
    ".gif": "an image; a crease pattern has to be drawn as lines, in FOLD, .cp or SVG",
    ".obj": "a mesh; export FOLD",
    ".stl": "a mesh; export FOLD",
}
"""Files that people have and that are not read, with what to save instead."""
READ = "FOLD (.fold), .cp, .opx, .ori, .svg or .dxf"


@dataclass(frozen=True)
class ReadPattern:
    """A crease pattern with the frame that it stands in, from 1, of how many, and the frame's classes; 1 of 1 for lines."""

    pattern: CreasePattern
    frame: int = 1
    frames: int = 1
    classes: tuple[str, ...] = ()

    @property
    def prefix(self) -> str:
        """Which frame an answer is of, in words; empty where there is one only."""
        kind = f" ({', '.join(self.classes)})" if self.classes else ""
        return f"Frame {self.frame} of {self.frames}{kind}: " if self.frames > 1 else ""


def pattern_text(paper: Paper, ending: str, title: str | None = None) -> str:
    """The crease pattern of a paper: a drawing for ``.svg``, ORIPA's lines for ``.cp``, else FOLD with the title."""
    if ending.lower() in {".svg", ".cp"}:
        return written_pattern(crease_pattern_of(paper), ending)
    return fold_text(crease_pattern_document(paper, title))


def written_pattern(pattern: CreasePattern, ending: str) -> str:
    """A crease pattern as text for a file with this ending. ProgramError if that is not written."""
    match ending.lower():
        case ".svg":
            from folding_server.interchange.crease_pattern_svg import crease_pattern_svg

            return crease_pattern_svg(pattern, legend=True)
        case ".cp":
            return oripa_text(pattern)
        case ".fold" | ".json":
            return fold_text(pattern_document(pattern))
    raise ProgramError(
        f"Crease patterns are written as .fold, .cp or .svg, not as {ending[:20]!r}; choose one of these."
    )


def read_pattern(text: str, ending: str, gap: float = GAP) -> CreasePattern:
    """The crease pattern in the text of a file with this ending. ProgramError if it holds none."""
    return read_patterns(text, ending, gap=gap)[0].pattern


def read_patterns(
    text: str, ending: str, frame: int | Literal["all"] | None = None, gap: float = GAP
) -> list[ReadPattern]:
    """The crease pattern of a file with this ending, or of each frame of a FOLD file.

    ``frame`` counts from 1, the key frame; None is the frame that holds the crease pattern. ``gap`` is how far, in units of the
    longer side, ends of lines may miss what they are joined to. ProgramError if the file holds no such pattern.
    """
    kind = ending.lower()
    if kind in LINE_READERS:
        if frame not in {None, 1, "all"}:
            raise ProgramError(f"A {kind} file has one frame; leave the frame out.")
        return [ReadPattern(LINE_READERS[kind](text, gap))]
    require_read(ending)
    frames = read_frames(text)
    if frame == "all":
        chosen: list[int] = list(range(1, len(frames) + 1))
    else:
        chosen = [pattern_frame(frames) + 1 if frame is None else frame]
    return [
        ReadPattern(
            read_crease_pattern(text, None if frame is None else number, gap),
            number,
            len(frames),
            tuple(frames[number - 1].frame_classes) if number <= len(frames) else (),
        )
        for number in chosen
    ]


def require_read(ending: str) -> None:
    """ProgramError, which says what to save instead, if files with this ending are not read."""
    kind = ending.lower()
    if kind in LINE_READERS or kind in FOLD_ENDINGS:
        return
    what = UNREAD_FILES.get(kind)
    raise ProgramError(
        f"{kind} files are not read: that is {what}."
        if what
        else f"{kind[:20]!r} is no kind of file that is read; give {READ}."
    )


def ending_of_text(text: str) -> str:
    """The ending that a file with this text should have: by its first sign."""
    start = text.lstrip("\ufeff \t\r\n")[:4000]
    if start.startswith("<"):
        return ".svg" if "<svg" in start else ".opx"
    if start.startswith("{"):
        return ".ori" if '"lineSegments"' in text else ".fold"
    if start[:1] == "0" and start[1:].lstrip().startswith("SECTION"):
        return ".dxf"
    return ".cp"
