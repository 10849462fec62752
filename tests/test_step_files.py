"""Files of every step: numbered, readable by other software, and offered by the command and the tool."""

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from commands_here import run_here
from folding_server.interchange.fold_format import fold_text
from folding_server.interchange.fold_frames import read_frames
from folding_server.interchange.oripa import read_oripa
from folding_server.interchange.programs import load_published
from folding_server.interchange.step_files import new_creases, step_states, steps_document, write_step_files
from hosts import in_memory
from papers import states
from paths import EXAMPLES, ROOT

CUP = EXAMPLES / "programs" / "cup.json"
PROGRAM = load_published(CUP.read_text(encoding="utf-8")).program
PEERS = ROOT / "tests" / "peers" / "node_modules"
READ_FRAMES = """
const { createRequire } = require("node:module");
const require_ = createRequire(process.argv[1] + "/peers.js");
const ear = require_("rabbit-ear"), FOLD = require_("fold");
const document = JSON.parse(require("node:fs").readFileSync(process.argv[2]));
const { file_frames, ...key } = document;
const frames = [key, ...file_frames];
const copy = (value) => JSON.parse(JSON.stringify(value));
console.log(JSON.stringify({
  titles: frames.map((frame) => frame.frame_title),
  faces: frames.map((frame) => ear.graph.populate(copy(frame)).faces_edges.length),
  joined: frames.map((frame) => FOLD.convert.edges_vertices_to_vertices_vertices_sorted(copy(frame)).vertices_vertices.length),
}));
"""


def test_each_step_has_its_files(tmp_path: Path) -> None:
    written = write_step_files(PROGRAM, tmp_path)
    endings = (".fold", ".cp", ".obj", "-creases.svg")
    names = {f"step_{step:03d}{ending}" for step in range(len(PROGRAM.steps) + 1) for ending in endings}
    assert {path.name for path in written} == names | {"steps.fold"}
    assert all(path.is_file() for path in written)
    for number, paper in enumerate(states(PROGRAM)):
        pattern = read_oripa((tmp_path / f"step_{number:03d}.cp").read_text())
        assert len(pattern.edges_vertices) == len(paper.edge_faces)


def test_one_fold_file_holds_every_state_as_a_frame() -> None:
    frames = read_frames(fold_text(steps_document(PROGRAM)))
    papers = states(PROGRAM)
    assert len(frames) == len(papers)
    for frame, paper in zip(frames, papers, strict=True):
        assert frame.of_class("foldedForm")
        assert len(frame.faces_vertices) == len(paper.faces)
        wanted = [list(paper.folded_vertices_coords[v]) for v in sorted(paper.vertices_coords)]
        assert frame.vertices_coords == wanted


@pytest.mark.skipif(
    not PEERS.is_dir() or shutil.which("node") is None, reason="rabbit-ear and fold are not installed"
)
def test_rabbit_ear_and_fold_read_the_frames(tmp_path: Path) -> None:
    file = tmp_path / "steps.fold"
    file.write_text(fold_text(steps_document(PROGRAM)))
    done = subprocess.run(
        ["node", "-e", READ_FRAMES, str(PEERS.parent), str(file)], capture_output=True, text=True, check=True
    )
    read: dict[str, Any] = json.loads(done.stdout)
    papers = states(PROGRAM)
    assert read["titles"] == ["the flat sheet", *(f"step {i}" for i in range(1, len(papers)))]
    assert read["faces"] == [len(paper.faces) for paper in papers]
    assert read["joined"] == [len(paper.vertices_coords) for paper in papers]


def test_the_creases_that_a_step_makes_are_marked(tmp_path: Path) -> None:
    made = [len(new_creases(state.before, state.after)) for state in step_states(PROGRAM)]
    assert made[:3] == [0, 0, 1]
    assert made[-2] == 0  # turned over
    write_step_files(PROGRAM, tmp_path)
    marked = [
        bool(re.search('class="new"', (tmp_path / f"step_{i:03d}-creases.svg").read_text()))
        for i in range(len(made))
    ]
    assert marked == [bool(count) for count in made]


def test_the_command_writes_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    done = run_here(
        capsys,
        "simulate",
        CUP,
        "--step-files",
        tmp_path / "steps",
        "--steps",
        tmp_path / "all.fold",
        "--obj",
        tmp_path / "cup.obj",
    )
    assert done.code == 0, done.err
    assert (tmp_path / "steps" / "step_007.cp").is_file()
    assert json.loads((tmp_path / "all.fold").read_text())["file_classes"] == ["diagrams"]
    assert (tmp_path / "cup.obj").read_text().startswith("# flat-folded sheet")


@pytest.mark.anyio
async def test_the_tool_gives_them_by_step(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        await host.call("open_run")
        await host.call("fold", edge=[1, 3], direction=1)
        flat = await host.call("export_state", format="cp", step=0)
        folded = await host.call("export_state", format="cp")
        steps = await host.call("export_state", format="steps")
        refused = await host.refusal("export_state", format="cp", step=9)
    assert flat["text"].count("\n") == 4 and folded["text"].count("\n") == 5
    assert flat["filename"].endswith(".cp") and steps["filename"].endswith("-steps.fold")
    assert len(read_frames(steps["text"])) == 2
    assert "no step 9" in refused
