"""Papers to test with: published figures and random folding sequences."""

import random
from pathlib import Path

import pytest
from folding_schemas.actions import Program
from folding_server.errors import ActionRefused
from folding_server.interchange.programs import load_published, load_recorded, resolved
from folding_server.simulator import Paper, add_vertex, apply, flip, fold, new_paper, rotate, unfold
from paths import DATA
from reference import reference_files

FIGURES = sorted((DATA / "programs").glob("figure_*.json"))
CAT = DATA / "programs" / "figure_d_cat_9_frames.json"
RABBIT = DATA / "programs" / "figure_b_rabbit_14_frames.json"
OWN_RESULTS = sorted((DATA / "results").glob("*.json"))
RESULTS = [
    *(pytest.param(path, id=path.stem) for path in OWN_RESULTS),
    *reference_files("programs/recorded", "*.json"),
]
"""Programs with the final state that they are known to lead to: ours, and published ones."""


def figure(path: Path) -> Program:
    """A program as printed in a figure."""
    return load_published(path.read_text(encoding="utf-8")).program


def result(path: Path) -> Paper:
    """The paper that the actions of a recorded result lead to."""
    paper = new_paper()
    for recorded in load_recorded(path.read_text(encoding="utf-8")).actions:
        paper = apply(paper, resolved(paper, recorded))
    return paper


def states(program: Program) -> list[Paper]:
    """The flat sheet and the paper after each step."""
    papers = [new_paper(program.sheet)]
    for step in program.steps:
        paper = papers[-1]
        for action in step:
            paper = apply(paper, action)
        papers.append(paper)
    return papers


def random_paper(seed: int, folds: int, sheet: tuple[float, float] = (1.0, 1.0)) -> Paper:
    """A paper after random folds, some opened again, some with a flip or a turn between them."""
    chance = random.Random(seed)
    paper = new_paper(sheet)
    for _ in range(folds):
        try:
            cut = paper
            for _ in range(2):
                boundary = [edge for edge, beside in cut.edge_faces.items() if len(beside) == 1]
                cut = add_vertex(cut, chance.choice(boundary), chance.uniform(0.15, 0.85))
            folded = fold(
                cut, (max(cut.vertices_coords) - 1, max(cut.vertices_coords)), chance.choice((1, -1))
            )
            paper = unfold(folded) if chance.random() < 0.3 else folded
        except ActionRefused:
            continue
        if chance.random() < 0.3:
            paper = flip(paper, "x")
        if chance.random() < 0.3:
            paper = rotate(paper, chance.uniform(0, 360))
    return paper
