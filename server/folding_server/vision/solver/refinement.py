"""Creases put where all photos together show them.

People fold a little beside the landmarks they aim at, and a crease that is found from one photo is a little off. Each
error is small, but later folds run through the vertices so made. So all vertices that a program adds, and the camera of
every photo, are fitted to all photos at once; where the photos tell that they lie elsewhere, the program says so. Where
each photo has a camera of its own, so is the sheet, which is never quite square; of that the program says nothing.
"""

from collections.abc import Callable, Iterator, Sequence
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
from folding_server.vision.pose_estimation.pinhole import PinholeCamera, only_moved, upright_camera
from folding_server.vision.registration.scene import FaceStack, Scene, face_stack
from folding_server.vision.seeing import SequenceObserver
from folding_server.vision.solver.photo_views import likeliest_view

Steps = tuple[Actions, ...]
"""The actions between each two photos."""

SIGNIFICANT = 5.0
"""How many times the variance that is left each offset must explain."""
WORTH_MOVING = 0.006
"""How far a vertex of the sheet must come to lie elsewhere, in sheet units."""
SHEET_STEP = 0.002
"""The height of the sheet is told to so much, as a part of its width: half a pixel of a photo."""
REFINEMENTS_KEPT = 40
"""Refinements kept: those of the steps before are begun from."""


@dataclass(frozen=True)
class Refined:
    """A program's ``steps`` after refinement, for a square sheet as the program itself is.

    ``gain`` is how many times the variance that is left each offset explains, ``moved`` how far a vertex came to lie
    elsewhere, ``uneven`` how much higher than wide the sheet is. ``paper`` is what the photos show: that sheet, with creases where
    they are told to lie; ``twin`` leads to its vertices from those of the program.
    """

    steps: Steps
    paper: Paper
    twin: dict[int, int]
    gain: float = 0.0
    moved: float = 0.0
    uneven: float = 0.0

    @property
    def told(self) -> bool:
        """Whether the photos tell that creases lie elsewhere."""
        return self.gain >= SIGNIFICANT and self.moved >= WORTH_MOVING

    @property
    def seen_otherwise(self) -> bool:
        """Whether the photos show another paper than the program makes."""
        return self.told or self.uneven != 0.0


@dataclass(frozen=True)
class _Fit:
    """What was fitted to the photos up to that after some steps: how ``uneven`` the sheet is and the ``offsets`` of the vertices that
    were added; for each photo the part that shows the paper, and the camera.
    """

    uneven: float
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
    fit = known[steps[:begun]] if begun else _first(observer)
    for count in range(begun + 1, len(steps) + 1):
        fit = _further(fit, steps[:count], observer)
        while len(known) >= REFINEMENTS_KEPT:
            known.pop(next(iter(known)))
        known[steps[:count]] = fit
    return fit


def _first(observer: SequenceObserver) -> _Fit:
    """What the photo of the flat sheet tells."""
    scene, camera = _seen(face_stack(new_paper()), observer, 1)
    return _Fit(0.0, (), (scene,), (camera,), _unrefined(()))


def _seen(
    stack: FaceStack, observer: SequenceObserver, frame: int
) -> tuple[Scene | None, PinholeCamera | None]:
    """The part of a photo that shows a stack best, and the camera; neither if the photo shows no paper."""
    found = likeliest_view(stack, observer, frame)
    return (None, None) if found is None else (found[0].scene, found[1].camera)


def _further(before: _Fit, steps: Steps, observer: SequenceObserver) -> _Fit:
    """A fit with one photo more."""
    movable = MovableVertices(steps)
    offsets = np.array([*before.offsets, *[0.0] * (len(movable.added) - len(before.offsets))])
    stacks = movable.stacks(offsets, before.uneven)
    if stacks is None:
        offsets = np.zeros(len(movable.added))
        stacks = movable.stacks(offsets, before.uneven)
    if stacks is None:
        unknown = (*before.scenes, None), (*before.cameras, None)
        return _Fit(before.uneven, tuple(offsets.tolist()), *unknown, _unrefined(steps))
    scene, camera = _seen(stacks[-1], observer, len(steps) + 1)
    scenes, cameras = (*before.scenes, scene), (*before.cameras, camera)
    fit = _Fit(before.uneven, tuple(offsets.tolist()), scenes, cameras, _unrefined(steps))
    seen = [i for i, camera in enumerate(cameras) if camera is not None]
    return _adjusted(fit, movable, seen, free=_framed_anew(observer, fit)) if seen else fit


def _framed_anew(observer: SequenceObserver, fit: _Fit) -> bool:
    """Whether most photos have a camera of their own. Else the first photo's shows every sheet as a square, uneven or not."""
    seen = [
        only_moved(camera, upright_camera(observer.pose, view.frame))
        for frame, camera in enumerate(fit.cameras, start=1)
        if camera is not None and frame > 1
        for view in observer.pictures(frame)[:1]
    ]
    return 2 * sum(seen) < len(seen)


def _adjusted(fit: _Fit, movable: "MovableVertices", seen: Sequence[int], *, free: bool) -> _Fit:
    """The fit with the sheet, if that is ``free``, the creases and the cameras of the photos ``seen`` put where all of these show them."""

    def shown(offsets: Floats) -> Sequence[FaceStack] | None:
        stacks = movable.stacks(offsets[1:], float(offsets[0]))
        return None if stacks is None else [stacks[i] for i in seen]

    def only(unknown: Sequence[int]) -> Callable[[Floats], Sequence[FaceStack] | None]:
        return lambda values: shown(_filled(values, unknown, len(movable.added) + 1))

    bundle = Bundle(
        tuple(scene for scene in fit.scenes if scene is not None),
        tuple(camera for camera in fit.cameras if camera is not None),
        (),
    )
    first = [0, *(sum(i <= step for i in seen) for step, _ in movable.added)]
    begun = np.array([fit.uneven, *fit.offsets])
    sheet, every = [0] * free, [*[0] * free, *range(1, len(begun))]
    unmoved = adjusted(only(sheet), replace(bundle, first_shown=tuple(first[k] for k in sheet)), begun[sheet])
    best = adjusted(only(every), replace(bundle, first_shown=tuple(first[k] for k in every)), begun[every])
    if best.cost > unmoved.cost:
        start = _filled(unmoved.offsets, sheet, len(begun))[every]
        again = replace(bundle, cameras=unmoved.cameras, first_shown=tuple(first[k] for k in every))
        best = adjusted(only(every), again, start)
    if not isfinite(best.cost) or not isfinite(unmoved.cost):
        return fit
    freedom = (INDEPENDENT_POINTS - 6) * len(seen)
    gain = (unmoved.cost - best.cost) / max(len(fit.offsets), 1) / max(best.cost / freedom, 1e-9)
    taken = dict(zip(seen, best.cameras, strict=True))
    uneven, *offsets = _filled(best.offsets, every, len(begun)).tolist()
    sheets = uneven, _filled(unmoved.offsets, sheet, 1).tolist()[0]
    return replace(
        fit,
        uneven=uneven,
        offsets=tuple(offsets),
        cameras=tuple(taken.get(i, camera) for i, camera in enumerate(fit.cameras)),
        refined=_refined(movable, np.array(offsets), gain, sheets),
    )


def _filled(values: Floats, places: Sequence[int], count: int) -> Floats:
    """So many zeros, with values at some places."""
    filled = np.zeros(count)
    filled[list(places)] = values
    return filled


def _unrefined(steps: Steps) -> Refined:
    """The steps as they are."""
    paper = replay([action for step in steps for action in step])
    return Refined(steps, paper, {v: v for v in paper.vertices_coords})


def _refined(
    movable: "MovableVertices", offsets: Floats, gain: float, sheets: tuple[float, float]
) -> Refined:
    """The steps with offsets, on a sheet as uneven as the first of ``sheets``; or if they need not be moved, on one as the second."""
    try:
        done = movable.carried_out(offsets, 0.0)
    except NoCounterpart:
        return _unevenly(_unrefined(movable.steps), movable, np.zeros(len(offsets)), sheets[1])
    last = done[-1][0]
    exact, real = last.exact.vertices_coords, last.real.vertices_coords
    moved = max(dist(exact[v], real[w]) for v, w in last.twin.items())
    found = Refined(tuple(actions for _, actions in done), last.real, last.twin, gain, moved)
    if found.told:
        return _unevenly(found, movable, offsets, sheets[0])
    return _unevenly(found, movable, np.zeros(len(offsets)), sheets[1])


def _unevenly(found: Refined, movable: "MovableVertices", offsets: Floats, uneven: float) -> Refined:
    """What was found, with the paper that the photos show of a sheet so uneven; unchanged if it cannot be folded."""
    uneven = round(uneven / SHEET_STEP) * SHEET_STEP
    try:
        papers, _ = movable.carried_out(offsets, uneven)[-1]
    except NoCounterpart:
        return found
    return replace(found, paper=papers.real, twin=papers.twin, uneven=uneven)


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
    """A program whose added vertices can be moved along their edges, on a sheet that need not be square; every action is carried over
    to the vertices that cuts then make.

    ``added`` are the places of these vertices in the program, step and action.
    """

    def __init__(self, steps: Steps) -> None:
        self.steps = steps
        self.added = tuple(
            (i, j)
            for i, step in enumerate(steps)
            for j, action in enumerate(step)
            if isinstance(action, AddVertex)
        )
        self._known: dict[tuple[float, ...], tuple[Counterpart, Actions] | None] = {}

    def stacks(self, offsets: Floats, uneven: float = 0.0) -> list[FaceStack] | None:
        """The stack before the first step and after each, offsets (m,) in sheet units; None if it cannot be folded so."""
        try:
            done = self.carried_out(offsets, uneven)
        except NoCounterpart:
            return None
        return [face_stack(_sheet(uneven)), *(face_stack(papers.real) for papers, _ in done)]

    def carried_out(self, offsets: Floats, uneven: float = 0.0) -> list[tuple[Counterpart, Actions]]:
        """After each step the papers folded as the program says and with the offsets, and the actions of the second. Raises
        NoCounterpart if it cannot be folded so.
        """
        done, papers, used = [], Counterpart.of(new_paper(), _sheet(uneven)), 0
        for index, step in enumerate(self.steps):
            used += _adding(step)
            key = (float(index), uneven, *offsets[:used].tolist())
            if key not in self._known:
                self._known[key] = _step(papers, step, iter(offsets[used - _adding(step) : used].tolist()))
            known = self._known[key]
            if known is None:
                raise NoCounterpart
            papers, _ = known
            done.append(known)
        return done


def _sheet(uneven: float) -> Paper:
    """A flat sheet that is so much higher than wide."""
    return new_paper((1.0, 1.0 + uneven))


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
