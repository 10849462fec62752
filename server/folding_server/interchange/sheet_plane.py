"""The plane that a sheet lies in: coordinates of the sheet from coordinates in space."""

from collections.abc import Sequence

import numpy as np

from folding_server.arrays import Floats
from folding_server.errors import ProgramError
from folding_server.geometry.graph import Cycle
from folding_server.geometry.line import Point
from folding_server.interchange.fold_frames import Coordinates
from folding_server.simulator.foldability import FileAxes, said

OFF_PLANE = 1e-4
"""How far, in units of the sheet's longer side, a vertex may lie off the plane of a flat sheet."""
LEVEL = 1e-3
"""How far, as the sine of an angle, a plane may be tilted to be taken as one of two axes."""


def laid_in_plane(
    coords: Sequence[Coordinates], faces: Sequence[Cycle]
) -> tuple[list[Point], FileAxes | None]:
    """Points of the sheet, and where the file has them if that differs.

    A sheet in a plane of two axes keeps the coordinates of these; any other plane is turned. It is seen from the side from which
    most of its faces run counter-clockwise. ProgramError if the points lie in no plane.
    """
    if all(len(point) == 2 for point in coords):
        return [(point[0], point[1]) for point in coords], None
    points = np.array([[*point, 0.0][:3] for point in coords])
    middle = points.mean(axis=0)
    normal = np.linalg.svd(points - middle, full_matrices=False)[2][2]
    off = np.abs((points - middle) @ normal)
    extent = float(np.ptp(points, axis=0).max())
    if off.max() > OFF_PLANE * max(extent, 1e-300):
        worst = int(off.argmax())
        raise ProgramError(
            f"The FOLD file is three-dimensional: vertex {worst} at {said(tuple(points[worst].tolist()))} lies "
            f"{off.max():.3g} ({off.max() / extent:.3g} of the side) off the plane of the others; only flat crease patterns and "
            "flat-folded forms are read."
        )
    right, up = _axes(normal)
    if (
        len(faces)
        and float(np.ptp(points[:, 2])) > OFF_PLANE * extent
        and _clockwise(points @ right, points @ up, faces)
    ):
        up = -up
    origin = middle - (middle @ right) * right - (middle @ up) * up
    flat = [(float(p @ right), float(p @ up)) for p in points]
    if np.array_equal(np.stack([right, up]), np.eye(3)[:2]) and not origin[2]:
        return flat, None
    return flat, FileAxes(tuple(origin.tolist()), tuple(right.tolist()), tuple(up.tolist()))


def _axes(normal: Floats) -> tuple[Floats, Floats]:
    """Unit vectors to the right and up in a plane: two axes of space if it is one of theirs."""
    main = int(np.abs(normal).argmax())
    first, second = np.eye(3)[[k for k in range(3) if k != main]]
    if np.abs(np.delete(normal, main)).max() <= LEVEL:
        return first, second
    right = first - (first @ normal) * normal
    right /= np.linalg.norm(right)
    up = second - (second @ normal) * normal - (second @ right) * right
    return right, up / np.linalg.norm(up)


def _clockwise(x: Floats, y: Floats, faces: Sequence[Cycle]) -> bool:
    """Whether more area runs clockwise than counter-clockwise."""
    total = 0.0
    for cycle in faces:
        u, v = x[list(cycle)], y[list(cycle)]
        total += float(u @ np.roll(v, -1) - v @ np.roll(u, -1))
    return total < 0
