"""What actions did to a paper, read off the papers before and after them: new ids, and faces that lie elsewhere."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from folding_server.geometry.line import Point
from folding_server.simulator.paper import Paper


class StateDifference(NamedTuple):
    """Ids that are new, and the faces (of the paper after) that lie elsewhere than before."""

    new_vertices: list[int]
    new_faces: list[int]
    moved_faces: list[int]


def state_difference(before: Paper, after: Paper) -> StateDifference:
    """What differs between two states of the same sheet."""
    return StateDifference(
        sorted(after.vertices_coords.keys() - before.vertices_coords.keys()),
        sorted(after.faces.keys() - before.faces.keys()),
        list(moved_faces(before, after)),
    )


def moved_faces(before: Paper, after: Paper) -> tuple[int, ...]:
    """The faces of ``after`` that lie elsewhere than their part of the sheet lay ``before``, ascending.

    ``after`` is the same sheet as ``before`` after any number of actions.
    """
    return tuple(face for face, _ in _moved(before, after))


def turned_faces(before: Paper, after: Paper) -> frozenset[int]:
    """The faces of ``before`` of which some part lies elsewhere ``after``."""
    return frozenset(origin for _, origin in _moved(before, after))


def origins(before: Paper, after: Paper) -> dict[int, int]:
    """For each face of ``after`` the face of ``before`` that it is, or is part of."""
    around: dict[int, list[int]] = {}
    for face, cycle in before.faces.items():
        for v in cycle:
            around.setdefault(v, []).append(face)
    return {face: _origin(before, around, after, face) for face in sorted(after.faces)}


def _moved(before: Paper, after: Paper) -> Iterator[tuple[int, int]]:
    """Each face of the later paper that lies elsewhere, and the face of the earlier one that it was part of."""
    for face, origin in origins(before, after).items():
        if after.isometries[face] != before.isometries[origin]:
            yield face, origin


def _origin(before: Paper, around: Mapping[int, Sequence[int]], after: Paper, face: int) -> int:
    """The face of the earlier paper that a face is, or was cut from: one of those ``around`` a vertex they share."""
    outline = after.sheet_polygon(face)
    middle = sum(x for x, _ in outline) / len(outline), sum(y for _, y in outline) / len(outline)
    if face in before.faces and _depth(before.sheet_polygon(face), middle) > 0:
        return face
    near = {f for v in after.faces[face] for f in around.get(v, ())} or before.faces
    return max(sorted(near), key=lambda f: _depth(before.sheet_polygon(f), middle))


def _depth(outline: Sequence[Point], point: Point) -> float:
    """How far inside a convex outline a point is, as a signed area; negative outside."""
    turns = [
        (q[0] - p[0]) * (point[1] - p[1]) - (q[1] - p[1]) * (point[0] - p[0])
        for p, q in zip(outline, (*outline[1:], outline[0]), strict=True)
    ]
    return max(min(turns), -max(turns))
