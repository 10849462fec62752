"""Running a program step by step, with everything about each step written to a folder."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from folding_schemas.actions import Action, Program

from folding_server.diagram import Colors, draw_svg, rasterise
from folding_server.diagram.palette import colors_of
from folding_server.diagram.strip import describe_action
from folding_server.errors import ActionRefused, FoldingError, ProgramError
from folding_server.simulator import Paper, apply, folded_state, moved_faces, new_paper
from folding_server.simulator.plane_layers import layers_of_planes


@dataclass(frozen=True)
class StepResult:
    """The paper after a step (0 is the flat sheet) and which of its faces lie elsewhere than before."""

    step: int
    actions: tuple[Action, ...]
    paper: Paper
    moved: tuple[int, ...]

    @property
    def line(self) -> str:
        """The step in one line: what was done, what moved, how many layers there are now."""
        done = ", ".join(describe_action(action) for action in self.actions) or "nothing"
        layers = len(layers_of_planes(self.paper))
        moved = f"{len(self.moved)} of {len(self.paper.faces)} faces moved" if self.moved else "nothing moved"
        return f"step {self.step}: {done}; {moved}; {layers} {'layer' if layers == 1 else 'layers'}"


def run_steps(program: Program) -> Iterator[StepResult]:
    """The flat sheet, then the paper after each step, as they are folded.

    ProgramError at the first action that the simulator refuses, naming the step, the action and the reason;
    the steps before it have been yielded by then.
    """
    paper = new_paper(program.sheet)
    yield StepResult(0, (), paper, ())
    for number, step in enumerate(program.steps, 1):
        before = paper
        for i, action in enumerate(step, 1):
            try:
                paper = apply(paper, action)
            except ActionRefused as refused:
                raise ProgramError(
                    f"Step {number}, action {i} ({describe_action(action)}): {refused}"
                ) from refused
        yield StepResult(number, step, paper, moved_faces(before, paper))


def write_steps(results: Iterable[StepResult], folder: Path, colors: Colors) -> Iterator[StepResult]:
    """Write state, SVG and PNG of each step as ``step_000.json`` and so on, and pass the step on."""
    folder.mkdir(parents=True, exist_ok=True)
    for result in results:
        stem = folder / f"step_{result.step:03d}"
        svg = draw_svg(result.paper, colors)
        stem.with_suffix(".json").write_text(
            folded_state(result.paper).model_dump_json(indent=1), encoding="utf-8"
        )
        stem.with_suffix(".svg").write_text(svg, encoding="utf-8")
        stem.with_suffix(".png").write_bytes(rasterise(svg))
        yield result


def simulate(
    program: Program,
    folder: Path | None = None,
    say: Callable[[str], None] | None = None,
    colors: Colors | None = None,
) -> Paper:
    """Run a program and return the final paper, saying one line a step.

    With a folder, state JSON, SVG and PNG of every step are written there. The colours are the program's own
    unless given. ProgramError names the step, the action and the reason of a bad action; what came before
    is written.
    """
    results: Iterable[StepResult] = run_steps(program)
    if folder is not None:
        shown = colors or colors_of(program.front_color, program.back_color)
        results = _writable(write_steps(results, folder, shown), folder)
    paper = new_paper(program.sheet)
    for result in results:
        paper = result.paper
        if result.step and say:
            say(result.line)
    return paper


def _writable(results: Iterable[StepResult], folder: Path) -> Iterator[StepResult]:
    """The same results, with trouble in writing told in one sentence."""
    try:
        yield from results
    except OSError as error:
        raise FoldingError(
            f"The steps cannot be written to {folder}: {error.strerror}; give another folder."
        ) from error
