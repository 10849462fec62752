"""The audit of meshes: what our own files hold passes, and what paper cannot be is named."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from evaluated import EXAMPLES, example_program
from folding_server.audit.mesh_audit import MeshAudit, audit_mesh
from folding_server.audit.mesh_reading import read_mesh
from folding_server.audit.mesh_record import Mesh
from folding_server.cli import main
from folding_server.errors import FoldingError
from folding_server.interchange.fold_format import fold_document, fold_text
from folding_server.interchange.obj import obj_text
from folding_server.simulate import run_steps
from folding_server.simulator import Paper
from hypothesis import given, settings
from hypothesis import strategies as st
from papers import random_paper


def paper_of(name: str) -> Paper:
    return list(run_steps(example_program(name)))[-1].paper


def audited(folder: Path, text: str, name: str = "mesh.obj") -> MeshAudit:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return audit_mesh(read_mesh(file))


@pytest.mark.parametrize("name", EXAMPLES)
def test_what_our_own_files_hold_passes(name: str, tmp_path: Path) -> None:
    paper = paper_of(name)
    for found in (
        audited(tmp_path, obj_text(paper)),
        audited(tmp_path, fold_text(fold_document(paper)), "mesh.fold"),
    ):
        assert found.passes
        assert (found.components, found.faces, found.crossings) == (1, len(paper.faces), 0)
        assert found.unfolds_to_square
        assert found.layers > 3


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10**6))
def test_random_folds_pass(seed: int) -> None:
    from folding_server.audit.mesh_reading import _fold_mesh, _obj_mesh

    paper = random_paper(seed, 4)
    assert audit_mesh(_obj_mesh(obj_text(paper))).problems == ()
    assert audit_mesh(_fold_mesh(fold_text(fold_document(paper)))).problems == ()


def moved(text: str, kind: str, row: int, place: int, by: float) -> str:
    """The file with a number of its n-th line of a kind changed."""
    lines = text.splitlines()
    at = [i for i, line in enumerate(lines) if line.split()[:1] == [kind]][row]
    words = lines[at].split()
    words[place] = str(float(words[place]) + by)
    lines[at] = " ".join(words)
    return "\n".join(lines)


def test_a_stretched_sheet_is_told(tmp_path: Path) -> None:
    found = audited(tmp_path, moved(obj_text(paper_of("cup")), "v", 0, 1, 0.1))
    assert not found.passes
    assert found.stretch > 0.02
    assert "Faces are stretched" in " ".join(found.problems)


def test_a_torn_sheet_is_told(tmp_path: Path) -> None:
    """A face that shares no point of the sheet with its neighbours any more."""
    text = obj_text(paper_of("cup"))
    corners = sum(line.startswith("v ") for line in text.split("g face_")[1].splitlines())
    for row in range(corners):
        text = moved(text, "vt", row, 1, 2.0)
    found = audited(tmp_path, text)
    assert not found.passes
    assert found.components == 2
    assert not found.unfolds_to_square


def test_two_sheets_are_told() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    mesh = Mesh(np.concatenate([square, square + np.array([0, 0, 0.2])]), ((0, 1, 2, 3), (4, 5, 6, 7)))
    found = audit_mesh(mesh)
    assert found.components == 2
    assert found.layers == 2
    assert found.problems[0] == "It is 2 pieces that share no edge, not one sheet."


def test_layers_that_pass_through_a_fold_are_told(tmp_path: Path) -> None:
    """The cup with its layers in another order: two heights exchanged."""
    text = obj_text(paper_of("cup"))
    groups = text.split("g face_")
    heights = [group.split("v ")[1].split()[2] for group in groups[1:]]
    order = sorted(range(len(heights)), key=lambda i: float(heights[i]))
    low, high = order[0], order[len(order) // 2]
    for index, height in ((low, heights[high]), (high, heights[low])):
        old = heights[index]
        groups[index + 1] = (
            groups[index + 1].replace(f" {old}\nv", f" {height}\nv").replace(f" {old}\nvt", f" {height}\nvt")
        )
    found = audited(tmp_path, "g face_".join(groups))
    assert not found.passes
    assert found.crossings is not None
    assert found.crossings > 0


def test_faces_that_pierce_each_other_in_space_are_told() -> None:
    """A strip bent round through itself."""
    points = np.array(
        [[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [1, 0, 1], [1, 1, 1], [0.3, 0, -0.4], [0.3, 1, -0.4]],
        float,
    )
    found = audit_mesh(Mesh(points, ((0, 2, 3, 1), (2, 4, 5, 3), (4, 6, 7, 5))))
    assert found.shape == "in space"
    assert found.crossings == 1
    assert found.kawasaki is None


def test_a_box_without_lid_does_not_unfold_to_a_square() -> None:
    box = trimesh.creation.box((1, 1, 1))
    found = audit_mesh(Mesh(np.array(box.vertices), tuple(tuple(map(int, face)) for face in box.faces[:10])))
    assert found.components == 1
    assert not found.unfolds_to_square


@pytest.mark.parametrize("ending", ["ply", "glb"])
def test_other_formats_are_read_with_trimesh(ending: str, tmp_path: Path) -> None:
    """A square sheet half folded up."""
    points = np.array([[0, 0, 0], [0, 1, 0], [0.5, 0, 0], [0.5, 1, 0], [0.5, 0, 0.5], [0.5, 1, 0.5]])
    faces = [[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]]
    file = tmp_path / f"sheet.{ending}"
    trimesh.Trimesh(points, faces, process=False).export(file)
    found = audit_mesh(read_mesh(file))
    assert found.passes
    assert (found.faces, found.panels, found.components, found.shape) == (4, 2, 1, "in space")


class TestCommand:
    def command(self, *words: object) -> int:
        with pytest.raises(SystemExit) as ended:
            main([str(word) for word in words])
        return int(ended.value.code or 0)

    def test_a_sheet_ends_with_0_and_json(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        file = tmp_path / "cup.obj"
        file.write_text(obj_text(paper_of("cup")))
        assert self.command("audit", file, "--json") == 0
        told = json.loads(capsys.readouterr().out)
        assert told["passes"] is True
        assert told["components"] == 1

    def test_what_is_no_sheet_ends_with_1_and_says_why(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        file = tmp_path / "strip.obj"
        file.write_text("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nf 1 2 3 4\n")
        assert self.command("audit", file) == 1
        assert "not a square" in capsys.readouterr().out

    @pytest.mark.parametrize(
        ("name", "text", "said"),
        [
            ("mesh.stl", "", "is no mesh by its name"),
            ("mesh.obj", "", "holds no faces"),
            ("mesh.obj", "v 0 0 0\nf 1 2 x\n", "Line 2 of the OBJ file"),
            ("mesh.ply", "damaged", "cannot be read as a mesh"),
        ],
        ids=["another ending", "empty", "bad line", "damaged"],
    )
    def test_what_cannot_be_read_is_refused_in_a_sentence(
        self, name: str, text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (tmp_path / name).write_text(text)
        assert self.command("audit", tmp_path / name) == 1
        told = capsys.readouterr().err
        assert said in told
        assert told.count("\n") == 1


def test_without_trimesh_one_sentence_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "trimesh", None)
    (tmp_path / "mesh.ply").write_text("")
    with pytest.raises(FoldingError, match=r"pip install 'foldingagent-mcp\[audit\]'"):
        read_mesh(tmp_path / "mesh.ply")
