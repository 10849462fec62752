"""The edges that a frame of a FOLD file lists or implies, and what of them reads otherwise than it stands."""

from dataclasses import replace

from folding_server.geometry.convex import area
from folding_server.geometry.graph import Edge, edge_faces, edge_of, sides
from folding_server.interchange.arrangement import stronger
from folding_server.interchange.fold_frames import FoldFrame
from folding_server.interchange.sheet_plane import laid_in_plane
from folding_server.simulator.foldability import Assignment, CreasePattern

FULLY_FOLDED = 1.0
"""Degrees by which a fold angle may differ from 0, 180 or -180."""


def listed_edges(frame: FoldFrame) -> tuple[tuple[Edge, ...], tuple[str, ...]]:
    """The edges of a frame, each once, with their letters; without edges, those that its faces have.

    Of an edge that is listed more than once the stronger letter counts. ProgramError if one is a mountain and a valley.
    """
    if not frame.edges_vertices:
        beside = edge_faces({i: tuple(cycle) for i, cycle in enumerate(frame.faces_vertices)})
        return tuple(edge_of(*edge) for edge in beside), tuple(
            "B" if len(f) == 1 else "U" for f in beside.values()
        )
    letters: dict[Edge, str] = {}
    for (u, v), letter in zip(frame.edges_vertices, frame.assignments(), strict=True):
        edge = edge_of(u, v)
        letters[edge] = stronger(
            letters.get(edge, letter), letter, frame.vertices_coords[u], frame.vertices_coords[v]
        )
    return tuple(letters), tuple(letters.values())


def is_outline_only(frame: FoldFrame, edges: tuple[Edge, ...], assignments: tuple[Assignment, ...]) -> bool:
    """Whether the faces of a frame leave its creases out: the only one is the outline of the sheet."""
    if len(frame.faces_vertices) != 1:
        return False
    outline = {edge_of(*side) for side in sides(tuple(frame.faces_vertices[0]))}
    return any(edge not in outline and letter != "B" for edge, letter in zip(edges, assignments, strict=True))


def lies_unfolded(frame: FoldFrame) -> bool:
    """Whether a folded form lies as the sheet does: all its faces run one way, though some of its edges are to be folded."""
    if len(frame.faces_vertices) < 2:
        return False
    points, _ = laid_in_plane(frame.vertices_coords, [tuple(cycle) for cycle in frame.faces_vertices])
    areas = [area([points[v] for v in cycle]) for cycle in frame.faces_vertices]
    folds = any(letter in "MV" for letter in frame.assignments())
    return folds and (min(areas) > 0 or max(areas) < 0)


def with_notes(pattern: CreasePattern, frame: FoldFrame) -> CreasePattern:
    """The pattern with a note on creases whose fold angles are neither flat nor folded flat."""
    partial = [
        (edge, angle)
        for edge, angle in zip(frame.edges_vertices, frame.fold_angles, strict=False)
        if angle is not None and min(abs(angle), abs(abs(angle) - 180)) > FULLY_FOLDED
    ]
    if not partial:
        return pattern
    (u, v), angle = partial[0]
    more = f" and {len(partial) - 1} more edges are" if len(partial) > 1 else " is"
    note = f"Edge {u}-{v} with a fold angle of {angle:g} degrees{more} folded only in part; what is checked is the pattern folded flat."
    return replace(pattern, notes=(*pattern.notes, note))
