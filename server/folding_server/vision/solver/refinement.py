"""Creases put where all photos together show them.

People fold a little beside the landmarks they aim at, and a crease that is found from one photo is a little off. Each
error is small, but later folds run through the vertices so made. So all vertices that a program adds, and the camera of
every photo, are fitted to all photos at once; where the photos tell that they lie elsewhere, the program says so.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import dist, isfinite

import numpy as np
from folding_schemas.actions import Action, Actions, AddVertex

from folding_server.arrays import Floats
from folding_server.simulator.apply import replay
from folding_server.simulator.counterpart import Counterpart, NoCounterpart
from folding_server.simulator.paper import Paper, new_paper
from folding_server.vision.pose_estimation.border_fitting import INDEPENDENT_POINTS
from folding_server.vision.pose_estimation.bundle_adjustment import Bundle, adjusted
from folding_server.vision.pose_estimation.pinhole import PinholeCamera
from folding_server.vision.registration.scene import FaceStack, Scene, face_stack
from folding_server.vision.seeing import SequenceObserver
from folding_server.vision.solver.photo_views import likeliest_view

Steps = tuple[Actions, ...]
"""The actions between each two photos."""

SIGNIFICANT = 5.0
"""How many times the variance that is left each offset must explain."""
WORTH_MOVING = 0.006
"""How far a vertex of the sheet must come to lie elsewhere, in sheet units."""
REFINEMENTS_KEPT = 40
"""Refinements kept: those of the steps before are begun from."""


@dataclass(frozen=True)
class Refined:
    """A program's steps after refinement; ``twin`` leads from its own vertices to those of ``steps``, whose last paper is ``paper``.

    ``gain`` is how many times the variance that is left each offset explains, ``moved`` how far a vertex came to lie elsewhere.
    """

    steps: Steps
    paper: Paper
    twin: dict[int, int]
    gain: float
    moved: float

    @property
    def told(self) -> bool:
        """Whether the photos tell that creases lie elsewhere."""
        return self.gain >= SIGNIFICANT and self.moved >= WORTH_MOVING


@dataclass(frozen=True)
class _Fit:
    """What was fitted to the photos after some steps."""

    offsets: tuple[float, ...]
    scenes: tuple[Scene | None, ...]
    cameras: tuple[PinholeCamera | None, ...]
    refined: Refined


def refined(steps: Steps, observer: SequenceObserver) -> Refined:
    """The steps that lead from the flat sheet to the photo after the last of them, with their creases where all these photos show
    them. Deterministic; what was found for the steps before is remembered, and begun from.
    """
    return _fitted(steps, observer).refined


def revised(steps: Steps, observer: SequenceObserver) -> Steps:
    """The steps, refined where the photos tell that creases lie elsewhere."""
    known = refined(steps, observer)
    return known.steps if known.told else steps


def _fitted(steps: Steps, observer: SequenceObserver) -> _Fit:
    """All creases and cameras, begun from those of the steps before."""
    known: dict[Steps, _Fit] = observer.refinements
    begun = len(steps)
    while begun and steps[:begun] not in known:
        begun -= 1
    fit = known[steps[:begun]] if begun else _Fit((), (), (), _unrefined(()))
    for count in range(begun + 1, len(steps) + 1):
        fit = _further(fit, steps[:count], observer)
        while len(known) >= REFINEMENTS_KEPT:
            known.pop(next(iter(known)))
        known[steps[:count]] = fit
    return fit


def _further(before: _Fit, steps: Steps, observer: SequenceObserver) -> _Fit:
    """A fit with one photo more."""
    movable = MovableVertices(steps)
    start = np.array([*before.offsets, *[0.0] * (len(movable.added) - len(before.offsets))])
    stacks = movable.stacks(start)
    if stacks is None:
        start = np.zeros(len(movable.added))
        stacks = movable.stacks(start)
    if stacks is None:
        unknown = (*before.scenes, None), (*before.cameras, None)
        return _Fit(tuple(start.tolist()), *unknown, _unrefined(steps))
    found = likeliest_view(stacks[-1], observer, len(steps) + 1)
    scene, camera = (None, None) if found is None else (found[0].scene, found[1].camera)
    scenes, cameras = (*before.scenes, scene), (*before.cameras, camera)
    seen = [i for i, camera in enumerate(cameras) if camera is not None]
    fit = _Fit(tuple(start.tolist()), scenes, cameras, _unrefined(steps))
    return _adjusted(fit, movable, seen) if seen and len(start) else fit


def _adjusted(fit: _Fit, movable: "MovableVertices", seen: Sequence[int]) -> _Fit:
    """A fit with creases and cameras where all photos show them, of which those ``seen`` show the paper."""

    def shown(offsets: Floats) -> Sequence[FaceStack] | None:
        stacks = movable.stacks(offsets)
        return None if stacks is None else [stacks[i] for i in seen]

    first = tuple(sum(i < step for i in seen) for step, _ in movable.added)
    bundle = Bundle(
        tuple(s for s in fit.scenes if s is not None), tuple(c for c in fit.cameras if c is not None), first
    )
    start, nowhere = np.array(fit.offsets), np.zeros(len(fit.offsets))
    unmoved = adjusted(lambda _: shown(nowhere), replace(bundle, first_shown=()), np.zeros(0))
    best = adjusted(shown, bundle, start)
    if best.cost > unmoved.cost:
        best = adjusted(shown, replace(bundle, cameras=unmoved.cameras), nowhere)
    if not isfinite(best.cost) or not isfinite(unmoved.cost):
        return fit
    freedom = (INDEPENDENT_POINTS - 6) * len(seen)
    gain = (unmoved.cost - best.cost) / len(start) / max(best.cost / freedom, 1e-9)
    taken = dict(zip(seen, best.cameras, strict=True))
    return _Fit(
        tuple(best.offsets.tolist()),
        fit.scenes,
        tuple(taken.get(i) for i in range(len(fit.scenes))),
        _refined(movable, best.offsets, gain),
    )


def _unrefined(steps: Steps) -> Refined:
    """The steps as they are."""
    paper = replay([action for step in steps for action in step])
    return Refined(steps, paper, {v: v for v in paper.vertices_coords}, 0.0, 0.0)


def _refined(movable: "MovableVertices", offsets: Floats, gain: float) -> Refined:
    """The steps with offsets."""
    done = movable.carried_out(offsets)
    last = done[-1][0]
    exact, real = last.exact.vertices_coords, last.real.vertices_coords
    moved = max(dist(exact[v], real[w]) for v, w in last.twin.items())
    return Refined(tuple(actions for _, actions in done), last.real, last.twin, gain, moved)


def carried_back(actions: Actions, known: Refined, paper: Paper) -> tuple[Actions, Paper] | None:
    """Actions on the refined paper as those on the ``paper`` that the unrefined steps lead to, and what they make of it; None if they
    cannot be done there.
    """
    papers = Counterpart(known.paper, paper, {w: v for v, w in known.twin.items()})
    try:
        done = tuple(papers.carry_out(action, 0.0) for action in actions)
    except NoCounterpart:
        return None
    return (done, papers.real) if papers.same_model() else None


class MovableVertices:
    """A program whose added vertices can be moved along their edges; every action is carried over to the vertices that cuts then make.

    ``added`` are the places of these vertices in the program, step and action.
    """

    def __init__(self, steps: Steps) -> None:
        self._steps = steps
        self.added = tuple(
            (i, j)
            for i, step in enumerate(steps)
            for j, action in enumerate(step)
            if isinstance(action, AddVertex)
        )
        self._known: dict[tuple[float, ...], tuple[Counterpart, Actions] | None] = {}

    def stacks(self, offsets: Floats) -> list[FaceStack] | None:
        """The stack after each step, offsets (m,) in sheet units; None if it cannot be folded so."""
        try:
            return [face_stack(papers.real) for papers, _ in self.carried_out(offsets)]
        except NoCounterpart:
            return None

    def carried_out(self, offsets: Floats) -> list[tuple[Counterpart, Actions]]:
        """After each step the papers folded as the program says and with the offsets, and the actions of the second. Raises
        NoCounterpart if it cannot be folded so.
        """
        done, papers, used = [], Counterpart.of(new_paper(), new_paper()), 0
        for index, step in enumerate(self._steps):
            used += _adding(step)
            key = (float(index), *offsets[:used].tolist())
            if key not in self._known:
                self._known[key] = _step(papers, step, iter(offsets[used - _adding(step) : used].tolist()))
            known = self._known[key]
            if known is None:
                raise NoCounterpart
            papers, _ = known
            done.append(known)
        return done


def _adding(step: Actions) -> int:
    """How many vertices a step adds."""
    return sum(isinstance(action, AddVertex) for action in step)


def _step(papers: Counterpart, step: Actions, offsets: Iterator[float]) -> tuple[Counterpart, Actions] | None:
    """Both papers after a step; None if it makes another model."""
    papers, done = papers.copy(), list[Action]()
    try:
        for action in step:
            done.append(papers.carry_out(action, next(offsets) if isinstance(action, AddVertex) else 0.0))
    except NoCounterpart:
        return None
    return (papers, tuple(done)) if papers.same_model() else None
