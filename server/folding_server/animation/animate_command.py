"""``foldingagent-server animate``: a program or a run as a film, or as a page to step through."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from folding_server.command_options import Data, Database, ModelSource, Sequences
from folding_server.instructions.instructions_command import WordsLanguage
from folding_server.typed_path import typed_path

_Out = Annotated[
    Path,
    typer.Option(
        "--out",
        "-o",
        metavar="FILE",
        parser=typed_path,
        help="The film to write: by its ending .mp4, .webm, .gif or .html.",
    ),
]
_View = Annotated[
    Literal["tilted", "straight"],
    typer.Option("--view", help="From a little in front, or from straight above."),
]
_Poster = Annotated[
    Path | None,
    typer.Option(metavar="FILE", parser=typed_path, help="Write a PNG of the finished model too."),
]


def animate(
    source: ModelSource,
    out: _Out,
    view: _View = "tilted",
    poster: _Poster = None,
    language: WordsLanguage = "en",
    data: Data = None,
    database: Database = None,
    sequences: Sequences = None,
) -> None:
    """Show a program or a run being folded, flaps swinging about their creases."""
    from folding_server.animation.film_files import poster_png, write_film
    from folding_server.errors import FoldingError
    from folding_server.instructions.moves import lesson_of
    from folding_server.view.model_source import asked_model
    from folding_server.wording.sheet_words import lesson_words

    model = asked_model(source, data, database, sequences or ())
    lesson = lesson_of(model.program)
    words = [each.text for each in lesson_words(lesson, language)]
    write_film(lesson, words, out, view, language)
    typer.echo(f"wrote {out}")
    if poster:
        poster.write_bytes(poster_png(lesson, words, view))
        typer.echo(f"wrote {poster}")
    if lesson.refusal:
        raise FoldingError(f"The film shows what comes before it: {lesson.refusal}")
