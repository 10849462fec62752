"""Vertices that a FOLD file lists more than once, taken as one.

Some programs write a vertex for each face or line that ends there. On the sheet two vertices with the same coordinates are one point
of the paper; on the folded form they need not be, so only the crease pattern says which are the same.
"""

from collections.abc import Sequence
from math import dist
from typing import Any

import numpy as np

from folding_server.errors import ProgramError
from folding_server.geometry.graph import Cycle, Edge
from folding_server.interchange.arrangement import stronger
from folding_server.interchange.cutting import one_vertex_each
from folding_server.interchange.flat_motions import ROUNDED
from folding_server.interchange.fold_frames import FoldFrame, frame_of
from folding_server.interchange.sheet_plane import laid_in_plane

REPEATED = 1e-7
"""Vertices nearer than this, in units of the sheet's longer side, are one; the slivers of real folds are wider."""


def welded(frames: list[FoldFrame]) -> list[FoldFrame]:
    """The frames with every vertex of the sheet listed once; as they are if no vertex is repeated.

    ProgramError if vertices that coincide on the sheet lie apart when folded (the sheet is cut there), if that leaves a
    face without area, or if an edge is listed both as mountain and as valley.
    """
    flat = frame_of(frames, "creasePattern") or (None if frames[0].of_class("foldedForm") else frames[0])
    if flat is None or len(flat.vertices_coords) < 2:
        return frames
    points = np.array(laid_in_plane(flat.vertices_coords, [tuple(cycle) for cycle in flat.faces_vertices])[0])
    extent = float(np.ptp(points, axis=0).max())
    vertex_of = one_vertex_each(points, REPEATED * extent)
    if len(set(vertex_of)) == len(points):
        return frames
    return [
        _welded(frame, vertex_of, ROUNDED * extent) if len(frame.vertices_coords) == len(points) else frame
        for frame in frames
    ]


def _welded(frame: FoldFrame, vertex_of: Sequence[int], allowed: float) -> FoldFrame:
    first: dict[int, int] = {}
    for i, vertex in enumerate(vertex_of):
        j = first.setdefault(vertex, i)
        if dist(frame.vertices_coords[i], frame.vertices_coords[j]) > allowed:
            raise ProgramError(
                f"Vertices {j} and {i} of the FOLD file lie at one place of the sheet but apart when folded, so the sheet "
                "is cut there; only sheets in one uncut piece are read."
            )
    changed = _edges(frame, vertex_of)
    changed["vertices_coords"] = [frame.vertices_coords[i] for i in first.values()]
    changed["faces_vertices"] = [_cycle(i, cycle, vertex_of) for i, cycle in enumerate(frame.faces_vertices)]
    if frame.vertex_ids:
        changed["vertex_ids"] = [frame.vertex_ids[i] for i in first.values()]
    return frame.model_copy(update=changed)


def _edges(frame: FoldFrame, vertex_of: Sequence[int]) -> dict[str, Any]:
    """Each edge once, with its assignment; edges without length are left out."""
    assignments: dict[Edge, str] = {}
    for (u, v), assignment in zip(frame.edges_vertices, frame.assignments(), strict=True):
        a, b = sorted((vertex_of[u], vertex_of[v]))
        if a != b:
            ends = frame.vertices_coords[u], frame.vertices_coords[v]
            assignments[a, b] = stronger(assignments.get((a, b), assignment), assignment, *ends)
    return {
        "edges_vertices": list(assignments),
        "edges_assignment": list(assignments.values()),
        "fold_angles": [],
    }


def _cycle(face: int, cycle: Sequence[int], vertex_of: Sequence[int]) -> Cycle:
    mapped = [vertex_of[v] for v in cycle]
    kept = tuple(v for v, before in zip(mapped, mapped[-1:] + mapped[:-1], strict=True) if v != before)
    if len(kept) < 3 or len(set(kept)) < len(kept):
        raise ProgramError(
            f"Face {face} of the FOLD file has corners at one place of the sheet, so it has no area; leave it out or mend "
            "its corners."
        )
    return kept
