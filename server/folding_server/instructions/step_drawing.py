"""A scene drawn in a square: nothing is clipped, arrows bend where there is room, letters lie clear of lines and arrows."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import cos, hypot, pi, sin

from folding_schemas.actions import Flip, Rotate

from folding_server.diagram.drawing import visible_strokes
from folding_server.diagram.palette import DiagramColors
from folding_server.diagram.view import View
from folding_server.diagram.visibility import VisibleFace, visible_faces
from folding_server.geometry.convex import Box
from folding_server.geometry.line import Point, between
from folding_server.instructions.marks import Drawn, DrawnPath, DrawnText, Segment, bounds_of, polyline
from folding_server.instructions.step_scene import StepScene
from folding_server.instructions.symbols import (
    LINE_INK,
    LINE_WIDTH,
    OLD_CREASE_WIDTH,
    SIGN_SIZE,
    Arc,
    arrow,
    fold_lines,
    reference_dot,
    repeat_sign,
    rotate_sign,
    turn_over_sign,
)
from folding_server.simulator import Paper

SIGN_ROOM = 44.0
"""Points below a drawing for the sign of turning over or around."""
PANEL_BORDER = 2.0
PAPER_PART = 0.74
"""The part of a drawing's side that the diagonal of the flat sheet takes, at the scale that a sheet starts with."""
ENLARGEMENTS = (1.0, 1.4, 1.8, 2.4, 3.2, 4.5, 6.0)
TOO_SMALL = 0.5
"""A model is drawn larger when it takes less than this part of the room."""
FILLED = 0.86
"""An enlarged model, with the way of its flap, takes at most this part of the room."""
CREASE_GAP = 1.6
"""Creases that are there stop so many points short of the paper's edge."""
LETTER_REACHES = (8.0, 11.0, 15.0)
"""Points from a spot to the middle of its letter."""


@dataclass(frozen=True)
class StepFigure:
    """A drawing from (0, 0) on, so many points high."""

    drawn: tuple[Drawn, ...]
    height: float


def base_scale(paper: Paper, side: float) -> float:
    """Points for each sheet unit in a drawing that is not enlarged."""
    return PAPER_PART * side / hypot(*paper.sheet)


def enlargement(scene: StepScene, side: float, now: float) -> float:
    """How many times as large a scene is drawn as the flat sheet, if the one before it was drawn ``now`` times as large."""
    xs, ys = zip(*scene.reach, strict=True)
    extent = max((max(xs) - min(xs)) / side, (max(ys) - min(ys)) / side) * base_scale(scene.paper, side)
    fitting = max((f for f in ENLARGEMENTS if f * extent <= FILLED), default=1.0)
    keeps = now <= fitting and (now * extent >= TOO_SMALL or fitting == now)
    return now if keeps else fitting


def draw_scene(scene: StepScene, inks: DiagramColors, side: float, scale: float) -> StepFigure:
    """The drawing, ``side`` points wide, and no higher than wide but for the room of a sign.

    ``scale`` is in points for each sheet unit; smaller where all of it would not fit.
    """
    view = View(side, scale, (0.0, 0.0))
    room = side - 2 * PANEL_BORDER
    drawn: list[Drawn] = []
    for _ in range(4):
        drawn = _draw(scene, inks, view)
        left, top, right, bottom = bounds_of(drawn)
        too_large = max(right - left, bottom - top) / room
        if too_large <= 1.0:
            break
        view = View(side, view.pixels_per_unit / too_large * 0.99, view.center)
    left, top, right, bottom = bounds_of(drawn)
    dx, dy = side / 2 - (left + right) / 2, PANEL_BORDER - top
    drawn = [moved_by(each, dx, dy) for each in drawn]
    height = bottom - top + 2 * PANEL_BORDER
    sign = _sign(scene, (side / 2, height + 0.5 * SIGN_ROOM))
    return StepFigure((*drawn, *sign), height + (SIGN_ROOM if sign else 0.0))


def _sign(scene: StepScene, at: Point) -> list[Drawn]:
    """The sign of turning the whole model, around a point; nothing if it is not turned."""
    if isinstance(scene.sign, Flip):
        return turn_over_sign(at, scene.sign.axis)
    return rotate_sign(at, scene.sign.angle) if isinstance(scene.sign, Rotate) else []


def moved_by(drawn: Drawn, dx: float, dy: float) -> Drawn:
    """The same, moved."""

    def put(point: Point) -> Point:
        return point[0] + dx, point[1] + dy

    if isinstance(drawn, DrawnPath):
        segments = tuple(tuple(put(p) for p in segment) for segment in drawn.segments)
        return DrawnPath(
            drawn.kind, segments, drawn.stroke, drawn.fill, drawn.width, drawn.dashes, drawn.closed
        )
    if isinstance(drawn, DrawnText):
        return DrawnText(
            drawn.kind, put(drawn.at), drawn.text, drawn.size, drawn.ink, drawn.bold, drawn.anchor
        )
    left, top, right, bottom = drawn.box
    return type(drawn)(drawn.kind, (left + dx, top + dy, right + dx, bottom + dy), drawn.jpeg)


def _draw(scene: StepScene, inks: DiagramColors, view: View) -> list[Drawn]:
    drawn = drawn_paper(scene.paper, inks, view)
    outline, edges = bounds_of(drawn), _edge_points(drawn)
    for kind, stretches in scene.lines.items():
        drawn += fold_lines(kind, [view.pixels(stretch) for stretch in stretches])
    arcs: list[Arc] = []
    for way in scene.ways:
        start, end = view.pixels((way.start, way.end))
        arcs.append(_arc(start, end, outline))
        drawn += arrow(way.kind, arcs[-1])
    if len(arcs) > 1:
        drawn += repeat_sign(arcs[0])
    dots = view.pixels(scene.dots)
    drawn += [reference_dot(at) for at in dots]
    lines = [view.pixels(stretch) for stretches in scene.lines.values() for stretch in stretches]
    ink = (
        [point for arc in arcs for point in arc.points()]
        + [p for line in lines for p in _sampled(line)]
        + dots
    )
    named = {letter: view.pixel(at) for letter, at in scene.letters.items()}
    drawn += [_spot(at) for letter, at in named.items() if not _near(at, dots)]
    return drawn + _letters(named, ink, edges, outline)


def drawn_paper(paper: Paper, inks: DiagramColors, view: View) -> list[Drawn]:
    """The paper as it lies: its sides in their colours, edges and folds, thin lines for creases."""
    faces = visible_faces(paper)
    drawn: list[Drawn] = []
    for back_up, fill, name in ((False, inks.front, "front"), (True, inks.back, "back")):
        segments = tuple(
            segment for seen in faces if seen.back_up == back_up for segment in _rings(seen, view)
        )
        if segments:
            drawn.append(DrawnPath(name, segments, fill, fill, 0.3, (), closed=True))
    strokes = visible_strokes(paper, faces, view)
    creases = [_shortened(s.start, s.end) for s in strokes if s.mark]
    edges = [(s.start, s.end) for s in strokes if not s.mark]
    if creases:
        path = tuple(segment for crease in creases for segment in polyline(crease))
        drawn.append(DrawnPath("crease", path, LINE_INK, None, OLD_CREASE_WIDTH))
    path = tuple(segment for edge in edges for segment in polyline(edge))
    return [*drawn, DrawnPath("edge", path, LINE_INK, None, LINE_WIDTH)]


def _rings(seen: VisibleFace, view: View) -> Iterable[Segment]:
    for part in seen.parts:
        for ring in part:
            points = view.pixels(ring)
            yield from polyline([*points, points[0]])


def _shortened(start: Point, end: Point) -> tuple[Point, Point]:
    """A line that stops a little short of both ends."""
    length = hypot(end[0] - start[0], end[1] - start[1])
    gap = min(CREASE_GAP / length, 0.3) if length > 0 else 0.0
    return between(start, end, gap), between(start, end, 1 - gap)


def _arc(start: Point, end: Point, outline: Box) -> Arc:
    """The arc that bends away from the middle of the paper, or upwards where both ways are alike."""
    middle = (outline[0] + outline[2]) / 2, (outline[1] + outline[3]) / 2
    arcs = [Arc(start, end, side) for side in (1, -1)]

    def away(arc: Arc) -> tuple[float, float, float]:
        x, y = arc.at(0.5)
        return round(hypot(x - middle[0], y - middle[1]), 1), -round(y, 1), round(x, 1)

    return max(arcs, key=away)


def _sampled(line: Sequence[Point]) -> list[Point]:
    """Points along a line."""
    return [between(line[0], line[-1], i / 16) for i in range(17)]


def _near(at: Point, points: Iterable[Point]) -> bool:
    return any(hypot(at[0] - x, at[1] - y) < 2 for x, y in points)


def _spot(at: Point) -> Drawn:
    """The dot of a point that a letter names."""
    corners = [(at[0] + 1.1 * cos(i * pi / 4), at[1] + 1.1 * sin(i * pi / 4)) for i in range(8)]
    return DrawnPath("spot", polyline(corners), LINE_INK, LINE_INK, 0.3, (), closed=True)


def _letters(
    named: dict[str, Point], ink: Sequence[Point], edges: Sequence[Point], outline: Box
) -> list[Drawn]:
    """Each letter beside its point, where it lies over least ink, over few edges of the paper, and nearest."""
    taken = [*ink, *named.values()]
    middle = (outline[0] + outline[2]) / 2, (outline[1] + outline[3]) / 2
    drawn: list[Drawn] = []
    for letter, at in named.items():
        spots = [
            (at[0] + reach * cos(i * pi / 8), at[1] + reach * sin(i * pi / 8))
            for reach in LETTER_REACHES
            for i in range(16)
        ]
        best = min(spots, key=lambda spot: _cost(spot, at, taken, middle) + 4 * _under(spot, edges))
        taken += [(best[0] + dx, best[1] + dy) for dx in (-3, 0, 3) for dy in (-3, 0, 3)]
        place = best[0], best[1] + 0.36 * SIGN_SIZE
        drawn.append(DrawnText("letter", place, letter, SIGN_SIZE, bold=True, anchor="middle"))
    return drawn


def _cost(spot: Point, at: Point, taken: Iterable[Point], middle: Point) -> float:
    """What a letter's place costs: ink under it, distance from its point, and lying inwards."""
    inwards = hypot(spot[0] - middle[0], spot[1] - middle[1]) < hypot(at[0] - middle[0], at[1] - middle[1])
    return 20 * _under(spot, taken) + hypot(spot[0] - at[0], spot[1] - at[1]) + 2 * inwards


def _under(spot: Point, points: Iterable[Point]) -> int:
    """How many points lie under a letter."""
    return sum(abs(x - spot[0]) < 5.2 and abs(y - spot[1]) < 6.0 for x, y in points)


def _edge_points(drawn: Iterable[Drawn]) -> list[Point]:
    """Points along the edges of the drawn paper, close enough to be found under letters."""
    lines = [
        segment
        for each in drawn
        if isinstance(each, DrawnPath) and each.kind == "edge"
        for segment in each.segments
    ]
    return [point for line in lines if len(line) == 2 for point in _sampled(line)]
