"""Paper that is not quite square and folds that are not quite where they should be: the program as hands
carry it out.
"""

import numpy as np
from folding_schemas.actions import Action, Program

from folding_server.photographer.levels import Level
from folding_server.photographer.replaying import keyframe_papers
from folding_server.photographer.rng import stream
from folding_server.simulator import new_paper
from folding_server.simulator.counterpart import Counterpart, NoCounterpart

ERROR_SHARES = (*((1.0, 1.0),) * 4, (0.5, 0.7), (0.5, 0.5), (0.2, 0.3), (0.0, 0.3), (0.0, 0.1), (0.0, 0.03))
"""Parts of the full errors of the sheet and of the folds that are tried, until the last step succeeds."""
TRIES = (1.0, 1.0, 1.0, 0.7, 0.5, 0.3, 0.15, 0.0)
"""Parts of the full error of the folds that are tried at each step, until one gives the same model."""


def imprecise(program: Program, seed: int, level: Level) -> Program:
    """The program as it is really carried out at a level; the program itself where the level is exact.

    Errors that would make another model, or none, are drawn again and smaller. ProgramError if even the exact
    program cannot be folded.
    """
    keyframe_papers(program)
    if level.crooked == level.sloppy == 0:
        return program
    for attempt, (sheet, folds) in enumerate(ERROR_SHARES):
        rng = stream(seed, "imprecision", attempt)
        try:
            return _carried_out(program, rng, sheet * level.crooked, folds * level.sloppy)
        except NoCounterpart:
            continue
    return program


def _carried_out(program: Program, rng: np.random.Generator, crooked: float, sloppy: float) -> Program:
    """The program on a sheet up to ``crooked`` off square, folded up to ``sloppy`` off. Raises NoCounterpart."""
    width, height = program.sheet
    uneven = (width, round(height * (1 + rng.uniform(-crooked, crooked)), 6))
    hands = Counterpart.of(new_paper(program.sheet), new_paper(uneven))
    steps = []
    for step in program.steps:
        hands, done = _step(hands, step, rng, sloppy)
        steps.append(done)
    return program.model_copy(update={"sheet": uneven, "steps": tuple(steps)})


def _step(
    hands: Counterpart, step: tuple[Action, ...], rng: np.random.Generator, sloppy: float
) -> tuple[Counterpart, tuple[Action, ...]]:
    """One step with the greatest errors that give the same model. Raises NoCounterpart if none do."""
    for share in TRIES:
        trial = hands.copy()
        try:
            done = tuple(trial.carry_out(a, share * sloppy * rng.uniform(-1, 1)) for a in step)
        except NoCounterpart:
            continue
        if trial.same_model():
            return trial, done
    raise NoCounterpart
