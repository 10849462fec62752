"""Where the folded paper is in space and in the picture: layer heights, vertices, face outlines."""

from dataclasses import dataclass

import numpy as np

from folding_server.photographer.camera import Camera, Matrix, scaled
from folding_server.simulator import Paper, overlapping_pairs

THICKNESS = 0.001
"""Height of one layer of folded paper in sheet sides: thin paper, not pressed quite flat."""


@dataclass(frozen=True)
class Placement:
    """A folded paper on the table as a camera sees it.

    ``folded_to_table`` affine (2, 3); ``level`` face -> layers below it; ``pixels`` vertex -> (x, y).
    """

    paper: Paper
    camera: Camera
    folded_to_table: Matrix
    level: dict[int, int]
    pixels: dict[int, tuple[float, float]]

    @property
    def folded_to_pixel(self) -> Matrix:
        """Homography from folded coordinates at the height of the table to pixels."""
        return scaled(self.camera.table_to_pixel @ np.vstack([self.folded_to_table, [0, 0, 1]]))

    def outline(self, face: int) -> Matrix:
        """Pixels (n, 2) of a face's boundary, in the order of its cycle."""
        return np.array([self.pixels[v] for v in self.paper.faces[face]])

    def sheet_to_pixel(self, face: int) -> Matrix:
        """Homography from the unfolded sheet to pixels for the paper of one face."""
        m = self.paper.isometries[face]
        return scaled(self.folded_to_pixel @ np.array([[m.a, m.b, m.e], [m.c, m.d, m.f], [0, 0, 1.0]]))


def place(paper: Paper, camera: Camera, folded_to_table: Matrix) -> Placement:
    """Lay a paper on the table, seen at the mean height of its layers: edges on one another stay so."""
    level = layer_levels(paper)
    vertices = sorted(paper.positions)
    flat = np.array([paper.positions[v] for v in vertices]) @ folded_to_table[:, :2].T + folded_to_table[:, 2]
    height = THICKNESS * float(np.mean(list(level.values())))
    seen = camera.project(np.column_stack([flat, np.full(len(flat), height)]))
    pixels = {v: (float(x), float(y)) for v, (x, y) in zip(vertices, seen, strict=True)}
    return Placement(paper, camera, folded_to_table, level, pixels)


def layer_levels(paper: Paper) -> dict[int, int]:
    """Face -> the most layers that lie below it anywhere."""
    level = dict.fromkeys(paper.order, 0)
    below: dict[int, list[int]] = {}
    for lower, upper in overlapping_pairs(paper):
        below.setdefault(upper, []).append(lower)
    for face in paper.order:
        level[face] = 1 + max((level[f] for f in below.get(face, ())), default=-1)
    return level
