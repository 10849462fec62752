"""Fold lines that a folder can aim at with two references at once: a direction, and where a corner comes to lie.

Landmarks name what a line passes through; these name what it does: an edge becomes parallel to another, a corner lands
on an edge or on a line through a vertex (Huzita-Justin axioms 5 and 7).
"""

from math import atan2, cos, pi, sin, sqrt

import numpy as np

from folding_server.arrays import Floats
from folding_server.geometry.line import Line, Point
from folding_server.simulator.paper import Paper
from folding_server.vision.solver.lines import Lines, distinct_lines, distinct_points, edge_lines

TURN = 0.03
"""Radians by which a found line may miss a direction that is meant."""
SHIFT = 0.015
"""Sheet units by which it may miss a place that is meant."""


def constructions(paper: Paper, line: Line, middle: Point) -> Lines:
    """Lines near ``line`` (near ``middle``) that meet two such references exactly, (n, 3), normals to the same side."""
    edges = distinct_lines(edge_lines(paper))
    points = distinct_points(paper)
    rows = [*_in_direction(edges, points, line, middle), *_through_point(edges, points, line)]
    return np.array(rows) if rows else np.empty((0, 3))


def _in_direction(
    edges: Lines, points: Floats, line: Line, middle: Point
) -> list[tuple[float, float, float]]:
    """Lines that make one edge parallel to another and pass a vertex or take a vertex onto an edge."""
    rows = []
    for angle in _directions(edges, line):
        nx, ny = cos(angle), sin(angle)
        here = nx * middle[0] + ny * middle[1]
        heights = points @ (nx, ny)
        rows += [(nx, ny, float(k)) for k in heights[np.abs(heights - here) < SHIFT]]
        for ex, ey, offset in edges:
            along = ex * nx + ey * ny
            if abs(along) < 0.1:
                continue
            shifts = heights + (offset - points @ (ex, ey)) / (2 * along)
            moves = np.abs(shifts - heights) > SHIFT
            rows += [(nx, ny, float(k)) for k in shifts[moves & (np.abs(shifts - here) < SHIFT)]]
    return rows


def _directions(edges: Lines, line: Line) -> list[float]:
    """Angles of normals near the line's under which a fold makes one edge parallel to another."""
    mine = atan2(line.ny, line.nx)
    angles = np.arctan2(edges[:, 1], edges[:, 0])
    i, j = np.triu_indices(len(angles))
    halves = (angles[i] + angles[j]) / 2
    found: list[float] = []
    for half in np.concatenate([halves, halves + pi / 2]):
        gap = (half - mine + pi / 2) % pi - pi / 2
        if abs(gap) < TURN and all(abs(mine + gap - other) > 1e-3 for other in found):
            found.append(float(mine + gap))
    return found


def _through_point(edges: Lines, points: Floats, line: Line) -> list[tuple[float, float, float]]:
    """Lines through one vertex that take another vertex onto an edge (axiom 5)."""
    rows = []
    heights = points @ (line.nx, line.ny) - line.offset
    for pivot in points[np.abs(heights) < SHIFT]:
        for moved, height in zip(points, heights, strict=True):
            if height <= SHIFT:
                continue
            image = moved - 2 * height * np.array([line.nx, line.ny])
            for target in _circle_meets(pivot, float(np.hypot(*(moved - pivot))), edges, image):
                normal = moved - target
                if np.hypot(*normal) < SHIFT:
                    continue
                nx, ny = normal / np.hypot(*normal)
                if nx * line.nx + ny * line.ny > cos(TURN):
                    rows.append((float(nx), float(ny), float(nx * pivot[0] + ny * pivot[1])))
    return rows


def _circle_meets(center: Floats, radius: float, edges: Lines, near: Floats) -> list[Floats]:
    """Where a circle meets the lines of edges, close to a point."""
    met = []
    for ex, ey, offset in edges:
        if abs(ex * near[0] + ey * near[1] - offset) > 2 * SHIFT:
            continue
        gap = offset - (ex * center[0] + ey * center[1])
        if abs(gap) > radius:
            continue
        foot, half = center + gap * np.array([ex, ey]), sqrt(radius**2 - gap**2)
        for sign in (1.0, -1.0):
            spot = foot + sign * half * np.array([-ey, ex])
            if np.hypot(*(spot - near)) < 3 * SHIFT:
                met.append(spot)
    return met
