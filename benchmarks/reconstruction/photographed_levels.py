"""A corpus for comparing models: programs photographed at several levels, and the experiment that reconstructs them.

    python benchmarks/reconstruction/photographed_levels.py --seed 901 --programs fox tulip -o CORPUS

writes ``CORPUS/level1/fox-1``, ``CORPUS/level2/fox-2`` and so on, sequences with the truth beside them, and ``CORPUS/baselines.yaml``.
Names tell the levels apart, so that all of them fit one batch, and each level can be evaluated alone:

    foldingagent batch CORPUS/baselines.yaml
    foldingagent evaluate CORPUS/runs --truth CORPUS/level1 -o CORPUS/evaluation1
"""

import argparse
import json
import shutil
from collections.abc import Sequence
from pathlib import Path

import corpus
import studio
from folding_schemas.actions import Program

LEVELS = (1, 2, 3)
MODELS = ("geometric", "random", "search")
"""The models that ask nobody."""
SEARCH_TRIES = 40
"""Moves that ``search`` tries at a frame, so that it ends: 300, as without a bound, took 145 s on a busy machine for a frame at
which nothing matched.
"""
MOST_TIME = "8m"
"""The most time for a run, whatever the model: the longest of the 45 of docs/evaluation.md took 206 s on two busy cores."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the corpus that the command line asks for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=901)
    parser.add_argument(
        "--programs", nargs="+", metavar="NAME", choices=sorted(corpus.programs()), required=True
    )
    parser.add_argument("--cache", type=Path, default=studio.CACHE, help="where photographs are kept")
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="CORPUS")
    given = parser.parse_args(arguments)
    known = corpus.programs()
    for level in LEVELS:
        for name in given.programs:
            write_sequence(known[name], given.seed, level, given.cache, given.out)
    (given.out / "baselines.yaml").write_text(experiment(given.programs), encoding="utf-8")


def write_sequence(program: Program, seed: int, level: int, cache: Path, out: Path) -> None:
    """Photograph a program at a level, and copy the sequence under a name that says the level."""
    name = f"{program.name}-{level}"
    folder = out / f"level{level}" / name
    if folder.exists():
        return
    shutil.copytree(studio.photographed(program, seed, level, cache), folder)
    manifest = folder / "keyframes.json"
    described = json.loads(manifest.read_text(encoding="utf-8")) | {"name": name}
    manifest.write_text(json.dumps(described, indent=1) + "\n", encoding="utf-8")


def experiment(names: Sequence[str]) -> str:
    """All programs at all levels by all models that ask nobody, one run after the other, so that what is begun is comparable."""
    sequences = "".join(f"  - level{level}/{name}-{level}\n" for name in names for level in LEVELS)
    return (
        f"sequences:\n{sequences}models: [{', '.join(MODELS)}]\nseeds: [1]\nout: runs\njobs: 1\n"
        f"settings: {{search_tries: {SEARCH_TRIES}, max_time: {MOST_TIME}}}\n"
    )


if __name__ == "__main__":
    main()
