"""The files that a sheet can be written as, by the ending of their names."""

from collections.abc import Mapping
from dataclasses import replace

from folding_server.errors import FoldingError
from folding_server.instructions.moves import Lesson, MoveKind
from folding_server.instructions.sheet_html import sheet_html
from folding_server.instructions.sheet_layout import SheetForm, StepWords, lay_out, sheet_steps
from folding_server.instructions.sheet_pdf import sheet_pdf
from folding_server.instructions.sheet_svg import sheet_svg

SHEET_ENDINGS = (".pdf", ".svg", ".html")


def sheet_content(lesson: Lesson, ending: str, form: SheetForm, photos: Mapping[int, bytes]) -> bytes:
    """The sheet of a lesson as a file. FoldingError for an ending that is none of SHEET_ENDINGS."""
    words = plain_words(lesson)
    match ending.lower():
        case ".pdf":
            return sheet_pdf(lay_out(lesson, words, form, photos))
        case ".svg":
            return sheet_svg(lay_out(lesson, words, replace(form, endless=True), photos)).encode()
        case ".html":
            steps = sheet_steps(lesson, words, form.column_width, photos)
            return sheet_html(lesson.program.name, steps, form.column_width).encode()
    raise FoldingError(
        f"A sheet cannot be written as {ending!r}; end the file's name in {', '.join(SHEET_ENDINGS)}."
    )


PLAIN: dict[MoveKind, str] = {
    "fold": "Fold along the line.",
    "fold-behind": "Fold behind along the line.",
    "fold-and-unfold": "Fold along the line and unfold.",
    "unfold": "Unfold.",
    "turn-over": "Turn the paper over.",
    "rotate": "Rotate the paper.",
    "mark": "Mark the points.",
}


def plain_words(lesson: Lesson) -> list[StepWords]:
    """The least that is to be said."""
    return [
        *(StepWords(PLAIN[move.kind], {}) for move in lesson.moves),
        StepWords(f"The finished {lesson.program.name}.", {}),
    ]
