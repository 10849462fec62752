"""Vertex labels that do not overlap: the cheapest place around each vertex, then a few rounds of mending.

Lengths are pixels of the picture. A label that cannot sit beside its vertex is moved out and
tied to it by a line.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import hypot, pi, sqrt

import numpy as np
import shapely

from folding_server.arrays import Bools, Floats
from folding_server.diagram.view import REFERENCE_SIZE, View
from folding_server.diagram.visibility import SLIVER, VisibleFace
from folding_server.geometry.convex import Box
from folding_server.geometry.line import Point
from folding_server.simulator.paper import Paper

FONT_SIZE = 13.0
SMALLEST_FONT_SIZE = 5.0
"""In pixels at the reference size."""
DIGIT_WIDTH, COMMA_WIDTH, LINE_HEIGHT = 0.7, 0.38, 1.16
"""In font sizes; the widths are those of a bold sans-serif."""
IDS_PER_LINE = 4
LABEL_DIRECTIONS = 16
"""How many directions from a vertex are tried."""
LABEL_REACHES = (5.0, 12.0, 22.0, 34.0, 48.0, 66.0, 88.0, 114.0)
"""How far from a vertex a label is tried, in pixels at the reference size."""
MENDING_ROUNDS = 3
ROOMY = 70
"""Up to so many labels have the full size; more share the same area."""
OVERLAP_COST, DOT_COST, COVERED_LINE_COST, LEADER_COST, CROSSING_COST = 1e4, 60.0, 1.0, 0.9, 40.0
"""What is weighed against each other, the last four for pixels at the reference size: a label over another or over its own
vertex, over another vertex, a pixel of line it covers, a pixel of its leader, a leader it crosses."""


@dataclass(frozen=True)
class PlacedLabel:
    """The label of all vertices that coincide. ``leader`` is where the line to a label further off ends."""

    ids: tuple[int, ...]
    visible: bool
    anchor: Point
    box: Box
    leader: Point | None
    lines: tuple[str, ...]
    font_size: float

    @property
    def line_height(self) -> float:
        """Distance between baselines."""
        return self.font_size * LINE_HEIGHT


@dataclass(frozen=True)
class _Group:
    """Vertices that coincide when folded; ``anchor`` is where, in pixels."""

    ids: tuple[int, ...]
    visible: bool
    anchor: Point


@dataclass(frozen=True)
class _Candidates:
    """Possible boxes of one label, what each costs by itself, and where its leader would end."""

    boxes: Floats
    leaders: Floats
    costs: Floats


def place_labels(
    paper: Paper, faces: Iterable[VisibleFace], segments: Sequence[tuple[Point, Point]], view: View
) -> list[PlacedLabel]:
    """One label for all vertices that coincide, none over another.

    ``segments`` are the lines of the picture in pixels, which labels avoid where they can.
    """
    groups = _groups(paper, faces, view)
    unit = view.size / REFERENCE_SIZE
    font_size = FONT_SIZE * unit * min(1.0, sqrt(ROOMY / len(groups)))
    while True:
        placed = _placed_labels(groups, segments, view.size, unit, font_size)
        if not _any_overlap(placed) or font_size <= SMALLEST_FONT_SIZE * unit:
            return placed
        font_size *= 0.85


def _groups(paper: Paper, faces: Iterable[VisibleFace], view: View) -> list[_Group]:
    """Vertices grouped by folded coordinates, each group with whether a vertex of it can be seen."""
    found: list[tuple[Point, list[int]]] = []
    for v, point in sorted(paper.folded_vertices_coords.items()):
        for anchor, ids in found:
            if hypot(point[0] - anchor[0], point[1] - anchor[1]) <= 2 * SLIVER:
                ids.append(v)
                break
        else:
            found.append((point, [v]))
    seen = _seen_vertices(paper, faces)
    return [_Group(tuple(ids), any(v in seen for v in ids), view.pixel(anchor)) for anchor, ids in found]


def _seen_vertices(paper: Paper, faces: Iterable[VisibleFace]) -> set[int]:
    """The vertices that lie on the visible part of one of their faces."""
    seen: set[int] = set()
    for face in faces:
        shown = shapely.MultiPolygon([(part[0], part[1:]) for part in face.parts])
        corners = paper.faces[face.face]
        near = shapely.dwithin(shown, shapely.points(paper.polygon(face.face)), SLIVER)
        seen.update(v for v, touches in zip(corners, near, strict=True) if touches)
    return seen


def _placed_labels(
    groups: Sequence[_Group],
    segments: Sequence[tuple[Point, Point]],
    size: float,
    unit: float,
    font_size: float,
) -> list[PlacedLabel]:
    lines = [_lines(group.ids) for group in groups]
    extents = [_extent(text, font_size) for text in lines]
    anchors = np.array([group.anchor for group in groups])
    ink = np.array(segments, dtype=float).reshape(-1, 4)
    choices = [_candidates(anchors, i, extent, ink, size, unit) for i, extent in enumerate(extents)]
    chosen = _choose(choices, anchors)
    return [
        _placed(group, text, choice, k, font_size, unit)
        for group, text, choice, k in zip(groups, lines, choices, chosen, strict=True)
    ]


def _lines(ids: Sequence[int]) -> tuple[str, ...]:
    """Ids separated by commas, a few to a line."""
    rows = [ids[i : i + IDS_PER_LINE] for i in range(0, len(ids), IDS_PER_LINE)]
    texts = [",".join(map(str, row)) for row in rows]
    return (*(text + "," for text in texts[:-1]), texts[-1])


def _extent(lines: Sequence[str], font_size: float) -> Point:
    widest = max(sum(COMMA_WIDTH if c == "," else DIGIT_WIDTH for c in line) for line in lines)
    return (widest + 0.35) * font_size, len(lines) * LINE_HEIGHT * font_size


def _candidates(
    anchors: Floats, i: int, extent: Point, segments: Floats, size: float, unit: float
) -> _Candidates:
    """Boxes all around an anchor at growing distance, kept inside the picture, and their costs."""
    anchor = anchors[i]
    half = np.array(extent) / 2
    angles = 2 * pi * (np.arange(LABEL_DIRECTIONS) + 0.5) / LABEL_DIRECTIONS
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    to_border = np.min(half / np.maximum(np.abs(rays), 1e-9), axis=1)
    reaches = np.array(LABEL_REACHES) * unit
    offsets = rays[None] * (to_border[None, :, None] + reaches[:, None, None])
    centers = np.clip(anchor + offsets.reshape(-1, 2), half + 2, size - half - 2)
    boxes = np.concatenate([centers - half, centers + half], axis=1)
    leaders = np.clip(anchor, boxes[:, :2], boxes[:, 2:])
    gaps = np.hypot(*(leaders - anchor).T)
    others = np.delete(anchors, i, axis=0)
    around = np.array([[*boxes[:, :2].min(axis=0), *boxes[:, 2:].max(axis=0)]])
    segments = segments[_overlaps(_segment_boxes(segments), around)[:, 0]]
    costs = (
        LEADER_COST * gaps / unit
        + COVERED_LINE_COST * _length_inside(segments, boxes).sum(axis=1) / unit
        + DOT_COST * _holds(boxes, others, 3 * unit).sum(axis=1)
        + OVERLAP_COST * _holds(boxes, anchor[None], 2 * unit).sum(axis=1)
    )
    return _Candidates(boxes, leaders, costs)


def _length_inside(segments: Floats, boxes: Floats) -> Floats:
    """Length of each segment inside each box, (boxes, segments), by clipping to the slabs of x and of y."""
    enter, leave = np.zeros((len(boxes), len(segments))), np.ones((len(boxes), len(segments)))
    for axis in (0, 1):
        start, step = segments[:, axis], segments[:, axis + 2] - segments[:, axis]
        pace = 1 / np.where(np.abs(step) < 1e-9, 1e-9, step)
        low, high = (boxes[:, axis, None] - start) * pace, (boxes[:, axis + 2, None] - start) * pace
        np.maximum(enter, np.minimum(low, high), out=enter)
        np.minimum(leave, np.maximum(low, high), out=leave)
    lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    inside: Floats = np.maximum(leave - enter, 0.0) * lengths
    return inside


def _holds(boxes: Floats, points: Floats, border: float) -> Bools:
    """Whether each box, grown by a border, holds each point: (boxes, points)."""
    return _overlaps(boxes, np.concatenate([points, points], axis=1), border)


def _overlaps(boxes: Floats, others: Floats, gap: float = 1.0) -> Bools:
    """Whether two boxes come nearer than the gap: (boxes, others)."""
    meet: Bools = (
        (boxes[:, None, 0] < others[:, 2] + gap)
        & (boxes[:, None, 2] > others[:, 0] - gap)
        & (boxes[:, None, 1] < others[:, 3] + gap)
        & (boxes[:, None, 3] > others[:, 1] - gap)
    )
    return meet


def _choose(choices: Sequence[_Candidates], anchors: Floats) -> list[int]:
    """Greedy choice, the most crowded first; then each label in conflict chooses again given the others."""
    order = sorted(range(len(choices)), key=lambda i: -float(np.sort(choices[i].costs)[:8].mean()))
    board = _Board(anchors)
    chosen = [0] * len(choices)
    pending = order
    for _ in range(1 + MENDING_ROUNDS):
        unhappy = []
        for i in pending:
            board.lift(i)
            costs = choices[i].costs + board.conflicts(i, choices[i])
            k = chosen[i] = int(np.argmin(costs))
            board.put(i, choices[i].boxes[k], choices[i].leaders[k])
            if costs[k] > choices[i].costs.min() + CROSSING_COST / 2:
                unhappy.append(i)
        pending = unhappy
    return chosen


class _Board:
    """The labels put down so far: their boxes and leaders, as arrays that grow no more."""

    def __init__(self, anchors: Floats) -> None:
        self.anchors = anchors
        self.boxes = np.full((len(anchors), 4), np.nan)
        self.leaders = np.full((len(anchors), 4), np.nan)

    def lift(self, i: int) -> None:
        """Take a label off the board."""
        self.boxes[i] = self.leaders[i] = np.nan

    def put(self, i: int, box: Floats, leader_end: Floats) -> None:
        """Put a label down."""
        self.boxes[i] = box
        self.leaders[i] = *self.anchors[i], *leader_end

    def conflicts(self, i: int, mine: _Candidates) -> Floats:
        """What each candidate costs for lying over labels or leaders, or having its leader cross them."""
        own = np.concatenate([np.broadcast_to(self.anchors[i], mine.leaders.shape), mine.leaders], axis=1)
        boxes = self.boxes[_near(self.boxes, mine, self.anchors[i])]
        leaders = self.leaders[_near(_segment_boxes(self.leaders), mine, self.anchors[i])]
        costs: Floats = (
            OVERLAP_COST * _overlaps(mine.boxes, boxes).sum(axis=1)
            + CROSSING_COST * (_length_inside(leaders, mine.boxes) > 0.5).sum(axis=1)
            + CROSSING_COST * (_length_inside(own, boxes) > 0.5).sum(axis=0)
        )
        return costs


def _near(boxes: Floats, mine: _Candidates, anchor: Floats) -> Bools:
    """Which boxes come near any candidate of a label; those not put down (nan) do not."""
    reach = np.array([[*mine.boxes[:, :2].min(axis=0), *mine.boxes[:, 2:].max(axis=0)]])
    reach[0] = *np.minimum(reach[0, :2], anchor), *np.maximum(reach[0, 2:], anchor)
    return _overlaps(boxes, reach, 2.0)[:, 0]


def _segment_boxes(segments: Floats) -> Floats:
    start, end = segments[:, :2], segments[:, 2:]
    return np.concatenate([np.minimum(start, end), np.maximum(start, end)], axis=1)


def _any_overlap(placed: Sequence[PlacedLabel]) -> bool:
    boxes = np.array([label.box for label in placed])
    return bool(_overlaps(boxes, boxes).sum() > len(placed))


def _placed(
    group: _Group, lines: tuple[str, ...], choice: _Candidates, k: int, font_size: float, unit: float
) -> PlacedLabel:
    left, top, right, bottom = choice.boxes[k].tolist()
    x, y = choice.leaders[k].tolist()
    far = hypot(x - group.anchor[0], y - group.anchor[1]) > 1.6 * LABEL_REACHES[0] * unit
    return PlacedLabel(
        group.ids,
        group.visible,
        group.anchor,
        (left, top, right, bottom),
        (x, y) if far else None,
        lines,
        font_size,
    )
