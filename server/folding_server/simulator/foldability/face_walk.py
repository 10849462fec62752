"""The walk that lays the faces of a crease pattern flat, from face to face over their shared edges."""

from collections.abc import Sequence
from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np

from folding_server.geometry.graph import Edge
from folding_server.geometry.isometry import IDENTITY, Isometry, mirror
from folding_server.geometry.line import Point, line_through


class SharedEdge(NamedTuple):
    """An edge (two indices of vertices) with the two faces beside it; ``folded`` if they lie on top of each other."""

    edge: Edge
    faces: tuple[int, int]
    folded: bool


def faces_isometries(vertices_coords: Sequence[Point], shared: Sequence[SharedEdge]) -> dict[int, Isometry]:
    """Face -> where it goes when every folded edge is folded flat, in the order in which the faces are reached.

    Face 0 stays; faces that no edge joins to it are left out. Whether the faces agree on the edges that the walk does
    not cross is for the caller to check. The longest edge is crossed first, since the ends of a short one say little
    about its direction; of equals, the first listed. ZeroDivisionError if the ends of a folded edge coincide.

    This is Prim's algorithm for the maximum spanning tree of the faces. networkx's begins at a face of its own choice
    and takes equals in another order, on which the order of the faces, and with it the search for layers, depends.
    """
    beside: dict[int, list[int]] = {}
    for k, (_, faces, _) in enumerate(shared):
        for face in faces:
            beside.setdefault(face, []).append(k)
    lengths = _lengths(vertices_coords, shared)
    reached: dict[int, Isometry] = {}
    waiting = [(0.0, -1, 0, IDENTITY)]
    while waiting:
        _, k, face, before = heappop(waiting)
        if face in reached:
            continue
        reached[face] = before if k < 0 else _across(vertices_coords, shared[k], before)
        for k in beside.get(face, ()):
            (other,) = set(shared[k].faces) - {face}
            if other not in reached:
                heappush(waiting, (-lengths[k], k, other, reached[face]))
    return reached


def _across(vertices_coords: Sequence[Point], shared: SharedEdge, isometry: Isometry) -> Isometry:
    """Where the face on the other side of an edge goes."""
    if not shared.folded:
        return isometry
    u, v = shared.edge
    return isometry.after(mirror(line_through(vertices_coords[u], vertices_coords[v])))


def _lengths(vertices_coords: Sequence[Point], shared: Sequence[SharedEdge]) -> list[float]:
    """The length of each edge."""
    points = np.array(vertices_coords, float).reshape(-1, 2)
    runs = points[[s.edge[1] for s in shared]] - points[[s.edge[0] for s in shared]]
    lengths: list[float] = np.hypot(runs[:, 0], runs[:, 1]).tolist()
    return lengths
