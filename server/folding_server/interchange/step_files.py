"""Files of every step for other software: numbered crease patterns, folded forms and meshes, and all states in one FOLD file."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from folding_schemas.actions import Program

from folding_server.errors import FoldingError, ProgramError
from folding_server.geometry.line import Point
from folding_server.interchange.crease_pattern import crease_pattern_of
from folding_server.interchange.crease_pattern_svg import crease_pattern_svg
from folding_server.interchange.fold_format import Document, fold_document, fold_text
from folding_server.interchange.obj import obj_text
from folding_server.interchange.oripa import oripa_text
from folding_server.simulator import Paper, apply, new_paper

NEW_CREASE = (
    'class="new" fill="none" stroke="#e08a00" stroke-width="7" stroke-opacity="0.55" stroke-linecap="round"'
)
"""How the creases that a step has made are marked, under the lines of the pattern."""


@dataclass(frozen=True)
class StepState:
    """The paper before a step and after it; step 0 is the flat sheet."""

    step: int
    before: Paper
    after: Paper


def step_states(program: Program) -> list[StepState]:
    """The states of a program. ActionRefused at an impossible action."""
    paper = new_paper(program.sheet)
    states = [StepState(0, paper, paper)]
    for number, step in enumerate(program.steps, 1):
        before = paper
        for action in step:
            paper = apply(paper, action)
        states.append(StepState(number, before, paper))
    return states


def program_of_step(program: Program, step: int | None) -> Program:
    """The program up to a step, 0 for the flat sheet; all of it without one. ProgramError if it has no such step."""
    if step is None:
        return program
    if not 0 <= step <= len(program.steps):
        raise ProgramError(f"There is no step {step}; the program has the steps 0 to {len(program.steps)}.")
    return program.model_copy(update={"steps": program.steps[:step]})


def paper_after(program: Program, step: int) -> Paper:
    """The paper after a step of a program, 0 for the flat sheet. ProgramError if it has no such step."""
    return step_states(program_of_step(program, step))[-1].after


def steps_document(program: Program) -> Document:
    """All states in one FOLD document: a frame for each, folded; the first is the flat sheet.

    Frames inherit nothing, since each step may cut faces: every frame has vertices, edges and faces of its own.
    """
    frames = [_frame(state, program) for state in step_states(program)]
    first = fold_document(new_paper(program.sheet), program.name)
    head = {key: first[key] for key in ("file_spec", "file_creator", "file_title")}
    return {**head, "file_classes": ["diagrams"], **frames[0], "file_frames": frames[1:]}


def _frame(state: StepState, program: Program) -> Document:
    whole = fold_document(state.after, program.name)
    kept = {
        key: value
        for key, value in whole.items()
        if not key.startswith(("file_", "folding:")) or key == "folding:vertex_ids"
    }
    title = f"step {state.step}" if state.step else "the flat sheet"
    return {"frame_title": title, **kept}


def new_creases(before: Paper, after: Paper) -> list[tuple[Point, Point]]:
    """The creases on the sheet that a step has made or turned: lines that were none, or were of another kind."""
    kinds = [(before.vertices_coords[u], before.vertices_coords[v], kind) for (u, v), kind in before.edges()]
    return [
        (p, q)
        for p, q, kind in (
            (after.vertices_coords[u], after.vertices_coords[v], k) for (u, v), k in after.edges()
        )
        if kind != "B" and not any(kind == other and _lies_on(p, q, a, b) for a, b, other in kinds)
    ]


def _lies_on(p: Point, q: Point, a: Point, b: Point) -> bool:
    """Whether stretch pq lies on stretch ab, to rounding."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dy * dy
    for x, y in (p, q):
        across = abs(dx * (y - a[1]) - dy * (x - a[0]))
        along = dx * (x - a[0]) + dy * (y - a[1])
        if across > 1e-9 + 1e-6 * square or not -1e-6 <= along <= square + 1e-6:
            return False
    return True


def new_creases_svg(state: StepState) -> str:
    """The crease pattern after a step, the creases that it has made or turned marked."""
    pattern = crease_pattern_of(state.after)
    return crease_pattern_svg(
        pattern, legend=True, marked=new_creases(state.before, state.after), mark=NEW_CREASE
    )


def write_step_files(program: Program, folder: Path) -> list[Path]:
    """Write ``step_000.fold``, ``.cp``, ``.obj`` and ``-creases.svg`` of each state, and ``steps.fold`` of all.

    ActionRefused if the program cannot be folded, FoldingError if the folder cannot be written to.
    """
    written: list[Path] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for state in step_states(program):
            for ending, text in _texts(state, program.name):
                written.append(folder / f"step_{state.step:03d}{ending}")
                written[-1].write_text(text, encoding="utf-8")
        written.append(folder / "steps.fold")
        written[-1].write_text(fold_text(steps_document(program)), encoding="utf-8")
    except OSError as error:
        raise FoldingError(
            f"The steps cannot be written to {folder}: {error.strerror}; give another folder."
        ) from error
    return written


def _texts(state: StepState, title: str) -> Iterable[tuple[str, str]]:
    """The files of a state by how their names end."""
    yield ".fold", fold_text(fold_document(state.after, title))
    yield ".cp", oripa_text(crease_pattern_of(state.after))
    yield ".obj", obj_text(state.after)
    yield "-creases.svg", new_creases_svg(state)
