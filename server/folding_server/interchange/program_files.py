"""Any file of a program as a program: our own form, one of a published figure, or a recorded result."""

from folding_schemas.actions import Action, Program

from folding_server.errors import ActionRefused, ProgramError
from folding_server.interchange.fold_frames import parse_json_object
from folding_server.interchange.programs import RecordedProgram, load_published, load_recorded, resolved
from folding_server.simulator import apply, new_paper


def program_in(text: str) -> Program:
    """The program in a JSON text: with ``steps``, or a recorded result, which has a flat list ``actions`` and ``final``.

    ProgramError says what is wrong with it; of a recorded result also which action cannot be folded.
    """
    document = parse_json_object(text, "program")
    if "actions" in document and "steps" not in document:
        return _each_a_step(load_recorded(text))
    return load_published(text).program


def _each_a_step(recorded: RecordedProgram) -> Program:
    """A recorded result with each action as a step, edges named by the vertices at their recorded places."""
    paper, steps = new_paper(), list[tuple[Action, ...]]()
    for number, each in enumerate(recorded.actions, 1):
        action = resolved(paper, each)
        try:
            paper = apply(paper, action)
        except ActionRefused as refused:
            raise ProgramError(
                f"Action {number} of the recorded program cannot be folded: {refused}"
            ) from refused
        steps.append((action,))
    return Program(name=recorded.name, steps=tuple(steps))
