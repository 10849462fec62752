"""A paper of which a part stands up from the table: its faces in space, what the camera sees, where shadows fall."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, radians, sin

import numpy as np

from folding_server.photographer.movements import Swing
from folding_server.photographer.pinhole_camera import Camera, Matrix, scaled
from folding_server.photographer.placement import LAYER_HEIGHT, FaceGroup, layer_levels
from folding_server.simulator import Paper

LEAN = 0.55
"""How far shadows reach on the table for each unit of height."""
AMBIENT = 0.5
"""The part of the light that comes from all sides."""


@dataclass(frozen=True)
class FlapRotationView:
    """A swing at an angle (degrees, 0 to 180) as a camera sees it. ``folded_to_table`` affine (2, 3)."""

    swing: Swing
    angle: float
    camera: Camera
    folded_to_table: Matrix

    @property
    def paper(self) -> Paper:
        """The paper after the swing, whose faces and creases are seen."""
        return self.swing.paper

    @cached_property
    def level(self) -> dict[int, int]:
        """Face -> layers below it."""
        return layer_levels(self.paper)

    @cached_property
    def groups(self) -> tuple[FaceGroup, ...]:
        """What stays and what moves, in the order of painting."""
        stays = FaceGroup(
            tuple(f for f in self.paper.order if f not in self.swing.starts), self._lift > LAYER_HEIGHT
        )
        turned = [f for f in self.paper.order if f in self.swing.starts]
        moves = FaceGroup(tuple(reversed(turned) if self._still_seen else turned), True)
        ordered = (stays, moves) if self.swing.over else (moves, stays)
        return tuple(group for group in ordered if group.faces)

    @cached_property
    def corners(self) -> Matrix:
        """Pixels (n, 2) around the paper and all of its shadows."""
        space = np.vstack([self.in_space(f) for f in self.paper.faces])
        reach = np.abs(LEAN * space[:, 2:]) * [[1, 1, 0]]
        flat = space * [1, 1, 0]
        return self.camera.project(np.vstack([space, flat + reach, flat - reach]))

    def outline(self, face: int) -> Matrix:
        """Pixels (n, 2) of a face's boundary, in the order of its cycle."""
        return self.camera.project(self.in_space(face))

    def shadow(self, face: int, azimuth: float) -> Matrix:
        """Pixels (n, 2) of the shadow's outline on the table under a lamp at an azimuth (degrees)."""
        space = self.in_space(face)
        away = -np.array([cos(radians(azimuth)), sin(radians(azimuth))])
        flat = space[:, :2] + LEAN * space[:, 2:] * away
        return self.camera.project(np.column_stack([flat, np.zeros(len(flat))]))

    def height(self, group: FaceGroup) -> float:
        """The mean height of a group's corners in sheet sides."""
        return float(np.mean(np.vstack([self.in_space(f) for f in group.faces])[:, 2]))

    def sheet_to_pixel(self, face: int) -> Matrix:
        """Homography from the unfolded sheet to pixels for the paper of one face."""
        return scaled(self._projection(face))

    def back_up(self, face: int) -> bool:
        """Whether the back of the sheet is seen at a face."""
        start = self.swing.starts.get(face)
        if start is None:
            return self.paper.back_up(face)
        return start.mirrors == self._still_seen

    def brightness(self, face: int, azimuth: float) -> float:
        """How much light of the lamp a face gets, relative to the table."""
        if face not in self.swing.starts:
            return 1.0
        across = self.folded_to_table[:, :2] @ [self.swing.line.nx, self.swing.line.ny]
        normal = np.array([-self._rise * across[0], -self._rise * across[1], cos(radians(self.angle))])
        lamp = np.array([LEAN * cos(radians(azimuth)), LEAN * sin(radians(azimuth)), 1.0])
        facing = float(normal @ lamp) * (1 if self._still_seen else -1)
        return AMBIENT + (1 - AMBIENT) * float(np.clip(facing, -0.25, 1.2))

    def in_space(self, face: int) -> Matrix:
        """The corners (n, 3) of a face over the table."""
        sheet = np.array([[*self.paper.vertices_coords[v], 1.0] for v in self.paper.faces[face]])
        return np.asarray((sheet @ self._sheet_to_space(face).T)[:, :3])

    def point(self, folded: Sequence[float]) -> Matrix:
        """Where a point (x, y) of the moving part, given where it was before, is now: (3,)."""
        return np.asarray((self._table @ self._turned @ [*folded, 1.0])[:3])

    @cached_property
    def _still_seen(self) -> bool:
        """Whether the camera sees the side of the moving part that was up before."""
        (face, *_) = self.swing.starts
        start = self.swing.starts[face]
        upright = float(np.linalg.det(self._projection(face))) < 0
        return upright != start.mirrors

    def _projection(self, face: int) -> Matrix:
        """Sheet to homogeneous pixels (3, 3), not scaled, so that its sign tells the side seen."""
        camera = self.camera
        seen = np.column_stack([camera.R, camera.t])
        return np.asarray(camera.K @ seen @ self._sheet_to_space(face))

    def _sheet_to_space(self, face: int) -> Matrix:
        """Affine map (4, 3) from the sheet to the table's space."""
        start = self.swing.starts.get(face)
        m = start or self.paper.isometries[face]
        folded = np.array(m.rows)
        resting = np.array([[1, 0, 0], [0, 1, 0], [0, 0, self._lift + self._thickness], [0, 0, 1.0]])
        return np.asarray(self._table @ (resting if start is None else self._turned) @ folded)

    @property
    def _table(self) -> Matrix:
        """The sheet's place on the table as a map of space (4, 4)."""
        t = self.folded_to_table
        return np.array([[*t[0, :2], 0, t[0, 2]], [*t[1, :2], 0, t[1, 2]], [0, 0, 1, 0], [0, 0, 0, 1.0]])

    @cached_property
    def _turned(self) -> Matrix:
        """The turn about the line as a map (4, 3) from folded places before to space, with the lift."""
        (nx, ny, k), c = self.swing.line, cos(radians(self.angle))
        s = self._rise
        short = np.array([nx, ny, -k]) * (1 - c)
        level = np.array([[1, 0, 0], [0, 1, 0]]) - np.outer([nx, ny], short)
        rise = np.array([s * nx, s * ny, self._lift + self._thickness - s * k])
        return np.vstack([level, rise, [0, 0, 1.0]])

    @property
    def _rise(self) -> float:
        return (1 if self.swing.over else -1) * sin(radians(self.angle))

    @cached_property
    def _lift(self) -> float:
        """How high all of it is held, so that nothing goes through the table."""
        swing = self.swing
        far = [
            swing.line.distance(m(swing.paper.vertices_coords[v]))
            for f, m in swing.starts.items()
            for v in swing.paper.faces[f]
        ]
        lowest = min(self._rise * d for d in far)
        return max(0.0, -lowest)

    @property
    def _thickness(self) -> float:
        return LAYER_HEIGHT * float(np.mean(list(self.level.values())))
