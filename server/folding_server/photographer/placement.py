"""Where the folded paper is in space and in the picture: layer heights, vertices, face outlines."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from folding_server.photographer.pinhole_camera import Camera, Matrix, scaled
from folding_server.simulator import Paper, overlapping_pairs

LAYER_HEIGHT = 0.001
"""Height of one layer of folded paper in sheet sides: thin paper, not pressed quite flat."""


@dataclass(frozen=True)
class FaceGroup:
    """Faces that lie on one another, bottom to top as the camera sees them; ``raised`` if off the table."""

    faces: tuple[int, ...]
    raised: bool


class PaperView(Protocol):
    """A paper as a camera sees it, flat on the table or a part of it standing up: what a painter has to know."""

    @property
    def paper(self) -> Paper:
        """The paper whose faces and creases are seen."""

    @property
    def camera(self) -> Camera:
        """Who looks."""

    @property
    def level(self) -> dict[int, int]:
        """Face -> layers below it."""

    @property
    def groups(self) -> tuple[FaceGroup, ...]:
        """All faces in the order of painting."""

    @property
    def corners(self) -> Matrix:
        """Pixels (n, 2) that the paper and shadows of raised parts stay within."""

    def outline(self, face: int) -> Matrix:
        """Pixels (n, 2) of a face's boundary, in the order of its cycle."""

    def shadow(self, face: int, azimuth: float) -> Matrix:
        """Pixels (n, 2) of the outline of a raised face's shadow under a lamp at an azimuth (degrees)."""

    def height(self, group: FaceGroup) -> float:
        """The mean height of a group in sheet sides."""

    def sheet_to_pixel(self, face: int) -> Matrix:
        """Homography from the unfolded sheet to pixels for the paper of one face."""

    def back_up(self, face: int) -> bool:
        """Whether the back of the sheet is seen at a face."""

    def brightness(self, face: int, azimuth: float) -> float:
        """How much light of a lamp at an azimuth (degrees) a face gets, relative to the table."""


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

    @property
    def groups(self) -> tuple[FaceGroup, ...]:
        """All faces, bottom to top: they lie on the table."""
        return (FaceGroup(self.paper.order, raised=False),)

    @property
    def corners(self) -> Matrix:
        """Pixels (n, 2) of all vertices."""
        return np.array(list(self.pixels.values()))

    def shadow(self, face: int, azimuth: float) -> Matrix:  # noqa: ARG002  (what lies casts none to the side)
        """The outline itself."""
        return self.outline(face)

    def height(self, group: FaceGroup) -> float:  # noqa: ARG002  (there is one group)
        """0: it lies on the table."""
        return 0.0

    def back_up(self, face: int) -> bool:
        """Whether the back of the sheet is up at a face."""
        return self.paper.back_up(face)

    def brightness(self, face: int, azimuth: float) -> float:  # noqa: ARG002  (all of it lies alike)
        """1: as much light as the table."""
        return 1.0

    def outline(self, face: int) -> Matrix:
        """Pixels (n, 2) of a face's boundary, in the order of its cycle."""
        return np.array([self.pixels[v] for v in self.paper.faces[face]])

    def sheet_to_pixel(self, face: int) -> Matrix:
        """Homography from the unfolded sheet to pixels for the paper of one face."""
        m = self.paper.isometries[face]
        return scaled(self.folded_to_pixel @ np.array(m.rows))


def place(paper: Paper, camera: Camera, folded_to_table: Matrix) -> Placement:
    """Lay a paper on the table, seen at the mean height of its layers: edges on one another stay so."""
    level = layer_levels(paper)
    vertices = sorted(paper.folded_vertices_coords)
    flat = (
        np.array([paper.folded_vertices_coords[v] for v in vertices]) @ folded_to_table[:, :2].T
        + folded_to_table[:, 2]
    )
    height = LAYER_HEIGHT * float(np.mean(list(level.values())))
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
