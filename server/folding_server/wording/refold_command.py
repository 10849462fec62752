"""``foldingagent-server refold``: the words of a sheet of instructions back as a program."""

from pathlib import Path
from typing import Annotated

import typer

from folding_server.typed_path import typed_path

_Words = Annotated[
    Path,
    typer.Argument(
        metavar="WORDS",
        parser=typed_path,
        help="A text file with the English words of each step, a line each.",
    ),
]
_Out = Annotated[
    Path, typer.Option("--out", "-o", metavar="FILE", parser=typed_path, help="The program (JSON) to write.")
]


def refold(words: _Words, out: _Out) -> None:
    """Fold what words say and write it as a program."""
    from folding_server.errors import FoldingError
    from folding_server.interchange.programs import program_text
    from folding_server.typed_text import text_in
    from folding_server.wording.reading import program_in_words

    program = program_in_words(text_in(words, "give the path of a text file"), words.stem)
    try:
        out.write_text(program_text(program), encoding="utf-8")
    except OSError as error:
        raise FoldingError(f"{out} cannot be written ({error.strerror}); give another file.") from error
    typer.echo(f"wrote {out}")
