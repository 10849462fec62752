"""A program's papers, one for each keyframe."""

from folding_schemas.actions import Action, Program, action_text

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
            f"{where} cannot be folded: {action_text(action)} is refused: {refusal}"
        ) from refusal
