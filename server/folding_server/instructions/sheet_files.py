"""The files that a sheet can be written as, by the ending of their names."""

from collections.abc import Mapping
from dataclasses import replace

from folding_server.errors import FoldingError
from folding_server.instructions.moves import Lesson
from folding_server.instructions.sheet_html import sheet_html
from folding_server.instructions.sheet_layout import SheetForm, lay_out, sheet_steps
from folding_server.instructions.sheet_pdf import sheet_pdf
from folding_server.instructions.sheet_svg import sheet_svg
from folding_server.wording.sentences import Language
from folding_server.wording.sheet_words import lesson_words, numbered_lines

SHEET_ENDINGS = (".pdf", ".svg", ".html", ".txt")


def sheet_content(
    lesson: Lesson, ending: str, form: SheetForm, photos: Mapping[int, bytes], language: Language = "en"
) -> bytes:
    """The sheet of a lesson as a file, or its words alone as text. FoldingError for an ending that is none of SHEET_ENDINGS."""
    words = lesson_words(lesson, language)
    match ending.lower():
        case ".pdf":
            return sheet_pdf(lay_out(lesson, words, form, photos))
        case ".svg":
            return sheet_svg(lay_out(lesson, words, replace(form, endless=True), photos)).encode()
        case ".html":
            steps = sheet_steps(lesson, words, form.column_width, photos)
            return sheet_html(lesson.title, steps, form.column_width, language).encode()
        case ".txt":
            return numbered_lines(words).encode()
    raise FoldingError(
        f"A sheet cannot be written as {ending!r}; end the file's name in {', '.join(SHEET_ENDINGS)}."
    )
