"""Paper that is not quite square and folds that are not quite where they should be: the program as hands
carry it out.

Where folds miss their landmarks, cuts make other vertices than in the exact program, so every action is
carried over by the places of its vertices on the sheet.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import hypot

import numpy as np
from folding_schemas.actions import Action, AddVertex, Fold, Program, Unfold

from folding_server.errors import ActionRefused
from folding_server.photographer.chance import stream
from folding_server.photographer.levels import Level
from folding_server.photographer.replaying import keyframe_papers
from folding_server.simulator import Paper, apply, new_paper

FACTORS = (1.0, 0.7, 0.5, 0.3, 0.15, 0.07)
"""Parts of the full imprecision that are tried, greatest first, until the program can still be folded."""
SAME_PLACE = 0.06
"""Two vertices this near on the sheet may be the same, one folded exactly and one not."""
SAME_MODEL = 0.12
"""No vertex of the imprecise model lies further than this from where it lies in the exact one."""


class Spoilt(Exception):
    """This much imprecision makes another model, or none; try less."""


@dataclass
class Hands:
    """Two papers side by side: one folded exactly, one imprecisely; ``twin`` maps the vertices of the first."""

    exact: Paper
    real: Paper
    twin: dict[int, int] = field(default_factory=lambda: {v: v for v in (1, 2, 3, 4)})

    def carry_out(self, action: Action, off: float) -> Action:
        """Do an action on both; returns the one that the imprecise paper got. ``off`` in sheet sides."""
        done = self._carried_over(action, off)
        before = set(self.exact.places), set(self.real.places)
        try:
            self.exact, self.real = apply(self.exact, action), apply(self.real, done)
        except ActionRefused as refusal:
            raise Spoilt from refusal
        for v in sorted(set(self.exact.places) - before[0]):
            self.twin[v] = _nearest(self.real, self.exact.places[v], set(self.real.places) - before[1])
        return done

    def _carried_over(self, action: Action, off: float) -> Action:
        if not isinstance(action, AddVertex | Fold | Unfold) or action.edge is None:
            return action
        if any(v not in self.twin for v in action.edge):
            raise Spoilt
        u, v = (self.twin[w] for w in action.edge)
        if not isinstance(action, AddVertex):
            return action.model_copy(update={"edge": (u, v)})
        (ux, uy), (vx, vy) = self.real.places[u], self.real.places[v]
        position = action.position + off / max(hypot(ux - vx, uy - vy), 1e-9)
        return action.model_copy(
            update={"edge": (u, v), "position": float(np.clip(round(position, 6), 0.01, 0.99))}
        )

    def same_model(self) -> bool:
        """Whether every vertex still lies about where it does in the exact model."""
        exact, real = self.exact.positions, self.real.positions
        return all(
            hypot(exact[v][0] - real[w][0], exact[v][1] - real[w][1]) <= SAME_MODEL
            for v, w in self.twin.items()
        )


def imprecise(program: Program, seed: int, level: Level) -> Program:
    """The program as it is really carried out at a level; the program itself where the level is exact.

    Errors are drawn once and scaled down until the folds can be made and give the same model. ProgramError if
    even the exact program cannot be folded.
    """
    keyframe_papers(program)
    if level.crooked == level.sloppy == 0:
        return program
    for factor in FACTORS:
        try:
            return _carried_out(program, seed, level, factor)
        except Spoilt:
            continue
    return program


def _carried_out(program: Program, seed: int, level: Level, factor: float) -> Program:
    """The program with all errors scaled by a factor. Raises Spoilt."""
    rng = stream(seed, "imprecision")
    width, height = program.sheet
    uneven = (width, round(height * (1 + factor * rng.uniform(-level.crooked, level.crooked)), 6))
    hands = Hands(new_paper(program.sheet), new_paper(uneven))
    steps = []
    for step in program.steps:
        steps.append(tuple(hands.carry_out(a, factor * rng.uniform(-1, 1) * level.sloppy) for a in step))
        if not hands.same_model():
            raise Spoilt
    return program.model_copy(update={"sheet": uneven, "steps": tuple(steps)})


def _nearest(paper: Paper, place: tuple[float, float], fresh: set[int]) -> int:
    """The vertex of a paper nearest to a place on the sheet, a fresh one if any is near. Raises Spoilt."""
    for candidates in (fresh, set(paper.places)):
        near = _distances(paper.places, place, candidates)
        if near and min(near)[0] <= SAME_PLACE:
            return min(near)[1]
    raise Spoilt


def _distances(
    places: Mapping[int, tuple[float, float]], place: tuple[float, float], candidates: set[int]
) -> list[tuple[float, int]]:
    return [(hypot(places[v][0] - place[0], places[v][1] - place[1]), v) for v in candidates]
