"""Other origami software reads our FOLD files and comes to the same faces, coordinates and layer order."""

import json
import shutil
import subprocess
from functools import cache
from itertools import product
from math import dist
from pathlib import Path
from typing import Any

import pytest
from folding_server.interchange.fold_format import crease_pattern_document, fold_document, fold_text
from folding_server.simulator import Paper
from papers import FIGURES, figure, random_paper, states

PEERS = Path(__file__).parent / "peers"
INSTALL = "npm ci --prefix tests/peers"
MODELS: dict[str, Paper] = {path.stem: states(figure(path))[-1] for path in FIGURES} | {
    f"random_{seed}": random_paper(seed, 4) for seed in (3, 8, 12, 6, 29)
}
UNMARKED = ["random_6", "random_29"]
"""Models of which every crease is folded."""


@pytest.fixture(scope="session")
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """What the peers say of every model, asked once."""
    node = shutil.which("node")
    assert node, "node is not installed; it is needed to read our files with other origami software"
    assert (PEERS / "node_modules").is_dir(), f"the other origami software is not installed; run: {INSTALL}"
    folder = tmp_path_factory.mktemp("peers")
    files = []
    for name, paper in MODELS.items():
        for kind, document in (("full", fold_document(paper)), ("pattern", crease_pattern_document(paper))):
            files.append(folder / f"{name}.{kind}.fold")
            files[-1].write_text(fold_text(document), encoding="utf-8")
    run = subprocess.run(
        [node, PEERS / "peers.js", *files], capture_output=True, text=True, check=False, timeout=120
    )
    assert run.returncode == 0, run.stderr
    return dict(zip((file.stem for file in files), json.loads(run.stdout), strict=True))


@cache
def document(name: str) -> dict[str, Any]:
    """Our file for a model."""
    return fold_document(MODELS[name])


def cycles(faces: list[list[int]]) -> set[tuple[int, ...]]:
    """Faces as cycles from their smallest vertex, keeping the way they run."""
    turned = []
    for face in faces:
        first = face.index(min(face))
        turned.append((*face[first:], *face[:first]))
    return set(turned)


def assert_congruent(first: list[list[float]], second: list[list[float]]) -> None:
    """Two sets of points differ by a motion of the plane only: all their distances agree."""
    for i in range(len(first)):
        for j in range(i):
            assert dist(first[i], first[j]) == pytest.approx(dist(second[i], second[j]), abs=1e-6)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("kind", ["full", "pattern"])
def test_peers_find_our_faces_from_the_edges_alone(answers: Any, name: str, kind: str) -> None:
    answer = answers[f"{name}.{kind}"]
    ours = cycles(document(name)["faces_vertices"])
    assert answer["classes"] == ["creasePattern"]
    assert cycles(answer["ear"]["faces"]) == ours
    assert cycles(answer["fold"]["faces"]) == ours


@pytest.mark.parametrize("name", MODELS)
def test_a_peer_folds_the_pattern_to_our_coordinates(answers: Any, name: str) -> None:
    assert_congruent(document(name)["vertices_coords"], answers[f"{name}.full"]["ear"]["coords"])


@pytest.mark.parametrize("name", UNMARKED)
def test_a_peer_that_folds_every_edge_agrees_where_there_are_no_marks(answers: Any, name: str) -> None:
    assert "F" not in document(name)["edges_assignment"]
    assert_congruent(document(name)["vertices_coords"], answers[f"{name}.full"]["fold"]["coords"])


@pytest.mark.parametrize("name", MODELS)
def test_peers_read_our_fold_angles_from_the_letters(answers: Any, name: str) -> None:
    assert answers[f"{name}.full"]["ear"]["angles"] == document(name)["edges_foldAngle"]


@pytest.mark.parametrize("name", MODELS)
def test_our_face_orders_are_among_those_a_peer_finds_possible(answers: Any, name: str) -> None:
    """The peer says which face lies above, seen with face 0 front up; ours go by the second face's normal."""
    ear = answers[f"{name}.full"]["ear"]
    ours = {}
    for f, g, sign in document(name)["faceOrders"]:
        above = sign if ear["windings"][g] else -sign
        ours[(f, g) if f < g else (g, f)] = above if f < g else -above
    found = [
        {pair: sign for part in (ear["orders"]["root"], *choice) for pair, sign in part.items()}
        for choice in product(*ear["orders"]["branches"])
    ]
    theirs = [{tuple(map(int, pair.split())): sign for pair, sign in solution.items()} for solution in found]
    assert ours in theirs
