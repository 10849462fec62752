"""What an action did to the paper, read off the papers before and after it."""

from typing import NamedTuple

from folding_server.simulator import TOLERANCE, Paper
from folding_server.simulator.plane_geometry import Point, area, line_through


class Change(NamedTuple):
    """Ids that are new, and the faces (of the paper after) that lie elsewhere than before."""

    new_vertices: list[int]
    new_faces: list[int]
    moved_faces: list[int]


def change(before: Paper, after: Paper) -> Change:
    """What differs between two states of the same sheet."""
    return Change(
        sorted(after.places.keys() - before.places.keys()),
        sorted(after.faces.keys() - before.faces.keys()),
        [face for face in sorted(after.faces) if _moved(before, after, face)],
    )


def _moved(before: Paper, after: Paper, face: int) -> bool:
    """Whether a face of the paper after lies elsewhere than the part of the sheet it is did before."""
    origin = face if face in before.faces else _face_at(before, _middle(after.sheet_polygon(face)))
    return after.isometries[face] != before.isometries[origin]


def _face_at(paper: Paper, point: Point) -> int:
    """The face that holds a point of the unfolded sheet."""
    return next(face for face in paper.faces if _inside(paper.sheet_polygon(face), point))


def _inside(polygon: list[Point], point: Point) -> bool:
    """Whether a convex polygon holds a point, to within the tolerance."""
    sign = 1 if area(polygon) > 0 else -1
    sides = zip(polygon, polygon[1:] + polygon[:1], strict=True)
    return all(sign * line_through(p, q).distance(point) >= -TOLERANCE for p, q in sides)


def _middle(polygon: list[Point]) -> Point:
    """The mean of a polygon's corners."""
    return sum(x for x, _ in polygon) / len(polygon), sum(y for _, y in polygon) / len(polygon)
