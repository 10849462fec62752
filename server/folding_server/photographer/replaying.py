"""A program's papers, one for each keyframe."""

from folding_schemas.actions import Action, Program

from folding_server.errors import ActionRefused, ProgramError
from folding_server.simulator import Paper, apply, new_paper


def keyframe_papers(program: Program) -> list[Paper]:
    """The paper at each keyframe: first the flat sheet, then the paper after each step.

    ProgramError names the step, the action and the reason if one cannot be done.
    """
    papers = [new_paper(program.sheet)]
    for number, step in enumerate(program.steps, 1):
        paper = papers[-1]
        for action in step:
            paper = _applied(paper, action, f"Step {number} of {program.name}")
        papers.append(paper)
    return papers


def _applied(paper: Paper, action: Action, where: str) -> Paper:
    try:
        return apply(paper, action)
    except ActionRefused as refusal:
        raise ProgramError(
            f"{where} cannot be folded: {described(action)} is refused: {refusal}"
        ) from refusal


def described(action: Action) -> str:
    """An action in a few characters, such as ``fold [5, 6] direction -1``."""
    values = action.model_dump(mode="json", exclude_none=True)
    name = values.pop("action")
    edge = values.pop("edge", None)
    return " ".join([name, *([str(edge)] if edge else []), *(f"{k} {v}" for k, v in values.items())])
