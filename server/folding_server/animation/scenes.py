"""A lesson as scenes of a film: parts that swing about a line in space, or a model that turns on the table."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import cos, pi, radians, sin

import numpy as np
from folding_schemas.actions import Rotate, Unfold

from folding_server.arrays import Floats
from folding_server.geometry.convex import area
from folding_server.geometry.line import Line, Point
from folding_server.instructions.moves import Lesson, Move
from folding_server.photographer.movements import Swing, swing_of
from folding_server.photographer.placement import layer_levels
from folding_server.simulator import Paper
from folding_server.simulator.state_diff import origins

LAYER_GAP = 0.012
"""Distance between layers in sheet units: some ten times that of real paper, so that layers are told apart."""


@dataclass(frozen=True)
class FilmScene:
    """One movement: ``swing``, or a turn in the plane by ``degrees``. ``move`` counts moves from 0, for their words."""

    move: int
    before: Paper
    after: Paper
    swing: Swing | None = None
    degrees: float = 0.0

    @cached_property
    def middles(self) -> tuple[Point, Point]:
        """The middle of the box around the paper, before and after: films keep it in the middle of the picture."""
        return middle_of(self.before), middle_of(self.after)

    @cached_property
    def levels(self) -> tuple[Mapping[int, int], Mapping[int, int]]:
        """The layers below each face, before and after, both by the faces of the paper after."""
        after = layer_levels(self.after)
        if self.swing is None:
            return after, after
        return _levels_before(self.swing), after


@dataclass(frozen=True)
class FaceInSpace:
    """A face on its way: corners (n, 3) in sheet units about the middle of the paper, and the layers below it.

    ``area`` is the signed area of its outline, and ``back_up`` its side, as it lies after the movement.
    """

    face: int
    corners: Floats
    moves: bool
    level: float
    area: float
    back_up: bool


def film_scenes(lesson: Lesson) -> list[FilmScene]:
    """The movements of a lesson, in order."""
    return [scene for number, move in enumerate(lesson.moves) for scene in _scenes(number, move)]


def middle_of(paper: Paper) -> Point:
    """The middle of the box around a paper."""
    xs, ys = zip(*paper.folded_vertices_coords.values(), strict=True)
    return (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2


def extent_of(paper: Paper) -> float:
    """How far a paper reaches from the middle of its box, twice."""
    x, y = middle_of(paper)
    return 2 * max(max(abs(px - x), abs(py - y)) for px, py in paper.folded_vertices_coords.values())


def faces_in_space(scene: FilmScene, part: float) -> list[FaceInSpace]:
    """The faces at a part of the movement, 0 to 1, from bottom to top as they lie after it."""
    center = tuple(a + (b - a) * part for a, b in zip(*scene.middles, strict=True))
    paper, swing = scene.after, scene.swing
    if swing is None:
        return _turning(scene, part, center)
    before, after = scene.levels
    found = []
    for face in paper.order:
        start = swing.starts.get(face)
        coords = [paper.vertices_coords[v] for v in paper.faces[face]]
        levels = before[face], after[face]
        if start is None:
            flat = np.array([paper.isometries[face](at) for at in coords])
            level = levels[0] + (levels[1] - levels[0]) * part
            corners = np.column_stack([flat, np.full(len(flat), level * LAYER_GAP)])
        else:
            corners = _swung(np.array([start(at) for at in coords]), swing, part, levels)
            level = levels[1] if part > 0.5 else levels[0]
        found.append(_placed(paper, face, corners - [*center, 0.0], start is not None, level))
    return found


def _scenes(number: int, move: Move) -> Iterator[FilmScene]:
    if move.kind == "mark":
        return
    if isinstance(move.action, Rotate):
        yield FilmScene(number, move.before, move.after, None, move.action.angle)
        return
    yield FilmScene(number, move.before, move.turned, swing_of(move.action, move.before, move.turned))
    if move.kind == "fold-and-unfold":
        yield FilmScene(number, move.turned, move.after, swing_of(Unfold(), move.turned, move.after))


def _levels_before(swing: Swing) -> Mapping[int, int]:
    """The layers below each face of the paper after, as it lay before the swing: faces keep their number or were cut."""
    known = layer_levels(swing.before)
    return {face: known[origin] for face, origin in origins(swing.before, swing.paper).items()}


def _turning(scene: FilmScene, part: float, center: tuple[float, ...]) -> list[FaceInSpace]:
    """The model turned in its plane, clockwise."""
    angle = radians(scene.degrees) * part
    turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
    level, paper = scene.levels[0], scene.before
    mean = np.array(list(paper.folded_vertices_coords.values())).mean(axis=0)
    found = []
    for face in paper.order:
        flat = (np.array(paper.polygon(face)) - mean) @ turn + mean - center
        corners = np.column_stack([flat, np.full(len(flat), level[face] * LAYER_GAP)])
        found.append(_placed(paper, face, corners, moves=False, level=level[face]))
    return found


def _placed(paper: Paper, face: int, corners: Floats, moves: bool, level: float) -> FaceInSpace:
    return FaceInSpace(face, corners, moves, level, area(paper.polygon(face)), paper.back_up(face))


def _swung(flat: Floats, swing: Swing, part: float, levels: tuple[int, int]) -> Floats:
    """Corners (n, 3) of a face that swings: about the line over the rest, or under it.

    Its layer keeps to its side of the flap: half the difference of its heights stands square to the flap.
    """
    angle = (1 if swing.over else -1) * pi * part
    line: Line = swing.line
    normal = np.array([line.nx, line.ny])
    apart = flat @ normal - line.offset
    square, common = (levels[0] - levels[1]) / 2 * LAYER_GAP, (levels[0] + levels[1]) / 2 * LAYER_GAP
    across = apart * cos(angle) - square * sin(angle)
    height = apart * sin(angle) + square * cos(angle) + common
    return np.column_stack([flat + np.outer(across - apart, normal), height])
