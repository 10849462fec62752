"""A folded sheet as an SVG diagram: coloured faces, outlines and folds, crease marks, vertex labels."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from folding_server.arrays import Bools, Floats
from folding_server.diagram.label_placement import PlacedLabel, place_labels
from folding_server.diagram.palette import DEFAULT_COLORS, Colors, DiagramColors, diagram_colors
from folding_server.diagram.svg import svg_document, svg_text
from folding_server.diagram.view import REFERENCE_SIZE, View, steady_view
from folding_server.diagram.visibility import WHOLE, Span, VisibleFace, visible_faces, visible_spans
from folding_server.geometry.graph import Edge
from folding_server.geometry.line import Point, between
from folding_server.simulator.paper import Paper

THINNEST_LINES = 0.55
"""Lines of small pictures get no finer than this part of their width at the reference size."""


class Stroke(NamedTuple):
    """A visible stretch of an edge in pixels, on paper that shows its back or its front there."""

    start: Point
    end: Point
    mark: bool
    back_up: bool


def draw_svg(
    paper: Paper,
    colors: Colors = DEFAULT_COLORS,
    labels: bool = False,
    size: int = REFERENCE_SIZE,
    view: View | None = None,
) -> str:
    """The diagram of a folded sheet, ``size`` pixels square.

    Grey table; only what the top layers leave visible; solid lines for the sheet's boundary and for folds,
    dashed lines for crease marks. With ``labels``, vertex ids: vertices that coincide share a label, and the
    ids of vertices that are covered are grey. Without a ``view`` the scale depends on the sheet alone, so
    that diagrams of the states of one run can be laid over each other. ProgramError for an unknown colour.
    """
    inks = diagram_colors(colors)
    body = draw_body(paper, inks, view or steady_view([paper], size), labels)
    return svg_document(size, size, inks.table, body)


def draw_body(paper: Paper, inks: DiagramColors, view: View, labels: bool) -> list[str]:
    """The elements of a diagram, without background, in the view's pixels."""
    faces = visible_faces(paper)
    strokes = visible_strokes(paper, faces, view)
    unit = max(view.size / REFERENCE_SIZE, THINNEST_LINES)
    body = [*_draw_faces(faces, inks, view), *_draw_strokes(strokes, inks, unit)]
    if labels:
        placed = place_labels(paper, faces, [(s.start, s.end) for s in strokes], view)
        body += _draw_labels(placed, unit)
    return body


def _draw_faces(faces: Sequence[VisibleFace], inks: DiagramColors, view: View) -> list[str]:
    """One path per side; a thin stroke in the same colour closes the hairlines between neighbours."""
    drawn = []
    for back_up, fill, name in ((False, inks.front, "front"), (True, inks.back, "back")):
        rings = [ring for seen in faces if seen.back_up == back_up for part in seen.parts for ring in part]
        if rings:
            path = "".join(_ring_path(ring, view) for ring in rings)
            drawn.append(
                f'<path class="{name}" d="{path}" fill="{fill}" fill-rule="evenodd" stroke="{fill}" '
                f'stroke-width="0.7" stroke-linejoin="round"/>'
            )
    return drawn


def _ring_path(ring: Iterable[Point], view: View) -> str:
    return "M" + "L".join([f"{x:.2f} {y:.2f}" for x, y in view.pixels(ring)]) + "Z"


def visible_strokes(paper: Paper, faces: Sequence[VisibleFace], view: View) -> list[Stroke]:
    """What can be seen of the paper's edges, of which ``faces`` show; no mark along a solid line."""
    return _strokes(paper, visible_spans(paper, faces), {seen.face for seen in faces}, view)


def _strokes(paper: Paper, spans: Mapping[Edge, list[Span]], shown: set[int], view: View) -> list[Stroke]:
    """The stretches; a crease that lies flat is a mark, unless nothing shows beyond it, such as a sliver: then it is an outline."""
    mirrored = {face: motion.mirrors for face, motion in paper.isometries.items()}
    strokes = []
    for edge, visible in spans.items():
        beside = paper.edge_faces[edge]
        mark = len(beside) == 2 and mirrored[beside[0]] == mirrored[beside[1]] and shown.issuperset(beside)
        top = _topmost(paper, beside, shown)
        motion = paper.isometries[top]
        p, q = view.pixels([motion(paper.vertices_coords[v]) for v in edge])
        for start, end in visible:
            ends = (p, q) if (start, end) == WHOLE else (between(p, q, start), between(p, q, end))
            strokes.append(Stroke(*ends, mark, mirrored[top]))
    return _without_hidden_marks(strokes)


def _topmost(paper: Paper, beside: Sequence[int], shown: set[int]) -> int:
    """The higher of the faces beside an edge, of those that show."""
    top, *other = beside
    if other and other[0] in shown and (top not in shown or paper.rank[other[0]] > paper.rank[top]):
        return other[0]
    return top


def _without_hidden_marks(strokes: Sequence[Stroke]) -> list[Stroke]:
    """Leave out the marks that run along a solid line: the dashes would only make it look ragged."""
    lines = [s for s in strokes if not s.mark]
    marks = [s for s in strokes if s.mark]
    if not marks or not lines:
        return list(strokes)
    ends = np.array([(*s.start, *s.end) for s in lines])
    start = _on_segments(np.array([s.start for s in marks]), ends)
    end = _on_segments(np.array([s.end for s in marks]), ends)
    doubled = set(np.flatnonzero((start & end).any(axis=1)).tolist())
    return [*lines, *(mark for i, mark in enumerate(marks) if i not in doubled)]


def _on_segments(points: Floats, segments: Floats) -> Bools:
    """Whether each point lies within a pixel of each segment (x1, y1, x2, y2): (points, segments)."""
    x1, y1, x2, y2 = segments.T
    dx, dy = x2 - x1, y2 - y1
    length = np.maximum(np.hypot(dx, dy), 1e-6)
    ux, uy = dx / length, dy / length
    x, y = points[:, :1] - x1, points[:, 1:] - y1
    along = x * ux + y * uy
    near: Bools = (np.abs(y * ux - x * uy) <= 1) & (along >= -1) & (along <= length + 1)
    return near


def _draw_strokes(strokes: Sequence[Stroke], inks: DiagramColors, unit: float) -> list[str]:
    """Crease marks first, so that the outlines end them cleanly."""
    styles = (
        (
            True,
            f'class="mark" stroke-width="{1.3 * unit:.2f}" stroke-dasharray="{7 * unit:.2f} {5 * unit:.2f}"',
        ),
        (False, f'class="line" stroke-width="{2.2 * unit:.2f}" stroke-linecap="round"'),
    )
    drawn = []
    for mark, style in styles:
        for back_up, ink in ((False, inks.front_ink), (True, inks.back_ink)):
            path = "".join(
                [
                    f"M{s.start[0]:.2f} {s.start[1]:.2f}L{s.end[0]:.2f} {s.end[1]:.2f}"
                    for s in strokes
                    if s.mark == mark and s.back_up == back_up
                ]
            )
            if path:
                drawn.append(f'<path d="{path}" fill="none" stroke="{ink}" {style}/>')
    return drawn


def _draw_labels(placed: Sequence[PlacedLabel], unit: float) -> list[str]:
    dots = [
        f'<circle cx="{p.anchor[0]:.1f}" cy="{p.anchor[1]:.1f}" r="{3 * unit:.1f}" '
        f'fill="{"#1d1d1f" if p.visible else "#ffffff"}" stroke="#1d1d1f" stroke-width="{unit:.2f}"/>'
        for p in placed
    ]
    leaders = [
        f'<path d="M{p.anchor[0]:.1f} {p.anchor[1]:.1f}L{p.leader[0]:.1f} {p.leader[1]:.1f}" '
        f'fill="none" stroke="#5a5a5a" stroke-width="{unit:.2f}"/>'
        for p in placed
        if p.leader
    ]
    return leaders + dots + [element for p in placed for element in _draw_label(p, unit)]


def _draw_label(label: PlacedLabel, unit: float) -> list[str]:
    left, top, right, bottom = label.box
    ink = "#12305e" if label.visible else "#6d6d6d"
    rect = (
        f'<rect x="{left:.1f}" y="{top:.1f}" width="{right - left:.1f}" height="{bottom - top:.1f}" '
        f'rx="{3 * unit:.1f}" fill="#ffffff" fill-opacity="0.86"/>'
    )
    middle, style = (left + right) / 2, 'font-weight="bold" text-anchor="middle"'
    texts = [
        svg_text(middle, top + (i + 0.8) * label.line_height, line, label.font_size, ink, style)
        for i, line in enumerate(label.lines)
    ]
    return [rect, *texts]
