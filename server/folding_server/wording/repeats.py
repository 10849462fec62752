"""Folds that are repeated on the other side: two moves that are mirror images of each other as one, as books have them."""

from dataclasses import replace
from math import dist

from folding_server.geometry.line import Line, Point
from folding_server.instructions.moves import Lesson, Move
from folding_server.instructions.step_scene import layers_turned
from folding_server.photographer.movements import swing_of
from folding_server.wording.describing import moving_corners, say_move
from folding_server.wording.landmarks import MEETING, Landmarks
from folding_server.wording.refolding import mirrored_line, mirrored_point

SAME_NORMAL = 1e-3
"""Normals of lines that are no further apart are one."""


def with_repeats(lesson: Lesson) -> Lesson:
    """The lesson with each fold that the next one repeats on the other side as one move with it, where words can say so."""
    joined: list[Move] = []
    for move in lesson.moves:
        last = joined[-1] if joined else None
        whole = _repeated(last, move) if last else None
        if whole is not None:
            joined[-1] = whole
        else:
            joined.append(move)
    return replace(lesson, moves=tuple(joined))


def _repeated(first: Move, second: Move) -> Move | None:
    """Both as one move, if they are mirror images, left and right, and the words of it lead to the same paper."""
    if first.kind != "fold" or second.kind != "fold" or first.repeat is not None or not _alike(first, second):
        return None
    whole = replace(first, after=second.after, repeat=second)
    return whole if say_move(whole, first.base).exact else None


def _alike(first: Move, second: Move) -> bool:
    swings = [swing_of(move.action, move.before, move.turned) for move in (first, second)]
    middle = Landmarks(first.base).middle
    wanted, found = mirrored_line(swings[0].line, middle), swings[1].line
    if layers_turned(swings[0]) != layers_turned(swings[1]) or not _same_line(wanted, found):
        return False
    there = moving_corners(swings[1])
    return all(_among(mirrored_point(corner, middle), there) for corner in moving_corners(swings[0]))


def _same_line(first: Line, second: Line) -> bool:
    """Whether two lines and the sides that they move are the same."""
    return dist(first[:2], second[:2]) <= SAME_NORMAL and abs(first.offset - second.offset) <= MEETING


def _among(point: Point, points: list[Point]) -> bool:
    return any(dist(point, other) <= 2 * MEETING for other in points)
