"""How faces move when a crease pattern is folded flat: one isometry a face, or the pattern from the fold."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import dist

from folding_server.errors import ProgramError
from folding_server.geometry.convex import area
from folding_server.geometry.graph import edge_faces, edge_of, sides
from folding_server.geometry.isometry import Isometry
from folding_server.geometry.line import Point
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.interchange.crease_pattern import counterclockwise
from folding_server.simulator.foldability import CreasePattern
from folding_server.simulator.foldability.face_walk import SharedEdge, faces_isometries

Motions = list[Isometry]

ROUNDED = 10 * TOLERANCE
"""Files from elsewhere may be this far out (sheet units): published results carry roundings of up to 1e-3."""


def sheet_scale(points: Sequence[Point]) -> float:
    """The factor that makes the width 1, unless a side of the bounding box is 1 as it is."""
    width, height = _extent(points)
    return 1.0 if min(abs(width - 1), abs(height - 1)) <= ROUNDED else 1 / width


def normalised(pattern: CreasePattern) -> CreasePattern:
    """The pattern with lower left corner (0, 0), in sheet units. ProgramError if it is no full rectangle."""
    points = pattern.vertices_coords
    width, height = _extent(points)
    covered = sum(abs(area([points[v] for v in cycle])) for cycle in pattern.faces_vertices)
    if min(width, height) <= 0 or abs(covered - width * height) > ROUNDED * (width + height) * max(
        width, height
    ):
        raise ProgramError(
            f"The faces of the crease pattern cover an area of {covered:.6g} where a sheet of {width:.6g} by "
            f"{height:.6g} has {width * height:.6g}; only whole rectangular sheets with upright sides "
            "are read."
        )
    scale, left, bottom = sheet_scale(points), min(x for x, _ in points), min(y for _, y in points)
    if scale == 1.0 and max(abs(left), abs(bottom)) <= ROUNDED:
        return pattern
    return replace(
        pattern, vertices_coords=tuple(((x - left) * scale, (y - bottom) * scale) for x, y in points)
    )


def _extent(points: Sequence[Point]) -> tuple[float, float]:
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return max(xs) - min(xs), max(ys) - min(ys)


def motions_between(pattern: CreasePattern, folded: Sequence[Point], scale: float) -> Motions:
    """The motion of each face from the sheet to the folded form, in sheet units; ``scale`` is that of the file.

    ProgramError if a face has another shape when folded.
    """
    motions = []
    for i, cycle in enumerate(pattern.faces_vertices):
        flat = [pattern.vertices_coords[v] for v in cycle]
        lies = [(folded[v][0] * scale, folded[v][1] * scale) for v in cycle]
        motion = best_motion(flat, lies)
        worst = max(dist(motion(vertex), point) for vertex, point in zip(flat, lies, strict=True))
        if worst > ROUNDED:
            raise ProgramError(
                f"Face {i} of the FOLD file has another shape when folded (a corner is out by "
                f"{worst:.3g} of the sheet); "
                "the folded form and the crease pattern do not belong together."
            )
        motions.append(motion)
    return motions


def best_motion(start: Sequence[Point], end: Sequence[Point]) -> Isometry:
    """The isometry from one outline to another with least squared error; a mirror if they run opposite.

    The orthogonal Procrustes problem in the plane, in complex numbers.
    """
    mirrored = (area(start) > 0) != (area(end) > 0)
    z, w = [complex(*p) for p in start], [complex(*p) for p in end]
    middle, target = sum(z) / len(z), sum(w) / len(w)
    inner = [(p - middle).conjugate() if mirrored else p - middle for p in z]
    turn = sum((q - target) * p.conjugate() for p, q in zip(inner, w, strict=True))
    turn /= abs(turn) or 1.0
    c, s = turn.real, turn.imag
    a, b, d, e = (c, s, s, -c) if mirrored else (c, -s, s, c)
    return Isometry(
        a,
        b,
        d,
        e,
        target.real - a * middle.real - b * middle.imag,
        target.imag - d * middle.real - e * middle.imag,
    )


def motions_by_folding(pattern: CreasePattern) -> Motions:
    """The motion of each face when every M and V is folded flat and face 0 stays.

    ProgramError if a crease is unassigned, or the faces do not close up around a vertex (Kawasaki's theorem).
    """
    if "U" in pattern.edges_assignment:
        raise ProgramError(
            "The crease pattern has unassigned creases, so it is not known how it lies when folded; "
            "give M, V or F for every crease, or check it for foldability to find a folded state."
        )
    shared = _shared_edges(pattern)
    isometries = faces_isometries(pattern.vertices_coords, shared)
    _check_closed(pattern, shared, isometries)
    if len(isometries) < len(pattern.faces_vertices):
        raise ProgramError(
            "The faces of the crease pattern are not all joined; only sheets in one piece are read."
        )
    return [isometries[i] for i in range(len(pattern.faces_vertices))]


def _check_closed(
    pattern: CreasePattern, shared: Sequence[SharedEdge], isometries: Mapping[int, Isometry]
) -> None:
    """The faces beside an edge must agree on its ends, turned over against each other if it is folded.

    Edges are looked at in the order in which the second of their faces was reached, so that the first at fault is named.
    """
    rank = {face: i for i, face in enumerate(isometries)}
    between = (s for s in shared if s.faces[0] in rank)
    for (u, v), (first, second), folded in sorted(between, key=lambda s: max(rank[f] for f in s.faces)):
        one, other = isometries[first], isometries[second]
        ends = pattern.vertices_coords[u], pattern.vertices_coords[v]
        if (one.mirrors != other.mirrors) != folded or any(dist(one(p), other(p)) > ROUNDED for p in ends):
            raise ProgramError(
                "The crease pattern does not fold flat as its letters say: its faces do not close up at the "
                f"crease between vertices {u} and {v}; check the letters of the creases around them."
            )


def _shared_edges(pattern: CreasePattern) -> list[SharedEdge]:
    """The edges between two faces. ProgramError if a face has a side that is no edge, or an edge three faces."""
    index = {edge: i for i, edge in enumerate(pattern.edges_vertices)}
    for f, cycle in enumerate(pattern.faces_vertices):
        for u, v in sides(cycle):
            if edge_of(u, v) not in index:
                raise ProgramError(
                    f"Face {f} of the FOLD file has a side {u}-{v} that is no edge; add it to edges_vertices."
                )
    shared = []
    for edge, faces in edge_faces(dict(enumerate(pattern.faces_vertices))).items():
        if len(faces) > 2:
            raise ProgramError(
                f"Edge {index[edge]} of the FOLD file has {len(faces)} faces; a sheet of paper has two at most."
            )
        if len(faces) == 2:
            folded = pattern.edges_assignment[index[edge]] in "MV"
            shared.append(SharedEdge(edge, (faces[0], faces[1]), folded))
    return shared


def unfolded(folded: CreasePattern) -> CreasePattern:
    """The crease pattern of a folded form: folding it along its folded creases once more lays it flat.

    The sheet is turned so that the side where face 0 runs counter-clockwise is the front, and its
    lower edge level.
    """
    motions = motions_by_folding(folded)
    vertices_coords: dict[int, Point] = {}
    for cycle, motion in zip(folded.faces_vertices, motions, strict=True):
        for v in cycle:
            vertices_coords.setdefault(v, motion(folded.vertices_coords[v]))
    if len(vertices_coords) < len(folded.vertices_coords):
        raise ProgramError("The FOLD file has a vertex that no face uses; remove it.")
    points = [vertices_coords[v] for v in range(len(folded.vertices_coords))]
    points = _levelled(folded, points)
    faces = tuple(counterclockwise(cycle, [points[v] for v in cycle]) for cycle in folded.faces_vertices)
    return replace(folded, vertices_coords=tuple(points), faces_vertices=faces)


def _levelled(pattern: CreasePattern, points: list[Point]) -> list[Point]:
    """The points turned so that the longest boundary edge is level, mirrored if face 0 runs clockwise."""
    boundary = [
        edge
        for edge, assignment in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
        if assignment == "B"
    ]
    if not boundary:
        raise ProgramError(
            "The FOLD file marks no boundary edge (B), so the outline of the sheet is not known."
        )
    u, v = max(boundary, key=lambda e: abs(complex(*points[e[0]]) - complex(*points[e[1]])))
    side = complex(*points[v]) - complex(*points[u])
    turn = abs(side) / side
    turned = [complex(*p) * turn for p in points]
    if area([points[w] for w in pattern.faces_vertices[0]]) < 0:
        turned = [p.conjugate() for p in turned]
    return [(p.real, p.imag) for p in turned]
