"""Crease patterns of known families, made from their definitions."""

from math import cos, pi, sin
from random import Random

from folding_server.geometry.convex import area, clip
from folding_server.geometry.isometry import IDENTITY, Isometry, mirror
from folding_server.geometry.line import Line, Point
from folding_server.simulator.foldability import Assignment, CreasePattern

Layer = tuple[list[Point], Isometry]
"""The outline of a face on the sheet and the motion to where it lies."""


def miura(columns: int, rows: int, lean: float = 0.3) -> CreasePattern:
    """Miura-ori: straight creases across, zigzag creases upwards that lean by a fraction of a column."""
    vertices = [(i + lean * (j % 2), float(j)) for j in range(rows + 1) for i in range(columns + 1)]
    edges: list[tuple[int, int]] = []
    assignments: list[Assignment] = []
    for j in range(rows + 1):
        for i in range(columns + 1):
            here = j * (columns + 1) + i
            if i < columns:
                edges.append((here, here + 1))
                assignments.append("B" if j in (0, rows) else "V" if (i + j) % 2 else "M")
            if j < rows:
                edges.append((here, here + columns + 1))
                assignments.append("B" if i in (0, columns) else "M" if i % 2 else "V")
    return CreasePattern(tuple(vertices), tuple(edges), tuple(assignments))


def map_grid(columns: int, rows: int, assignment: Assignment = "U") -> CreasePattern:
    """A map: unit squares with one letter for all creases."""
    plain = miura(columns, rows, 0.0)
    assignments: tuple[Assignment, ...] = tuple(
        "B" if known == "B" else assignment for known in plain.edges_assignment
    )
    return CreasePattern(plain.vertices_coords, plain.edges_vertices, assignments)


def all_layers(folds: int, seed: int) -> CreasePattern:
    """A square folded so many times through all its layers, each along a random line near its middle."""
    random = Random(seed)
    stack: list[Layer] = [([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], IDENTITY)]
    for _ in range(folds):
        stack = _folded(stack, _line_near_the_middle(stack, random))
    return _pattern(stack)


def _line_near_the_middle(stack: list[Layer], random: Random) -> Line:
    points = [motion(p) for outline, motion in stack for p in outline]
    x, y = (sum(c) / len(points) for c in zip(*points, strict=True))
    angle = random.uniform(0, 2 * pi)
    return Line(cos(angle), sin(angle), x * cos(angle) + y * sin(angle) + random.uniform(-0.1, 0.1))


def _folded(stack: list[Layer], line: Line) -> list[Layer]:
    """The stack bottom to top after everything on the side of the normal is folded over."""
    stays: list[Layer] = []
    turns: list[Layer] = []
    for outline, motion in stack:
        back, lying = motion.inverse(), [motion(p) for p in outline]
        for side, to, moved in (
            (line, turns, mirror(line).after(motion)),
            (line.opposite(), stays, motion),
        ):
            part = clip(lying, side)
            if len(part) > 2 and abs(area(part)) > 1e-9:
                to.append(([back(p) for p in part], moved))
    return stays + turns[::-1]


def _pattern(stack: list[Layer]) -> CreasePattern:
    """The crease pattern of a stack; letters from the order and the sides that show."""
    places: dict[tuple[int, int], int] = {}
    vertices: list[Point] = []
    beside: dict[tuple[int, int], list[int]] = {}
    for height, (outline, _) in enumerate(stack):
        ids = [_vertex(p, places, vertices) for p in outline]
        cycle = [v for k, v in enumerate(ids) if v != ids[k - 1]]
        for u, v in zip(cycle, (*cycle[1:], cycle[0]), strict=True):
            beside.setdefault((min(u, v), max(u, v)), []).append(height)
    assignments: list[Assignment] = []
    for heights in beside.values():
        lower = stack[min(heights)][1]
        assignments.append("B" if len(heights) == 1 else "M" if lower.mirrors else "V")
    return CreasePattern(tuple(vertices), tuple(beside), tuple(assignments))


def _vertex(point: Point, places: dict[tuple[int, int], int], vertices: list[Point]) -> int:
    """The number of a point, the same for points that differ by rounding."""
    x, y = round(point[0] * 1e7), round(point[1] * 1e7)
    for key in ((x + dx, y + dy) for dx in (0, -1, 1) for dy in (0, -1, 1)):
        if key in places:
            return places[key]
    places[x, y] = len(vertices)
    vertices.append(point)
    return places[x, y]
