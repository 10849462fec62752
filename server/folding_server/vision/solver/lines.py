"""Candidate fold lines: landmarks of the folded paper, a grid of all lines, and what a photo rules out."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import atan2, cos, pi, radians, sin

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Bools, Float32s, Floats, Mask
from folding_server.geometry.graph import Edge
from folding_server.geometry.line import Line, Point
from folding_server.geometry.point_batch import transformed
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACKGROUND, UNKNOWN, LabelImage, is_paper
from folding_server.vision.registration.scene import Scene, spread_over
from folding_server.vision.solver.symmetry import mirrored, sheet_axes, symmetry_axes

Lines = Floats
"""(n, 3): unit normal towards the moving side, and offset."""

SAME_LANDMARK = 2e-3
"""Lines and points nearer than this (in sheet units) count as one landmark."""


LONG_SIDE = 0.15
"""Sides at least this long (sheet units) have a middle that a folder may aim at."""


def distinct_points(paper: Paper) -> Floats:
    """The folded positions of the vertices, coincident ones once, (n, 2)."""
    points = np.array(sorted(paper.folded_vertices_coords.values()))
    kept: list[Floats] = []
    for p in points:
        if all(np.hypot(*(p - q)) > SAME_LANDMARK for q in kept):
            kept.append(p)
    return np.array(kept)


def landmark_lines(paper: Paper) -> Lines:
    """Lines that folders aim at: through two vertices or middles of sides, vertex onto vertex, edge onto edge, square
    to an edge, and where an edge has its mirror image in a symmetrical model.
    """
    points = distinct_points(paper)
    edges = distinct_lines(edge_lines(paper))
    through, _ = _between_pairs(np.concatenate([points, _side_middles(paper)]))
    _, onto = _between_pairs(points)
    axes = axes_of(paper)
    return distinct_lines(
        np.concatenate([through, onto, _bisectors(edges), _square_to(edges, points), mirrored(edges, axes)])
    )


def axes_of(paper: Paper) -> Lines:
    """About what a folder would do the same on both sides: axes of symmetry of the sheet that are creased, and of what it
    is folded to.
    """
    points = distinct_points(paper)
    folded = symmetry_axes(points, distinct_lines(np.concatenate(_between_pairs(points))))
    return distinct_lines(np.concatenate([sheet_axes(paper), folded]))


def _between_pairs(points: Floats) -> tuple[Lines, Lines]:
    """For each pair of points the line through both and the one that takes one onto the other."""
    i, j = np.triu_indices(len(points), 1)
    apart = np.linalg.norm(points[j] - points[i], axis=1) > 10 * SAME_LANDMARK
    p, q = points[i][apart], points[j][apart]
    along = (q - p) / np.linalg.norm(q - p, axis=1, keepdims=True)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    through = np.column_stack([across, (across * p).sum(axis=1)])
    return through, np.column_stack([along, (along * (p + q) / 2).sum(axis=1)])


def _side_middles(paper: Paper) -> Floats:
    """The folded middles of the sides of the sheet and of what earlier vertices left of them, (n, 2)."""
    sides = [edge for edge, beside in paper.edge_faces.items() if len(beside) == 1]
    ends = np.array([(paper.folded_vertices_coords[u], paper.folded_vertices_coords[v]) for u, v in sides])
    return np.asarray(ends[np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) > LONG_SIDE].mean(axis=1)).reshape(
        -1, 2
    )


def edge_lines(paper: Paper) -> Lines:
    """The line of each edge as it lies now."""
    return _lines_along(paper, paper.edge_faces)


def crease_lines(paper: Paper) -> Lines:
    """The line of each crease as it lies now."""
    return _lines_along(paper, [edge for edge, beside in paper.edge_faces.items() if len(beside) == 2])


def _lines_along(paper: Paper, edges: Iterable[Edge]) -> Lines:
    """The lines of edges that are long enough to have a direction."""
    positions = paper.folded_vertices_coords
    rows = []
    for u, v in edges:
        (px, py), (qx, qy) = positions[u], positions[v]
        length = np.hypot(qx - px, qy - py)
        if length > 10 * SAME_LANDMARK:
            nx, ny = -(qy - py) / length, (qx - px) / length
            rows.append((nx, ny, nx * px + ny * py))
    return np.array(rows).reshape(-1, 3)


def edge_directions(paper: Paper) -> list[Point]:
    """The unit normals of lines parallel or square to an edge as it lies now, near-equal ones once."""
    kept: list[Point] = []
    for nx, ny, _ in edge_lines(paper).tolist():
        for x, y in ((nx, ny), (-ny, nx)):
            if all(abs(x * kx + y * ky) < 1 - SAME_LANDMARK**2 / 2 for kx, ky in kept):
                kept.append((x, y))
    return kept


def _bisectors(edges: Lines) -> Lines:
    """Both bisectors of each pair of lines; for parallel ones the line half way."""
    i, j = np.triu_indices(len(edges), 1)
    a, b = edges[i], edges[j]
    both = np.concatenate([a + b, a - b])
    norm = np.linalg.norm(both[:, :2], axis=1)
    usable = norm > 1e-3
    return np.asarray(both[usable] / norm[usable, None])


def _square_to(edges: Lines, points: Floats) -> Lines:
    """Lines through each point at right angles to each edge direction, and parallel to it."""
    rows = []
    for normal in (edges[:, :2], np.stack([-edges[:, 1], edges[:, 0]], axis=1)):
        offsets = normal @ points.T
        spread = np.repeat(normal, len(points), axis=0)
        rows.append(np.column_stack([spread, offsets.ravel()]))
    return np.concatenate(rows)


def distinct_lines(lines: Lines) -> Lines:
    """Lines with the normal in the upper half plane, near-equal ones once, in a fixed order."""
    flip = (lines[:, 1] < -1e-9) | ((np.abs(lines[:, 1]) <= 1e-9) & (lines[:, 0] < 0))
    upright = np.where(flip[:, None], -lines, lines)
    keys = np.round(upright / SAME_LANDMARK).astype(np.int64)
    _, first = np.unique(keys, axis=0, return_index=True)
    return np.asarray(upright[np.sort(first)])


def all_lines(paper: Paper, degrees: float, spacing: float) -> Lines:
    """A grid of lines across the folded paper: one each ``degrees`` of angle and ``spacing`` of offset."""
    angles = np.arange(0.0, 180.0, degrees)
    return lines_across(paper, [(cos(radians(angle)), sin(radians(angle))) for angle in angles], spacing)


def lines_across(paper: Paper, normals: Iterable[npt.ArrayLike], spacing: float) -> Lines:
    """Lines across the folded paper at each ``spacing`` of offset, for each unit normal, (n, 3)."""
    points = distinct_points(paper)
    rows = []
    for normal in normals:
        heights = points @ np.asarray(normal)
        offsets = np.arange(heights.min() + spacing, heights.max(), spacing)
        rows.append(np.column_stack([np.full((len(offsets), 2), normal), offsets]))
    return np.concatenate(rows)


def both_ways(lines: Lines) -> Lines:
    """Each line with either side moving."""
    return np.concatenate([lines, -lines])


def best_supported(lines: Lines, support: Floats, least: float, most: int) -> Lines:
    """At most ``most`` lines with at least some support, the best supported first, evenly spread among equals."""
    chosen: list[npt.NDArray[np.int64]] = []
    room = most
    level = np.round(support * 10)
    for value in sorted(set(level[support >= least].tolist()), reverse=True):
        equals = np.nonzero((level == value) & (support >= least))[0]
        if len(equals) > room:
            equals = equals[np.linspace(0, len(equals) - 1, room).astype(int)]
        chosen.append(equals)
        room -= len(equals)
        if room <= 0:
            break
    return lines[np.concatenate(chosen)] if chosen else lines[:0]


def as_line(row: Floats) -> Line:
    """One row of a (n, 3) array as a line."""
    nx, ny, offset = row.tolist()
    return Line(nx, ny, offset)


def angle_between(a: Line, b: Line) -> float:
    """The angle between two lines' directions in degrees, 0 to 90."""
    turn = abs(atan2(a.nx * b.ny - a.ny * b.nx, a.nx * b.nx + a.ny * b.ny)) * 180 / pi
    return min(turn, 180 - turn)


@dataclass(frozen=True)
class ChangedPoints:
    """What changed between a drawing of the last state and a photo, as points of the paper's own plane (n, 2).

    ``gone`` was paper and is table now, ``came`` was table and is paper, ``turned`` is paper that changed its class.
    """

    gone: Floats
    came: Floats
    turned: Floats
    before: LabelImage
    scene: Scene
    motion: Similarity

    @property
    def shows(self) -> bool:
        """Whether anything changed."""
        return max(len(self.gone), len(self.came), len(self.turned)) >= _ENOUGH

    def support(self, lines: Lines) -> Floats:
        """How well each line (n, 3) could explain the change, (n,) from 0 to 1.

        What is gone must lie on the moving side and land on paper; what came must be the image of paper; what turned
        must lie on the moving side or be the image of paper. The least of the three shares counts.
        """
        least = np.ones(len(lines))
        seen = _Pixels(self.scene.grid, self.motion)
        placed = seen.lines(lines)
        for points, rule in ((self.gone, self._gone), (self.came, self._came), (self.turned, self._turned)):
            if len(points) >= _ENOUGH:
                spots = seen.points(points)
                parts = np.array_split(placed, max(1, len(placed) // 500))
                shares = [rule(_Mirrored(part, spots), seen.margin).mean(axis=1) for part in parts]
                least = np.minimum(least, np.concatenate(shares))
        return least

    def _gone(self, mirrored: "_Mirrored", margin: float) -> Bools:
        return np.asarray((mirrored.side > -margin) & (mirrored.look(self.scene.labels) != BACKGROUND))

    def _came(self, mirrored: "_Mirrored", margin: float) -> Bools:
        return np.asarray((mirrored.side < margin) & is_paper(mirrored.look(self.before)))

    def _turned(self, mirrored: "_Mirrored", margin: float) -> Bools:
        return np.asarray((mirrored.side > -margin) | is_paper(mirrored.look(self.before)))


_ENOUGH = 8
"""Fewer changed points than this are noise."""
_MARGIN = 0.02
"""How far points may lie on the wrong side of a line, in sheet units."""
_POINTS = 250
"""Places on the paper by which lines and what changed are compared."""


class _Pixels:
    """The paper's plane under a motion, in pixels of a grid: very many mirror images are looked up there."""

    def __init__(self, grid: Grid, motion: Similarity) -> None:
        a, b, c, d, e, f = motion
        s = grid.pixels_per_unit
        self._matrix = np.array([[a * s, b * s], [-c * s, -d * s]])
        self._shift = np.array([(e - grid.left) * s - 0.5, (grid.top - f) * s - 0.5])
        self._scale = s * motion.scale
        self.margin = _MARGIN * self._scale

    def points(self, points: Floats) -> Float32s:
        """Points (k, 2) as (column, row)."""
        return np.asarray(points @ self._matrix.T + self._shift, np.float32)

    def lines(self, lines: Lines) -> Float32s:
        """Lines (n, 3) with distances in pixels."""
        normals = lines[:, :2] @ self._matrix.T / self._scale
        offsets = lines[:, 2] * self._scale + normals @ self._shift
        return np.column_stack([normals, offsets]).astype(np.float32)


class _Mirrored:
    """Points (k, 2) mirrored in lines (n, 3), all in pixels; ``side`` (n, k) are their signed distances from the lines."""

    def __init__(self, lines: Float32s, points: Float32s) -> None:
        self.side = lines[:, :2] @ points.T - lines[:, 2:]
        self._cols = points[:, 0] - 2 * self.side * lines[:, :1]
        self._rows = points[:, 1] - 2 * self.side * lines[:, 1:2]

    def look(self, labels: LabelImage) -> LabelImage:
        """The label under each mirror image, (n, k); background outside the picture."""
        height, width = labels.shape
        framed = np.full((height + 2, width + 2), BACKGROUND, np.uint8)
        framed[1:-1, 1:-1] = labels
        rows = np.clip(np.rint(self._rows), -1, height).astype(np.int32)
        cols = np.clip(np.rint(self._cols), -1, width).astype(np.int32)
        return np.asarray(framed.ravel().take((rows + 1) * (width + 2) + cols + 1))


def changed_points(before: LabelImage, scene: Scene, motion: Similarity) -> ChangedPoints:
    """What changed from a drawing under ``motion`` to the photo; thin rims of misalignment do not count."""
    was, now = before != BACKGROUND, scene.paper
    known = scene.known & (scene.labels != UNKNOWN)
    back = motion.inverse()
    gone, came, turned = (
        _points(_opened(mask), scene, back)
        for mask in (was & ~now & known, now & ~was, was & now & (before != scene.labels))
    )
    return ChangedPoints(gone, came, turned, before, scene, motion)


def _opened(mask: Mask) -> Mask:
    """A mask without parts thinner than three pixels."""
    kernel = np.ones((3, 3), np.uint8)
    return np.asarray(cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0)


def _points(mask: Mask, scene: Scene, back: Similarity) -> Floats:
    """Up to some hundred points spread over a mask, in the paper's plane (n, 2)."""
    rows, cols = spread_over(mask, _POINTS)
    return transformed(scene.grid.to_plane(np.stack([cols, rows], axis=1)), back)
