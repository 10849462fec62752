"""``foldingagent-server instructions``: a program or a run as a sheet of folding instructions."""

import base64
from pathlib import Path
from typing import Annotated, Literal

import typer

from folding_server.command_options import Data, Database, ModelSource, Sequences
from folding_server.typed_path import typed_path

_Out = Annotated[
    Path,
    typer.Option(
        "--out",
        "-o",
        metavar="FILE",
        parser=typed_path,
        help="The sheet to write: by its ending .pdf, .svg or .html, or .txt for its words alone.",
    ),
]
_Page = Annotated[Literal["a4", "letter"], typer.Option("--page", help="The size of the pages.")]
_Columns = Annotated[int, typer.Option(min=2, max=4, metavar="N", help="Columns of steps, 2 to 4.")]
WordsLanguage = Annotated[Literal["en", "de", "ja"], typer.Option(help="The language of the words.")]
_Photos = Annotated[bool, typer.Option("--photos", help="Put the photo of each state beside its drawing.")]


def instructions(
    source: ModelSource,
    out: _Out,
    page: _Page = "a4",
    columns: _Columns = 3,
    photos: _Photos = False,
    language: WordsLanguage = "en",
    data: Data = None,
    database: Database = None,
    sequences: Sequences = None,
) -> None:
    """Draw a program or a run as numbered steps to fold by."""
    from folding_server.errors import FoldingError
    from folding_server.instructions.moves import lesson_of
    from folding_server.instructions.sheet_files import sheet_content
    from folding_server.instructions.sheet_layout import SheetForm
    from folding_server.view.model_source import asked_model
    from folding_server.wording.repeats import with_repeats

    model = asked_model(source, data, database, sequences or ())
    lesson = with_repeats(lesson_of(model.program))
    pictures = {} if lesson.refusal or not photos else _jpegs(model.photos())
    content = sheet_content(lesson, out.suffix, SheetForm(page, columns), pictures, language)
    try:
        out.write_bytes(content)
    except OSError as error:
        raise FoldingError(f"{out} cannot be written ({error.strerror}); give another file.") from error
    typer.echo(f"wrote {out}")
    if lesson.refusal:
        raise FoldingError(f"The sheet shows what comes before it: {lesson.refusal}")


def _jpegs(urls: dict[int, str]) -> dict[int, bytes]:
    """Photos out of their data URLs."""
    return {frame: base64.b64decode(url.partition(",")[2]) for frame, url in urls.items()}
