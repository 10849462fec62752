"""A pinhole camera over the table, as the homography that it makes between the plane of the sheet and a picture."""

from dataclasses import dataclass
from math import atan2, cos, degrees, exp, hypot, log, pi, sin

import numpy as np

from folding_server.arrays import Floats
from folding_server.geometry.line import Point
from folding_server.vision.pose import SHEET, Pose

SAME_SIZE, SAME_ROLL, SAME_TILT = 0.08, 12.0, 20.0
"""Logarithm of a scale, and degrees of roll and tilt, within which a camera may be one that stands: perspective over a table and
careless hands do as much.
"""
CameraVector = tuple[float, ...]
PlaneAxis = tuple[float, float, float]
STEPS = (1e-4, 1e-4, 1e-4, 1e-4, 1e-3, 1e-3)
"""Changes of the camera's vector for its slopes: far below a pixel, far above rounding."""

FIELD = 2.6
"""Units along the longer side of a picture: as many as the solver's field of view has."""
USUAL_FOCAL = 1.25
"""Focal length of a camera of which nothing is known, in longer sides of the picture: phones have 0.7, cameras to 1.7."""


@dataclass(frozen=True)
class PictureFrame:
    """A photo's own coordinates, x right and y up from its middle, the longer side ``FIELD`` units long.

    ``width`` and ``height`` in pixels, ``focal`` in these units.
    """

    width: int
    height: int
    focal: float = USUAL_FOCAL * FIELD

    @property
    def pixels_per_unit(self) -> float:
        """Pixels per unit of these coordinates."""
        return max(self.width, self.height) / FIELD

    @property
    def pose(self) -> Pose:
        """The pose under which the plane of the sheet is the picture itself, the middle of both at (0.5, 0.5)."""
        scale = self.pixels_per_unit
        middle = (self.width - 1) / 2, (self.height - 1) / 2
        return Pose(tuple((middle[0] + (x - 0.5) * scale, middle[1] - (y - 0.5) * scale) for x, y in SHEET))


@dataclass(frozen=True)
class PinholeCamera:
    """A camera that sees the point ``pivot`` of the sheet's plane at (``x``, ``y``) of the picture.

    ``roll`` in radians counter-clockwise as seen, ``size`` the logarithm of picture units per sheet unit there,
    (``tilt_x``, ``tilt_y``) the rotation vector in radians from looking straight down, ``focal`` in picture units.
    """

    pivot: Point
    x: float
    y: float
    roll: float
    size: float
    tilt_x: float = 0.0
    tilt_y: float = 0.0
    focal: float = USUAL_FOCAL * FIELD

    @property
    def tilt(self) -> float:
        """The angle in degrees between the axis of the camera and the normal of the table."""
        return degrees(hypot(self.tilt_x, self.tilt_y))

    @property
    def homography(self) -> Floats:
        """(3, 3), from the plane of the sheet to the picture's coordinates, its middle at (0.5, 0.5)."""
        return np.array(_matrix(self))

    @property
    def slopes(self) -> Floats:
        """(6, 3, 3): how the homography changes with each coordinate of :meth:`vector`, by central differences."""
        start, rows = self.vector(), []
        for i, step in enumerate(STEPS):
            up, down = ((*start[:i], start[i] + sign * step, *start[i + 1 :]) for sign in (1, -1))
            rows.append((np.array(_matrix(self.moved(up))) - _matrix(self.moved(down))) / (2 * step))
        return np.stack(rows)

    def vector(self) -> CameraVector:
        """What a search may change: x, y, roll, size, tilt_x, tilt_y."""
        return self.x, self.y, self.roll, self.size, self.tilt_x, self.tilt_y

    def moved(self, vector: CameraVector) -> "PinholeCamera":
        """The same with other values of :meth:`vector`."""
        x, y, roll, size, tilt_x, tilt_y = vector
        return PinholeCamera(self.pivot, x, y, roll, size, tilt_x, tilt_y, self.focal)

    def pose(self, frame: PictureFrame) -> Pose:
        """Where the corners of the flat sheet would lie in the photo."""
        corners = frame.pose.to_photo(projected(self.homography, np.array(SHEET)))
        return Pose(tuple((float(x), float(y)) for x, y in corners))


def camera_of(affine: Floats, pivot: Point, at: Point, focal: float) -> PinholeCamera:
    """The camera that shows the neighbourhood of ``pivot`` by an affine map (2, 2), and ``pivot`` at a place of the picture
    relative to its middle. Of the two tilts that foreshorten so, the one is given; the other is its negative.
    """
    left, sizes, right = np.linalg.svd(affine)
    turn = left @ right
    short = min(1.0, float(sizes[1] / sizes[0]))
    axis = left[:, 0]
    angle = float(np.arccos(short))
    return PinholeCamera(
        pivot,
        at[0],
        at[1],
        atan2(turn[1, 0], turn[0, 0]),
        log(float(sizes[0])),
        float(axis[0]) * angle,
        float(axis[1]) * angle,
        focal,
    )


def upright_camera(pose: Pose, frame: PictureFrame) -> PinholeCamera:
    """A camera that looks straight down from where the first photo was taken, not turned: vertex 1 is its upper left."""
    size = log(pose.pixels_per_unit / frame.pixels_per_unit)
    return PinholeCamera((0.5, 0.5), 0.0, 0.0, 0.0, size, focal=frame.focal)


def only_moved(camera: PinholeCamera, before: PinholeCamera) -> bool:
    """Whether a camera shows the sheet as large as another one does, hardly turned, and from nearly above: it may be the sheet that
    was moved. A turn of it is an action.
    """
    turned = abs(degrees((camera.roll - before.roll + pi) % (2 * pi) - pi))
    return abs(camera.size - before.size) < SAME_SIZE and turned < SAME_ROLL and camera.tilt < SAME_TILT


def projected(matrix: Floats, points: Floats) -> Floats:
    """Points (N, 2) through a homography."""
    moved = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    return np.asarray(moved[:, :2] / moved[:, 2:], np.float64)


def _matrix(camera: PinholeCamera) -> tuple[tuple[float, float, float], ...]:
    """The homography by rows: the focal length times the plane's two axes and its origin, as the camera has them. Searches ask for
    very many.
    """
    first, second = _axes(camera)
    depth = camera.focal / exp(camera.size)
    px, py = camera.pivot
    middle = depth * camera.x / camera.focal, depth * camera.y / camera.focal, depth
    x, y, z = ((a, b, m - px * a - py * b) for a, b, m in zip(first, second, middle, strict=True))
    focal = camera.focal
    return (
        (focal * x[0] + 0.5 * z[0], focal * x[1] + 0.5 * z[1], focal * x[2] + 0.5 * z[2]),
        (focal * y[0] + 0.5 * z[0], focal * y[1] + 0.5 * z[1], focal * y[2] + 0.5 * z[2]),
        z,
    )


def _axes(camera: PinholeCamera) -> tuple[PlaneAxis, PlaneAxis]:
    """The axes of the sheet's plane as the camera has them: the roll, then the rotation vector (tilt_x, tilt_y, 0) by Rodrigues."""
    angle = hypot(camera.tilt_x, camera.tilt_y)
    kx, ky = (camera.tilt_x / angle, camera.tilt_y / angle) if angle > 1e-12 else (1.0, 0.0)
    s, versed = sin(angle), 1 - cos(angle)
    right = 1 - versed * ky * ky, versed * kx * ky, -s * ky
    up = versed * kx * ky, 1 - versed * kx * kx, s * kx
    c, n = cos(camera.roll), sin(camera.roll)
    (a, b, e), (f, g, h) = right, up
    return (c * a + n * f, c * b + n * g, c * e + n * h), (c * f - n * a, c * g - n * b, c * h - n * e)
