"""Paper that is not quite square and folds that are not quite where they should be: the program as hands
carry it out.

Where folds miss their landmarks, cuts make other vertices than in the exact program, so every action is
carried over by the places of its vertices on the sheet.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import dist

import numpy as np
from folding_schemas.actions import Action, AddVertex, Fold, Program, Unfold

from folding_server.errors import ActionRefused
from folding_server.geometry.graph import edge_of
from folding_server.geometry.line import Point, between
from folding_server.photographer.levels import Level
from folding_server.photographer.replaying import keyframe_papers
from folding_server.photographer.rng import stream
from folding_server.simulator import TOLERANCE, Paper, apply, new_paper
from folding_server.simulator.fold import fold_line

ERROR_SHARES = (*((1.0, 1.0),) * 4, (0.5, 0.7), (0.5, 0.5), (0.2, 0.3), (0.0, 0.3), (0.0, 0.1), (0.0, 0.03))
"""Parts of the full errors of the sheet and of the folds that are tried, until the last step succeeds."""
TRIES = (1.0, 1.0, 1.0, 0.7, 0.5, 0.3, 0.15, 0.0)
"""Parts of the full error of the folds that are tried at each step, until one gives the same model."""
SAME_VERTEX = 0.06
"""Two vertices this near on the sheet may be the same, one folded exactly and one not."""
SAME_MODEL = 0.12
"""No vertex of the imprecise model lies further than this from where it lies in the exact one."""


class Spoilt(Exception):
    """This much imprecision makes another model, or none; try less."""


@dataclass
class Hands:
    """Two papers, one folded exactly and one imprecisely; ``twin`` maps the vertices of the first."""

    exact: Paper
    real: Paper
    twin: dict[int, int]

    def copy(self) -> "Hands":
        """The same hands, to try something with."""
        return replace(self, twin=dict(self.twin))

    def carry_out(self, action: Action, off: float) -> Action:
        """Do an action on both; returns the one that the imprecise paper got. ``off`` in sheet sides."""
        done = self._carried_over(action, off)
        before = set(self.exact.vertices_coords), set(self.real.vertices_coords)
        try:
            self.exact, self.real = apply(self.exact, action), apply(self.real, done)
        except ActionRefused as refusal:
            raise Spoilt from refusal
        for v in sorted(set(self.exact.vertices_coords) - before[0]):
            self.twin[v] = _nearest(
                self.real, self.exact.vertices_coords[v], set(self.real.vertices_coords) - before[1]
            )
        return done

    def _carried_over(self, action: Action, off: float) -> Action:
        if not isinstance(action, AddVertex | Fold | Unfold) or action.edge is None:
            return action
        if any(v not in self.twin for v in action.edge):
            raise Spoilt
        u, v = (self.twin[w] for w in action.edge)
        if isinstance(action, Fold):
            return action.model_copy(update={"edge": (u, v), "direction": self._direction(action, (u, v))})
        if isinstance(action, Unfold):
            return action.model_copy(update={"edge": (u, v)})
        place = between(self.real.vertices_coords[u], self.real.vertices_coords[v], action.position)
        edge = _edge_at(self.real, (u, v), place)
        p, q = self.real.vertices_coords[edge[0]], self.real.vertices_coords[edge[1]]
        length = dist(p, q)
        position = (dist(p, place) + off) / length
        least = min(0.5, 0.01 / length)
        position = round(float(np.clip(position, least, 1 - least)), 6)
        return action.model_copy(update={"edge": edge, "position": position})

    def _direction(self, action: Fold, edge: tuple[int, int]) -> int:
        """The direction that moves the same side, also where a line that should be vertical leans."""
        wanted = fold_line(self.exact, action.edge, action.direction)
        found = fold_line(self.real, edge, 1)
        return 1 if wanted.nx * found.nx + wanted.ny * found.ny > 0 else -1

    def same_model(self) -> bool:
        """Whether every vertex still lies about where it does in the exact model."""
        exact, real = self.exact.folded_vertices_coords, self.real.folded_vertices_coords
        return all(dist(exact[v], real[w]) <= SAME_MODEL for v, w in self.twin.items())


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
        except Spoilt:
            continue
    return program


def _carried_out(program: Program, rng: np.random.Generator, crooked: float, sloppy: float) -> Program:
    """The program on a sheet up to ``crooked`` off square, folded up to ``sloppy`` off. Raises Spoilt."""
    width, height = program.sheet
    uneven = (width, round(height * (1 + rng.uniform(-crooked, crooked)), 6))
    hands = Hands(new_paper(program.sheet), new_paper(uneven), {v: v for v in (1, 2, 3, 4)})
    steps = []
    for step in program.steps:
        hands, done = _step(hands, step, rng, sloppy)
        steps.append(done)
    return program.model_copy(update={"sheet": uneven, "steps": tuple(steps)})


def _step(
    hands: Hands, step: tuple[Action, ...], rng: np.random.Generator, sloppy: float
) -> tuple[Hands, tuple[Action, ...]]:
    """One step with the greatest errors that give the same model. Raises Spoilt if none do."""
    for share in TRIES:
        trial = hands.copy()
        try:
            done = tuple(trial.carry_out(a, share * sloppy * rng.uniform(-1, 1)) for a in step)
        except Spoilt:
            continue
        if trial.same_model():
            return trial, done
    raise Spoilt


def _edge_at(paper: Paper, edge: tuple[int, int], place: Point) -> tuple[int, int]:
    """The edge itself, or where cuts have divided it the part that holds a place. Raises Spoilt."""
    if edge_of(*edge) in paper.edge_faces:
        return edge
    u, v = (paper.vertices_coords[w] for w in edge)
    along = (v[0] - u[0], v[1] - u[1])
    parts = [
        e if (q[0] - p[0]) * along[0] + (q[1] - p[1]) * along[1] > 0 else (e[1], e[0])
        for e in paper.edge_faces
        for p, q in [(paper.vertices_coords[e[0]], paper.vertices_coords[e[1]])]
        if all(dist(u, w) + dist(w, v) < dist(u, v) + TOLERANCE for w in (p, q))
        and dist(p, place) + dist(place, q) < dist(p, q) + TOLERANCE
    ]
    if not parts:
        raise Spoilt
    return min(parts)


def _nearest(paper: Paper, place: tuple[float, float], fresh: set[int]) -> int:
    """The vertex nearest to a place on the sheet, a fresh one if any is near. Raises Spoilt."""
    for candidates in (fresh, set(paper.vertices_coords)):
        near = _distances(paper.vertices_coords, place, candidates)
        if near and min(near)[0] <= SAME_VERTEX:
            return min(near)[1]
    raise Spoilt


def _distances(
    places: Mapping[int, tuple[float, float]], place: tuple[float, float], candidates: set[int]
) -> list[tuple[float, int]]:
    return [(dist(places[v], place), v) for v in candidates]
