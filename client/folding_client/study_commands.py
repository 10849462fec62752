"""The commands ``foldingagent study`` and ``foldingagent study-score``."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from folding_client import options
from folding_client.exits import finish

DEFAULT_STUDY = Path("study")
DEFAULT_QUESTIONS = 30
"""Questions that take a participant about ten minutes; the paper's 600 judgements are 60 for each of 10 sequences."""


_First = Annotated[
    Path, typer.Argument(metavar="RUNS_A", parser=options.path, help="Folder of runs, one a sequence.")
]
_Second = Annotated[
    Path, typer.Argument(metavar="RUNS_B", parser=options.path, help="The runs to compare them with.")
]
_Truth = Annotated[
    Path, typer.Option(parser=options.path, help="Folder of the sequences, whose photos are shown.")
]
_Out = Annotated[Path, typer.Option("--out", "-o", parser=options.path, help="Folder of the site.")]
_Key = Annotated[
    Path | None,
    typer.Option(
        parser=options.path, help="File that tells the sides; OUT.key.json beside the site if left out."
    ),
]
_Questions = Annotated[int, typer.Option(min=1, help="Most questions, drawn evenly over the sequences.")]
_Last = Annotated[bool, typer.Option("--last", help="Ask about the last frame of each sequence alone.")]
_Seed = Annotated[int, typer.Option(help="Of frames, order and sides.")]


def study_command(
    first: _First,
    second: _Second,
    truth: _Truth,
    out: _Out = DEFAULT_STUDY,
    key: _Key = None,
    questions: _Questions = DEFAULT_QUESTIONS,
    last: _Last = False,
    seed: _Seed = 0,
) -> None:
    """Make a page on which people choose the reconstruction that fits a photo better: A, B or a tie."""
    from folding_client.report.site_files import content_key
    from folding_client.study.study_files import StudyKey
    from folding_client.study.study_questions import draw_questions, joint_sequences
    from folding_client.study.study_site import write_key, write_study

    sequences = joint_sequences(first, second, truth)
    asked = draw_questions(sequences, questions, seed, last_only=last)
    study = content_key(*(each.model_dump_json() for each in asked))
    names = _names(first.resolve(), second.resolve())
    told = StudyKey(study=study, seed=seed, first=names[0], second=names[1], questions=asked)
    place = key or out.with_name(f"{out.resolve().name}.key.json")
    write_key(told, place, out)
    work = write_study(sequences, asked, told, out, lambda words: typer.echo(words, err=True))
    finish(work, "the same command makes it anew")
    typer.echo(f"{len(asked)} questions on {len(sequences)} sequences: {out / 'index.html'}")
    typer.echo(f"The key, not for participants: {place}")


def _names(first: Path, second: Path) -> tuple[str, str]:
    """What the two folders are called; their whole paths where they are called the same."""
    return (first.name, second.name) if first.name != second.name else (str(first), str(second))


def study_score_command(
    answers: Annotated[
        list[Path], typer.Argument(parser=options.path, help="The files that participants saved.")
    ],
    key: Annotated[Path, typer.Option(parser=options.path, help="The key of the study.")],
    as_json: options.AsJson = False,
) -> None:
    """Say which side participants preferred, how sure that is, and how far they agree."""
    from folding_client.study.study_files import read_answers, read_key
    from folding_client.study.study_scores import study_lines, study_scores

    told = read_key(key)
    scores = study_scores(read_answers(answers, told), told)
    typer.echo(json.dumps(asdict(scores), indent=1) if as_json else "\n".join(study_lines(scores)))
