"""What one action may make of a paper, as stacks to draw: the hypotheses that a photo from any camera is held against."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from folding_schemas.actions import Actions, Flip
from folding_schemas.results import ActionClass

from folding_server.geometry.line import Line
from folding_server.simulator import apply
from folding_server.simulator.paper import Paper
from folding_server.vision.registration.scene import FaceStack, face_stack
from folding_server.vision.solver.lines import (
    Lines,
    all_lines,
    as_line,
    axes_of,
    both_ways,
    distinct_lines,
    distinct_points,
    landmark_lines,
)
from folding_server.vision.solver.movable_layers import MovableLayers, MovingSet
from folding_server.vision.solver.realise import realise
from folding_server.vision.solver.symmetry import mirrored
from folding_server.vision.solver.whole_moves import each_unfolding

FAN_STEP = 6.0
"""Degrees between the lines that are tried through each vertex beside those that landmarks give."""
FAN_FACES = 30
"""On papers of more faces the fan is left out: their vertices are so many that landmark lines lie close enough."""

GRID_DEGREES, GRID_SPACING = 10.0, 0.06
"""Between lines anywhere on the paper, in degrees and sheet units: both ends of a crease are then fitted from 0.03 beside."""
GRID_FACES, PAIRED_FACES = 16, 20
"""On papers of more faces lines anywhere, and pairs of folds, would take too long to try."""

Ways = Callable[[], list[tuple[Actions, Paper]]]


@dataclass(frozen=True)
class Hypothesis:
    """An action of a class, the ``stack`` that it leads to, and the ``ways`` in which it is made of actions.

    ``constructed`` says that a fold's line is one that landmarks give, ``moving`` what a fold turns.
    """

    action_class: ActionClass
    stack: FaceStack
    ways: Ways
    constructed: bool = True
    moving: MovingSet | None = None


def hypotheses(paper: Paper) -> list[Hypothesis]:
    """Nothing, the model turned over, what can be unfolded, and folds along landmarks and through vertices."""
    return [*_as_it_lies(paper), *_unfolded(paper), *_folded(paper)]


def further_hypotheses(paper: Paper) -> list[Hypothesis]:
    """What is tried where none of :func:`hypotheses` explains the photo: the same fold on both sides, and folds anywhere."""
    pairs = _folded_on_both_sides(paper) if len(paper.faces) <= PAIRED_FACES else ()
    anywhere = all_lines(paper, GRID_DEGREES, GRID_SPACING) if len(paper.faces) <= GRID_FACES else ()
    layers = MovableLayers(paper)
    return [
        *pairs,
        *(
            Hypothesis("fold", layers.folded(moving), _fold_ways(paper, moving, False), False, moving)
            for row in both_ways(np.asarray(anywhere).reshape(-1, 3))
            for moving in layers.moving_sets(as_line(row))
        ),
    ]


def _as_it_lies(paper: Paper) -> Iterator[Hypothesis]:
    """Nothing, and a flip: about which axis, and any turn, the camera's roll tells."""
    yield Hypothesis("none", face_stack(paper), lambda: [((), paper)])
    flip = Flip(axis="y")
    over = apply(paper, flip)
    yield Hypothesis("flip", face_stack(over), lambda: [((flip,), over)])


def _unfolded(paper: Paper) -> Iterator[Hypothesis]:
    """Each fold undone, and each pair of folds."""
    seen: set[frozenset[object]] = set()
    for action, after in each_unfolding(paper):
        yield Hypothesis("unfold", face_stack(after), _one_way((action,), after))
        for second, final in each_unfolding(after):
            key = frozenset(final.creases.items())
            if key not in seen:
                seen.add(key)
                yield Hypothesis("compound", face_stack(final), _one_way((action, second), final))


def _one_way(actions: Actions, after: Paper) -> Ways:
    return lambda: [(actions, after)]


def _folded(paper: Paper) -> Iterator[Hypothesis]:
    """Folds of every set of layers that can be turned."""
    layers = MovableLayers(paper)
    landmarks = landmark_lines(paper)
    fan = _fan(paper) if len(paper.faces) <= FAN_FACES else landmarks[:0]
    lines = distinct_lines(np.concatenate([landmarks, fan]))
    known = {tuple(row) for row in np.round(distinct_lines(landmarks), 6).tolist()}
    for row in both_ways(lines):
        upright = tuple(np.round(row, 6).tolist()) in known or tuple(np.round(-row, 6).tolist()) in known
        for moving in layers.moving_sets(as_line(row)):
            yield Hypothesis(
                "fold", layers.folded(moving), _fold_ways(paper, moving, upright), upright, moving
            )


def _folded_on_both_sides(paper: Paper) -> Iterator[Hypothesis]:
    """Each fold along a landmark together with its mirror image about an axis of symmetry."""
    layers = MovableLayers(paper)
    tried: set[frozenset[tuple[float, ...]]] = set()
    for axis in axes_of(paper):
        for row in both_ways(landmark_lines(paper)):
            image = mirrored(row[None], axis[None])[0]
            both = frozenset(tuple(np.round(line, 3).tolist()) for line in (row, image))
            if len(both) < 2 or both in tried:
                continue
            tried.add(both)
            for first, second in product(*(list(layers.moving_sets(as_line(x))) for x in (row, image))):
                stack = layers.folded_both(first, second)
                if stack is not None:
                    yield Hypothesis("compound", stack, _both_ways(paper, first, as_line(image)))


def _both_ways(paper: Paper, first: MovingSet, second: Line) -> Ways:
    """Actions that make a fold, and then one along another line, with each set of layers that this can turn."""

    def made() -> list[tuple[Actions, Paper]]:
        return [
            ((*actions, *more), after)
            for actions, between in realise(paper, first, exact=True)
            for moving in MovableLayers(between).moving_sets(second)
            for more, after in realise(between, moving, exact=True)
        ]

    return made


def _fold_ways(paper: Paper, moving: MovingSet, exact: bool) -> Ways:
    return lambda: realise(paper, moving, exact=exact)


def _fan(paper: Paper) -> Lines:
    """Lines through each vertex as it lies, at every FAN_STEP degrees."""
    angles = np.radians(np.arange(0.0, 180.0, FAN_STEP))
    normals = np.column_stack([np.cos(angles), np.sin(angles)])
    points = distinct_points(paper)
    offsets = points @ normals.T
    return np.column_stack([np.tile(normals, (len(points), 1)), offsets.ravel()])
