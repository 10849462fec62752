"""Outlines inside a face that nothing joins to its border, such as holes: marks join them, so that every face is one cycle."""

from collections.abc import Sequence

import numpy as np
import shapely

from folding_server.arrays import Floats
from folding_server.geometry.graph import Edge, components, without_dead_ends
from folding_server.geometry.line import Point


def bridges(vertices: Sequence[Point], edges: Sequence[Edge]) -> list[tuple[Point, Point]]:
    """Level lines from the leftmost and the rightmost vertex of each island to what lies beside it; none if there is none."""
    bounding = without_dead_ends(edges)
    groups = components({v for edge in bounding for v in edge}, bounding)
    if len(groups) < 2:
        return []
    points = np.array(vertices, float)
    sheets = [_covered(points, bounding, set(group)) for group in groups]
    found = []
    for k, group in enumerate(groups):
        mark = shapely.Point(points[group[0]])
        if any(shapely.contains(sheet, mark) for i, sheet in enumerate(sheets) if i != k):
            others = [edge for edge in edges if edge[0] not in set(group)]
            found.extend(_level_lines(points, group, others))
    return found


def has_islands(edges: Sequence[Edge]) -> bool:
    """Whether what bounds faces is in several pieces."""
    bounding = without_dead_ends(edges)
    return len(components({v for edge in bounding for v in edge}, bounding)) > 1


def _covered(points: Floats, edges: Sequence[Edge], group: set[int]) -> shapely.Geometry:
    """The area that the edges of a group enclose."""
    lines = [shapely.LineString(points[list(edge)]) for edge in edges if edge[0] in group]
    return shapely.union_all(shapely.get_parts(shapely.polygonize(lines)))


def _level_lines(points: Floats, group: Sequence[int], others: Sequence[Edge]) -> list[tuple[Point, Point]]:
    corners = points[list(group)]
    lines = shapely.multilinestrings(list(shapely.linestrings(points[np.array(others)])))
    width = float(np.ptp(points[:, 0])) + 1.0
    found = []
    for corner, way in ((corners[corners[:, 0].argmin()], -width), (corners[corners[:, 0].argmax()], width)):
        ray = shapely.LineString([corner, corner + np.array([way, 0.0])])
        met = shapely.get_coordinates(shapely.intersection(ray, lines))
        if len(met):
            x, y = min(met.tolist(), key=lambda point: abs(point[0] - corner[0]))
            found.append(((float(corner[0]), float(corner[1])), (float(x), float(y))))
    return found
