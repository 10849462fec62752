"""What an action moved: the faces that lie elsewhere than their part of the sheet lay before."""

from collections.abc import Mapping, Sequence

from folding_server.simulator.paper import Paper
from folding_server.simulator.plane_geometry import Point


def moved_faces(before: Paper, after: Paper) -> tuple[int, ...]:
    """The faces of ``after`` that lie elsewhere than their part of the sheet lay ``before``, ascending.

    ``after`` is the same sheet as ``before`` after any number of actions.
    """
    around: dict[int, list[int]] = {}
    for face, cycle in before.faces.items():
        for v in cycle:
            around.setdefault(v, []).append(face)
    return tuple(
        face
        for face in sorted(after.faces)
        if after.isometries[face] != before.isometries[_origin(before, around, after, face)]
    )


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
