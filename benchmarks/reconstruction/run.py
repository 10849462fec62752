"""How well photographed programs are reconstructed: how many exactly, how precisely, how fast.

    python benchmarks/reconstruction/run.py --level 2 --json [--seed S] [--programs NAME ...] [--between N] [--jobs N] [-o DIR]
    python benchmarks/reconstruction/run.py --rendered
    python benchmarks/reconstruction/run.py --tutorials

Seeds below 100 are for development; figures that are reported anywhere use seeds from 100 on, never looked
at while the solver is being changed. Programs are photographed once and kept in the cache folder. The same
seed gives the same photos and the same answers; only seconds and memory differ. For true seconds leave
--jobs at 1 and the machine to the benchmark. With -o every program that was found is written too, so that two
versions of the solver can be compared byte for byte.
"""

import argparse
import json
import multiprocessing
import platform
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import corpus
import studio
from corpus import Subject
from folding_schemas.actions import Program
from folding_server.interchange.programs import program_text
from folding_server.photographer.levels import LEVELS
from folding_server.photographer.moments import MOST_BETWEEN
from reconstructing import Reconstruction, reconstruct
from report import document, in_words, table
from rich.console import Console
from scoring import Score, score

REPORT_SEEDS = 100
"""Seeds from this one on are kept for reports."""
Item = TypeVar("Item")
Answer = TypeVar("Answer")


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure what the command line asks for and print one JSON document or a table."""
    options = _options(arguments)
    known = _ray_traced(options)
    subjects = [known[name] for name in options.programs] if known else _photographed(options)
    scores = []
    for subject, attempt in _each(partial(_attempt, mode=options.mode), subjects, options.jobs):
        scores.append(_scored(subject, attempt))
        if options.out is not None and attempt.exception() is None:
            _write(options.out, subject.name, attempt.result())
        sys.stderr.write(f"{in_words(scores[-1])}\n")
    if options.json:
        json.dump(document(_settings(options), scores), sys.stdout, indent=1)
        sys.stdout.write("\n")
    else:
        Console().print(table(_title(options), scores))


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--level", type=int, choices=sorted(LEVELS), default=1, help="difficulty of the photos"
    )
    parser.add_argument(
        "--seed", type=int, default=1, help=f"development: 1 to 99; reports: from {REPORT_SEEDS}"
    )
    parser.add_argument(
        "--between", type=int, default=0, metavar="N", help="images of the paper on its way after each photo"
    )
    parser.add_argument("--programs", nargs="+", metavar="NAME", help="only these")
    parser.add_argument("--limit", type=_positive, help="only so many, in order of name")
    parser.add_argument(
        "--mode", choices=("solver", "run"), default="solver", help="the solver alone, or all of it"
    )
    parser.add_argument(
        "--rendered", action="store_true", help="the ray-traced sequences instead of programs"
    )
    parser.add_argument(
        "--tutorials", action="store_true", help="the ray-traced sequences of which each photo is framed anew"
    )
    parser.add_argument("--jobs", type=_positive, default=1, help="sequences at a time")
    parser.add_argument("--cache", type=Path, default=studio.CACHE, help="where photographs are kept")
    parser.add_argument(
        "-o", "--out", type=Path, metavar="DIR", help="write each program found to DIR/NAME.json"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    options = parser.parse_args(arguments)
    if options.seed < 0:
        parser.error(f"the seed {options.seed} is negative; give a whole number from 0")
    if not 0 <= options.between <= MOST_BETWEEN:
        parser.error(f"there cannot be {options.between} images in between; give 0 to {MOST_BETWEEN}")
    known = list(_ray_traced(options) or corpus.programs())
    if unknown := sorted(set(options.programs or ()) - set(known)):
        parser.error(f"there is no program {unknown[0]!r}; choose from {', '.join(known) or 'none'}")
    if not known:
        parser.error(f"there are no sequences in {corpus.RENDERED.parent}")
    options.programs = [name for name in known if name in (options.programs or known)][: options.limit]
    return options


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        message = f"{number} is not at least 1"
        raise argparse.ArgumentTypeError(message)
    return number


def _ray_traced(options: argparse.Namespace) -> dict[str, Subject]:
    """The sequences that were not photographed here, by name; none if programs are to be photographed."""
    if options.tutorials:
        return corpus.rendered(corpus.TUTORIALS)
    return corpus.rendered() if options.rendered else {}


def _photographed(options: argparse.Namespace) -> list[Subject]:
    """The chosen programs as sequences, photographed where that has not been done before."""
    known = corpus.programs()
    take = partial(
        studio.photographed,
        seed=options.seed,
        level=options.level,
        folder=options.cache,
        between=options.between,
    )
    chosen = [known[name] for name in options.programs]
    folders = [future.result() for _, future in _each(take, chosen, options.jobs)]
    return [
        Subject(name, folder, studio.folded_truth(folder), corpus.TOLERANCE)
        for name, folder in zip(options.programs, folders, strict=True)
    ]


def _attempt(subject: Subject, mode: str) -> Reconstruction:
    return reconstruct(subject.folder, mode)


def _each(
    work: Callable[[Item], Answer], items: Sequence[Item], jobs: int
) -> Iterator[tuple[Item, Future[Answer]]]:
    """Do some work on each item in a fresh process of its own, so that memory is measured apart; in order."""
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=fresh, max_tasks_per_child=1) as pool:
        futures = [pool.submit(work, item) for item in items]
        for item, future in zip(items, futures, strict=True):
            future.exception()
            yield item, future


def _scored(subject: Subject, attempt: Future[Reconstruction]) -> Score:
    """The score; a reconstruction that broke down in its process found nothing, and says why."""
    error = attempt.exception()
    if error is None:
        return score(subject, attempt.result())
    return score(
        subject, Reconstruction((), (), 0.0, 0.0, completed=False, reason=f"{type(error).__name__}: {error}")
    )


def _write(folder: Path, name: str, found: Reconstruction) -> None:
    """Write the program that was found."""
    folder.mkdir(parents=True, exist_ok=True)
    program = Program(name=name, steps=found.steps)
    (folder / f"{name}.json").write_text(program_text(program), encoding="utf-8")


def _settings(options: argparse.Namespace) -> dict[str, Any]:
    photos = (
        {"rendered": options.rendered, "tutorials": options.tutorials}
        if options.rendered or options.tutorials
        else {"level": options.level, "seed": options.seed, "between": options.between}
    )
    return {
        **photos,
        "mode": options.mode,
        "jobs": options.jobs,
        "photographer": studio.version(),
        "python": platform.python_version(),
        "machine": platform.machine(),
        "cores": multiprocessing.cpu_count(),
    }


def _title(options: argparse.Namespace) -> str:
    taken = f"level {options.level}, seed {options.seed}, {options.between} in between"
    if options.tutorials:
        taken = "ray-traced photos framed anew"
    photos = "ray-traced photos" if options.rendered else taken
    return f"Reconstruction: {photos}, {options.mode}"


if __name__ == "__main__":
    main()
