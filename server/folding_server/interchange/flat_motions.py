"""How faces move when a crease pattern is folded flat: one isometry a face, or the pattern from the fold."""

import heapq
from collections.abc import Sequence
from dataclasses import replace
from math import hypot

from folding_server.errors import ProgramError
from folding_server.geometry.convex import area
from folding_server.geometry.isometry import IDENTITY, Isometry, mirror
from folding_server.geometry.line import Point, line_through
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.interchange.crease_pattern import counterclockwise
from folding_server.simulator.foldability import CreasePattern

Motions = list[Isometry]

ROUNDED = 10 * TOLERANCE
"""Files from elsewhere may be this far out (sheet units): published results carry roundings of up to 1e-3."""


def sheet_scale(points: Sequence[Point]) -> float:
    """The factor that makes the width 1, unless a side of the bounding box is 1 as it is."""
    width, height = _extent(points)
    return 1.0 if min(abs(width - 1), abs(height - 1)) <= ROUNDED else 1 / width


def normalised(pattern: CreasePattern) -> CreasePattern:
    """The pattern with lower left corner (0, 0), in sheet units. ProgramError if it is no full rectangle."""
    points = pattern.vertices
    width, height = _extent(points)
    covered = sum(abs(area([points[v] for v in cycle])) for cycle in pattern.faces)
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
    return replace(pattern, vertices=tuple(((x - left) * scale, (y - bottom) * scale) for x, y in points))


def _extent(points: Sequence[Point]) -> tuple[float, float]:
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return max(xs) - min(xs), max(ys) - min(ys)


def motions_between(pattern: CreasePattern, folded: Sequence[Point], scale: float) -> Motions:
    """The motion of each face from sheet to folded place, in sheet units; ``scale`` is that of the file.

    ProgramError if a face has another shape when folded.
    """
    motions = []
    for i, cycle in enumerate(pattern.faces):
        flat = [pattern.vertices[v] for v in cycle]
        lies = [(folded[v][0] * scale, folded[v][1] * scale) for v in cycle]
        motion = best_motion(flat, lies)
        worst = max(_gap(motion(place), point) for place, point in zip(flat, lies, strict=True))
        if worst > ROUNDED:
            raise ProgramError(
                f"Face {i} of the FOLD file has another shape when folded (a corner is out by "
                f"{worst:.3g} of the sheet); "
                "the folded form and the crease pattern do not belong together."
            )
        motions.append(motion)
    return motions


def best_motion(start: Sequence[Point], end: Sequence[Point]) -> Isometry:
    """The isometry from one outline to another with least squared error; a mirror if they run opposite."""
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
    """The motion of each face when every M and V is folded flat and face 0 stays, from face to face.

    Longer creases are crossed first: the shorter a crease, the less exactly its ends give its direction.
    ProgramError if a crease has no letter, or the faces do not close up around a vertex (Kawasaki's theorem).
    """
    if "U" in pattern.edges_assignment:
        raise ProgramError(
            "The crease pattern has unassigned creases, so it is not known how it lies when folded; "
            "give M, V or F for every crease, or check it for foldability to find a folded state."
        )
    beside = _faces_beside(pattern)
    motions: dict[int, Isometry] = {}
    waiting = [(0.0, 0, IDENTITY)]
    while waiting:
        _, face, motion = heapq.heappop(waiting)
        if face in motions:
            continue
        motions[face] = motion
        for edge, other in beside[face]:
            if other in motions:
                _check_closed(pattern, edge, motion, motions[other])
            else:
                heapq.heappush(waiting, (-_length(pattern, edge), other, _across(pattern, edge, motion)))
    if len(motions) < len(pattern.faces):
        raise ProgramError(
            "The faces of the crease pattern are not all joined; only sheets in one piece are read."
        )
    return [motions[i] for i in range(len(pattern.faces))]


def _length(pattern: CreasePattern, edge: int) -> float:
    u, v = pattern.edges[edge]
    return _gap(pattern.vertices[u], pattern.vertices[v])


def _across(pattern: CreasePattern, edge: int, motion: Isometry) -> Isometry:
    """The motion of the face on the other side of an edge."""
    if pattern.edges_assignment[edge] not in "MV":
        return motion
    u, v = pattern.edges[edge]
    return motion.after(mirror(line_through(pattern.vertices[u], pattern.vertices[v])))


def _check_closed(pattern: CreasePattern, edge: int, one: Isometry, other: Isometry) -> None:
    """The faces beside an edge must put it in one place, turned over against each other if it is folded."""
    ends = [pattern.vertices[v] for v in pattern.edges[edge]]
    turned = (one.mirrors != other.mirrors) == (pattern.edges_assignment[edge] in "MV")
    if not turned or any(_gap(one(p), other(p)) > ROUNDED for p in ends):
        a, b = pattern.edges[edge]
        raise ProgramError(
            "The crease pattern does not fold flat as its letters say: its faces do not close up at the "
            "crease "
            f"between vertices {a} and {b}; check the letters of the creases around them."
        )


def _gap(p: Point, q: Point) -> float:
    return hypot(p[0] - q[0], p[1] - q[1])


def _faces_beside(pattern: CreasePattern) -> list[list[tuple[int, int]]]:
    """For each face the neighbours it shares an edge with, as (edge, face)."""
    index = {edge: i for i, edge in enumerate(pattern.edges)}
    owners: dict[int, list[int]] = {}
    for f, cycle in enumerate(pattern.faces):
        for u, v in zip(cycle, (*cycle[1:], cycle[0]), strict=True):
            edge = index.get((min(u, v), max(u, v)))
            if edge is None:
                raise ProgramError(
                    f"Face {f} of the FOLD file has a side {u}-{v} that is no edge; add it to edges_vertices."
                )
            owners.setdefault(edge, []).append(f)
    neighbours: list[list[tuple[int, int]]] = [[] for _ in pattern.faces]
    for edge, faces in owners.items():
        if len(faces) > 2:
            raise ProgramError(
                f"Edge {edge} of the FOLD file has {len(faces)} faces; a sheet of paper has two at most."
            )
        if len(faces) == 2:
            neighbours[faces[0]].append((edge, faces[1]))
            neighbours[faces[1]].append((edge, faces[0]))
    return neighbours


def unfolded(folded: CreasePattern) -> CreasePattern:
    """The crease pattern of a folded form: folding it along its folded creases once more lays it flat.

    The sheet is turned so that the side where face 0 runs counter-clockwise is the front, and its
    lower edge level.
    """
    motions = motions_by_folding(folded)
    places: dict[int, Point] = {}
    for cycle, motion in zip(folded.faces, motions, strict=True):
        for v in cycle:
            places.setdefault(v, motion(folded.vertices[v]))
    if len(places) < len(folded.vertices):
        raise ProgramError("The FOLD file has a vertex that no face uses; remove it.")
    points = [places[v] for v in range(len(folded.vertices))]
    points = _levelled(folded, points)
    faces = tuple(counterclockwise(cycle, [points[v] for v in cycle]) for cycle in folded.faces)
    return replace(folded, vertices=tuple(points), faces=faces)


def _levelled(pattern: CreasePattern, points: list[Point]) -> list[Point]:
    """The points turned so that the longest boundary edge is level, mirrored if face 0 runs clockwise."""
    boundary = [
        edge
        for edge, assignment in zip(pattern.edges, pattern.edges_assignment, strict=True)
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
    if area([points[w] for w in pattern.faces[0]]) < 0:
        turned = [p.conjugate() for p in turned]
    return [(p.real, p.imag) for p in turned]
