"""FOLD files as papers: our own exactly as they were, others by their geometry, assignments and face orders."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise
from typing import Any

from folding_server.errors import ProgramError
from folding_server.geometry.graph import Cycle, Edge, edge_faces
from folding_server.geometry.line import Point, line_through
from folding_server.geometry.planar import boundary_cycles, crossing_edges
from folding_server.interchange.arrangement import arranged
from folding_server.interchange.crease_pattern import FOLD_ASSIGNMENTS, counterclockwise
from folding_server.interchange.drawn_line import DrawnLine
from folding_server.interchange.face_ordering import stacked
from folding_server.interchange.flat_motions import (
    ROUNDED,
    Motions,
    motions_between,
    motions_by_folding,
    normalised,
    sheet_scale,
    unfolded,
)
from folding_server.interchange.fold_frames import FoldFrame, frame_of, read_frames
from folding_server.interchange.gaps import GAP
from folding_server.interchange.islands import has_islands
from folding_server.interchange.layer_check import check_layers
from folding_server.interchange.listed_edges import (
    is_outline_only,
    lies_unfolded,
    listed_edges,
    with_notes,
)
from folding_server.interchange.own_record import restored
from folding_server.interchange.sheet_plane import laid_in_plane
from folding_server.interchange.welding import welded
from folding_server.simulator.foldability import Assignment, CreasePattern, FileAxes, check_pattern
from folding_server.simulator.foldability.pattern import faces_of_sheet
from folding_server.simulator.paper import Paper


class FaceOrders(Enum):
    """What the sign in a ``faceOrders`` triple [f, g, s] says. FOLD 1.2 is the default; others are asked for.

    ``SPEC``      s = +1: f lies on the side of g that g's normal points to (FOLD 1.2)
    ``VIEWER``    s = +1: f lies above g as the model is seen, whichever way the faces are turned. The published results
                  list their pairs this way, the upper face first
    ``REVERSED``  s = +1: f lies below g as the model is seen
    ``FIRST``     as SPEC, but by the normal of f, the first face named
    """

    SPEC = "spec"
    VIEWER = "viewer"
    REVERSED = "reversed"
    FIRST = "first"


def read_fold(source: str | Mapping[str, Any], face_orders: FaceOrders = FaceOrders.SPEC) -> Paper:
    """The folded paper of a FOLD file, given as its text or the parsed document.

    Our own files give back exactly the paper that was written. Of other files are used: the crease pattern
    and the folded form, either alone or both; faces, or else the faces of the planar pattern; assignments or fold
    angles; and
    ``faceOrders``. The sheet is moved and scaled so that its lower left corner is (0, 0) and its width is 1,
    unless a side is 1 already. ProgramError if the file cannot be read, the pattern does not fold flat as its
    assignments say, or the order of overlapping faces is not given, contradicts the assignments or makes layers cross.
    """
    frames = read_frames(source)
    for frame in frames:
        if frame.record is not None:
            return restored(frame, frame_of(frames, "creasePattern") or frame)
    return _foreign(welded(frames), face_orders)


def read_crease_pattern(
    source: str | Mapping[str, Any], frame: int | None = None, gap: float = GAP
) -> CreasePattern:
    """The crease pattern of a FOLD file as it stands: unassigned creases stay U, nothing is scaled.

    ``frame`` counts from 1, the key frame. Left out, it is that of class ``creasePattern``, else a key frame that does not
    claim to be folded, else the folded form, which is unfolded; faces are computed where there are none, and ends of edges
    that miss by up to ``gap``, in units of the longer side, are joined then. ProgramError if the file cannot be read.
    """
    frames = read_frames(source)
    chosen = pattern_frame(frames) if frame is None else _numbered(frames, frame) - 1
    return pattern_of_frame(welded([frames[chosen]] if frame is not None else frames), frames[chosen], gap)


def pattern_frame(frames: list[FoldFrame]) -> int:
    """The index of the frame that holds the crease pattern of a file."""
    return next((i for i, frame in enumerate(frames) if frame.of_class("creasePattern")), 0)


def _numbered(frames: list[FoldFrame], number: int) -> int:
    if not 1 <= number <= len(frames):
        raise ProgramError(
            f"There is no frame {number} in the FOLD file; it has frames 1 to {len(frames)}, of which 1 is the key frame."
        )
    return number


def pattern_of_frame(frames: list[FoldFrame], asked: FoldFrame, gap: float = GAP) -> CreasePattern:
    """The crease pattern of a frame, which may have been welded together with others."""
    frame = frame_of(frames, "creasePattern") if asked.of_class("creasePattern") else None
    frame = frame or frames[0]
    if frame.of_class("foldedForm") and not lies_unfolded(frame):
        return with_notes(unfolded(_pattern(frame, turned=True)), frame)
    return with_notes(_pattern(frame, alone=True, gap=gap), frame)


def fold_flat(pattern: CreasePattern) -> Paper:
    """A folded paper from a bare crease pattern: all but the marks folded, in a layer order found by search.

    Unassigned creases take the assignments that the order gives them. ProgramError, with the reason, if the
    pattern does not fold flat or its layers have no order from bottom to top.
    """
    report = check_pattern(pattern, cap=1)
    if not report.foldable or report.stack is None:
        reason = "its layers go round in a circle" if report.foldable else report.reason
        raise ProgramError(f"The crease pattern cannot be folded flat into a stack: {reason}")
    sheet = normalised(replace(pattern, faces_vertices=pattern.cycles))
    _check_convex(sheet)
    creased = replace(
        sheet,
        edges_assignment=tuple(
            "V" if assignment == "U" else assignment for assignment in sheet.edges_assignment
        ),
    )
    names = sheet.names or tuple(range(1, len(sheet.vertices_coords) + 1))
    return stacked(sheet, motions_by_folding(creased), set(pairwise(report.stack)), names)


@dataclass(frozen=True)
class _Sources:
    """The frames of a foreign paper: where it is unfolded, where it is folded, who orders the faces."""

    unfolded: FoldFrame | None
    folded: FoldFrame | None
    orders: FoldFrame


def _sources(frames: list[FoldFrame]) -> _Sources:
    folded, unfolded = frame_of(frames, "foldedForm"), frame_of(frames, "creasePattern")
    if folded is None and unfolded is None:
        unfolded = frames[0]
    return _Sources(
        unfolded, folded, next((f for f in (folded, *frames) if f is not None and f.face_orders), frames[0])
    )


def _foreign(frames: list[FoldFrame], convention: FaceOrders) -> Paper:
    sources = _sources(frames)
    given = _flat_pattern(sources)
    pattern = normalised(given)
    _check_convex(pattern)
    if sources.folded is not None:
        motions = motions_between(pattern, _points(sources.folded), sheet_scale(given.vertices_coords))
    else:
        motions = motions_by_folding(pattern)
    relation = _relation(sources.orders, motions, convention)
    ids = sources.orders.vertex_ids or list(range(1, len(pattern.vertices_coords) + 1))
    paper = stacked(pattern, motions, relation, ids)
    check_layers(paper, pattern, ids)
    return paper


def _flat_pattern(sources: _Sources) -> CreasePattern:
    """The crease pattern in the file's units, unfolding the folded form if that is all there is."""
    folded, flat = sources.folded, sources.unfolded
    if flat is None:
        assert folded is not None
        return unfolded(_pattern(folded, turned=True))
    if folded is None or not folded.faces_vertices:
        return _pattern(flat, alone=folded is None)
    if len(folded.vertices_coords) != len(flat.vertices_coords) or (
        flat.faces_vertices
        and [set(f) for f in flat.faces_vertices] != [set(f) for f in folded.faces_vertices]
    ):
        raise ProgramError(
            "The folded form and the crease pattern of the FOLD file do not have the same vertices and "
            "faces in the same "
            "order; save both frames from one model."
        )
    return _pattern(flat.model_copy(update={"faces_vertices": folded.faces_vertices}))


def _points(frame: FoldFrame) -> list[Point]:
    return [(point[0], point[1]) for point in frame.vertices_coords]


def _pattern(
    frame: FoldFrame, *, turned: bool = False, alone: bool = False, gap: float = GAP
) -> CreasePattern:
    """The mesh of a frame. The faces of a folded form (``turned``) may run either way and stay so.

    Where a crease pattern stands ``alone`` and has no faces, its edges are lines on a sheet and are cut where they meet.
    """
    points, axes = laid_in_plane(frame.vertices_coords, [tuple(cycle) for cycle in frame.faces_vertices])
    edges, letters = listed_edges(frame)
    if len(points) < 3 or not edges:
        raise ProgramError(
            "The FOLD file has no vertices_coords or no edges_vertices; both are needed, or faces_vertices instead of edges."
        )
    if "C" in letters:
        raise ProgramError("The FOLD file has cut edges (C); only sheets in one uncut piece are read.")
    assignments = tuple(FOLD_ASSIGNMENTS[letter] for letter in letters)
    given = () if alone and is_outline_only(frame, edges, assignments) else frame.faces_vertices
    if alone and not given and not _is_mesh(points, edges, assignments):
        return _drawn(points, edges, assignments, gap, axes)
    faces = tuple(tuple(cycle) for cycle in given) or _faces_between(
        points, edges, assignments, turned=turned
    )
    if not turned:
        faces = tuple(counterclockwise(cycle, [points[v] for v in cycle]) for cycle in faces)
    return CreasePattern(
        tuple(points), edges, _with_boundary(edges, assignments, faces), faces, tuple(frame.vertex_ids), axes
    )


def _is_mesh(points: list[Point], edges: tuple[Edge, ...], assignments: tuple[Assignment, ...]) -> bool:
    """Whether edges meet in common vertices only, every crease divides two faces, and no outline lies loose in a face."""
    if crossing_edges(points, edges) or has_islands(edges):
        return False
    beside = edge_faces(dict(enumerate(boundary_cycles(points, edges, ()))))
    return all(
        len(beside.get(edge, ())) == 2 or assignment in "BF"
        for edge, assignment in zip(edges, assignments, strict=True)
    )


def _drawn(
    points: list[Point],
    edges: tuple[Edge, ...],
    assignments: tuple[Assignment, ...],
    gap: float,
    axes: FileAxes | None,
) -> CreasePattern:
    """The pattern that edges draw which meet outside their vertices: vertices are numbered anew."""
    lines = [
        DrawnLine(points[u], points[v], assignment)
        for (u, v), assignment in zip(edges, assignments, strict=True)
    ]
    pattern = arranged(lines, gap=gap, axes=axes)
    faces = boundary_cycles(pattern.vertices_coords, pattern.edges_vertices, ())
    letters = _with_boundary(pattern.edges_vertices, pattern.edges_assignment, faces)
    return replace(
        pattern,
        faces_vertices=faces_of_sheet(pattern.vertices_coords, pattern.edges_vertices, letters),
        edges_assignment=letters,
    )


def _faces_between(
    points: list[Point], edges: tuple[Edge, ...], assignments: tuple[Assignment, ...], *, turned: bool
) -> tuple[Cycle, ...]:
    """The faces of a planar pattern that lists its edges only."""
    if turned:
        raise ProgramError(
            "The FOLD file has a folded form without faces_vertices; give its faces or the crease pattern."
        )
    crossing = crossing_edges(points, edges)
    if crossing:
        first, second = (list(edges[i]) for i in crossing)
        raise ProgramError(
            f"Edges {first} and {second} of the FOLD file cross where there is no vertex, so its faces "
            "cannot be found; "
            "split edges where they meet, or give faces_vertices."
        )
    return faces_of_sheet(points, edges, assignments)


def _with_boundary(
    edges: tuple[Edge, ...], assignments: tuple[Assignment, ...], faces: tuple[Cycle, ...]
) -> tuple[Assignment, ...]:
    """Assignments with B for every unassigned edge that has one face only."""
    beside = edge_faces(dict(enumerate(faces)))
    return tuple(
        "B" if assignment == "U" and len(beside.get(edge, ())) == 1 else assignment
        for edge, assignment in zip(edges, assignments, strict=True)
    )


def _relation(frame: FoldFrame, motions: Motions, convention: FaceOrders) -> set[tuple[int, int]]:
    """Pairs (lower, upper) of face indices as the model is seen, from ``faceOrders``."""
    relation = set()
    for f, g, sign in frame.face_orders:
        if sign:
            judge = {FaceOrders.SPEC: g, FaceOrders.FIRST: f}.get(convention)
            turned = convention is FaceOrders.REVERSED if judge is None else motions[judge].mirrors
            relation.add((g, f) if (sign > 0) != turned else (f, g))
    return relation


def _check_convex(pattern: CreasePattern) -> None:
    for i, cycle in enumerate(pattern.faces_vertices):
        corners = [pattern.vertices_coords[v] for v in cycle]
        for p, q in zip(corners, (*corners[1:], corners[0]), strict=True):
            line = line_through(p, q) if p != q else None
            if line is None or any(line.distance(r) < -ROUNDED for r in corners):
                raise ProgramError(
                    f"Face {i} of the FOLD file is not convex; add crease marks that split it."
                )
