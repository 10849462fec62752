"""The programs and photographed sequences that come with the project."""

import json
from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from folding_schemas.actions import Program
from folding_server.frames.sequences import load_sequence
from folding_server.photographer.replaying import keyframe_papers
from folding_server.simulator import Paper

ROOT = Path(__file__).resolve().parents[1]
MODELS = sorted((ROOT / "benchmarks" / "reconstruction" / "programs").glob("*.json"))
EXAMPLES = [ROOT / "examples" / name for name in ("cat", "cup", "heart")]


def read(path: Path) -> Program:
    return Program.model_validate_json(path.read_text(encoding="utf-8"))


def look(paper: Paper) -> set[tuple[object, ...]]:
    """What can be told apart of a paper: each edge's place and each face's middle, height and side."""
    faces: set[tuple[object, ...]] = set()
    for face in paper.faces:
        x, y = np.round(np.array(paper.polygon(face)).mean(axis=0), 3)
        faces.add((x, y, paper.rank[face], paper.back_up(face)))
    places = {v: (round(x, 3), round(y, 3)) for v, (x, y) in paper.folded_vertices_coords.items()}
    edges: set[tuple[object, ...]] = {tuple(sorted((places[u], places[v]))) for u, v in paper.edge_faces}
    return faces | edges


def test_there_are_many_models_of_all_lengths() -> None:
    lengths = [len(read(path).steps) + 1 for path in MODELS]
    assert len(MODELS) >= 18
    assert (min(lengths), max(lengths)) == (5, 21)
    assert 11 <= np.mean(lengths) <= 13


def test_the_models_use_every_kind_of_step() -> None:
    kinds: Counter[str] = Counter()
    for path in MODELS:
        for step in read(path).steps:
            actions = [a for a in step if a.action != "add_vertex"]
            kinds["+".join(a.action for a in actions)] += 1
            kinds.update(f"flip {a.axis}" for a in actions if a.action == "flip")
            kinds.update(f"unfold {'older' if a.edge else 'newest'}" for a in actions if a.action == "unfold")
    wanted = ("fold", "fold+fold", "unfold newest", "unfold older", "rotate", "rotate+flip")
    assert all(kinds[kind] for kind in wanted)
    assert all(kinds[f"flip {axis}"] for axis in ("x", "y", "y=x", "y=-x"))


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_every_model_folds_and_every_step_changes_it(path: Path) -> None:
    program = read(path)
    papers = keyframe_papers(program)
    assert program.name == path.stem
    assert program.comment
    assert all(look(before) != look(after) for before, after in pairwise(papers))


@pytest.mark.parametrize("folder", EXAMPLES, ids=lambda p: p.name)
def test_every_example_is_a_small_sequence_whose_truth_is_its_program(folder: Path) -> None:
    sequence = load_sequence(folder)
    program, truth = read(folder / "program.json"), json.loads((folder / "truth.json").read_text())
    papers = keyframe_papers(program)
    assert sum(p.stat().st_size for p in folder.rglob("*") if p.is_file()) < 2_000_000
    assert program.steps == read(ROOT / "examples" / "programs" / f"{folder.name}.json").steps
    assert sequence.frame_count == len(papers) == len(truth["frames"])
    for paper, frame in zip(papers, truth["frames"], strict=True):
        assert list(paper.order) == frame["order"]
        for v, (x, y) in paper.folded_vertices_coords.items():
            assert frame["vertices"][str(v)]["folded"] == pytest.approx((x, y), abs=2e-6)


def test_the_heart_has_a_flip_and_two_unfolds() -> None:
    actions = [a.action for step in read(ROOT / "examples" / "programs" / "heart.json").steps for a in step]
    assert actions.count("flip") >= 1
    assert actions.count("unfold") == 2
