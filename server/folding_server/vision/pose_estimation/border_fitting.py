"""The camera to a fraction of a pixel: drawn borders pulled onto those of the photo (edge ICP, Gauss-Newton)."""

from dataclasses import dataclass
from math import inf

import numpy as np

from folding_server.arrays import Floats, Image
from folding_server.geometry.convex import Polygon
from folding_server.vision.labels import LabelImage, as_one_colour
from folding_server.vision.pose_estimation.pinhole import CameraVector, PinholeCamera, projected
from folding_server.vision.raster import draw_labels
from folding_server.vision.registration.edge_matching import border_of, class_maps, crossings
from folding_server.vision.registration.scene import FaceStack, Scene

ROUGH_REACHES = (0.12, 0.08, 0.05)
FIRST_REACHES, LAST_REACHES = (0.12, 0.08, 0.06, 0.04), (0.03, 0.02, 0.02, 0.015, 0.015, 0.015)
"""How far, in shares of the paper's extent, points look along their normals in each round: of a rough fit, and of the two halves
of a full one.
"""
FEWEST_POINTS = 16
"""With fewer points that find their border nothing is moved."""
SETTLED = 2e-4
"""Change of the camera's vector, in picture units and radians, below which another round as far moves nothing: a fiftieth of a pixel."""
LIKELY_TILT = 0.35
"""Standard deviation, in radians, that the tilt is taken to have: 20 degrees. People look down at what they fold."""
POINT_ERROR = 0.01
"""Standard deviation of a border's place, in shares of the extent: the outline's own error and the paper's thickness."""


@dataclass(frozen=True)
class Fitted:
    """A camera, and how well the paper agrees with the photo under it, 0 to 1."""

    camera: PinholeCamera
    agreement: float


def drawn(stack: FaceStack, camera: PinholeCamera, scene: Scene) -> LabelImage:
    """What a photo of a stack would show."""
    matrix = camera.homography
    lengths = [len(outline) for outline in stack.outlines]
    points = projected(matrix, np.array([p for outline in stack.outlines for p in outline]))
    polygons: list[Polygon] = [part.tolist() for part in np.split(points, np.cumsum(lengths)[:-1])]
    labels = draw_labels(polygons, stack.backs, scene.grid)
    return labels if scene.two_coloured else as_one_colour(labels)


def fitted(stack: FaceStack, scene: Scene, camera: PinholeCamera, reaches: tuple[float, ...]) -> Fitted:
    """The camera near a first guess under which the borders of a stack lie on those of the photo."""
    extent = _extent(scene)
    seen = list(class_maps(scene.labels, scene.known))
    labels = drawn(stack, camera, scene)
    best = Fitted(camera, scene.agreement_of(labels))
    settled = inf
    for share in reaches:
        if share >= settled:
            continue
        moved = _pulled(labels, scene, camera, seen, share * extent, extent)
        if moved is None:
            break
        settled = share if _change(camera, moved) < SETTLED else inf
        camera = moved
        labels = drawn(stack, camera, scene)
        agreement = scene.agreement_of(labels)
        if agreement > best.agreement:
            best = Fitted(camera, agreement)
    return best


def _change(first: PinholeCamera, second: PinholeCamera) -> float:
    """The largest change of a coordinate from one camera to another."""
    return max(abs(a - b) for a, b in zip(first.vector(), second.vector(), strict=True))


def _extent(scene: Scene) -> float:
    """The longer side of the box about the paper, in picture units."""
    rows, cols = np.nonzero(scene.paper)
    return max(int(np.ptp(rows)), int(np.ptp(cols)), 1) / scene.grid.pixels_per_unit


def _pulled(
    labels: LabelImage, scene: Scene, camera: PinholeCamera, seen: list[Image], reach: float, extent: float
) -> PinholeCamera | None:
    """The camera after one round, under which a stack looked as ``labels``; None if too few borders find theirs."""
    grid = scene.grid
    span = np.arange(
        -max(2, round(reach * grid.pixels_per_unit)), max(2, round(reach * grid.pixels_per_unit)) + 1.0
    )
    places, normals, ways = [], [], []
    for image, photo in zip(class_maps(labels, scene.known), seen, strict=True):
        border = border_of(image, scene.known)
        if not len(border.points):
            continue
        way = (crossings(photo, border, span) - crossings(image, border, span)) / grid.pixels_per_unit
        found = np.isfinite(way)
        places.append(grid.to_plane(border.points[found]))
        normals.append(border.normals[found] * (1, -1))
        ways.append(way[found])
    if sum(map(len, ways)) < FEWEST_POINTS:
        return None
    return _solved(
        camera, np.concatenate(places), np.concatenate(normals), np.concatenate(ways), reach, extent
    )


def _solved(
    camera: PinholeCamera, places: Floats, normals: Floats, ways: Floats, reach: float, extent: float
) -> PinholeCamera:
    """Weighted least squares over the camera's vector, far points counting less, with the prior on the tilt."""
    start = np.array(camera.vector())
    points = projected(np.asarray(np.linalg.inv(camera.homography), np.float64), places)
    slopes = _slopes(camera, points, normals)
    weights = 1 / (1 + (3 * ways / reach) ** 2) / (POINT_ERROR * extent) ** 2
    weights *= min(1.0, 40 / len(ways))
    normal = slopes.T @ (weights[:, None] * slopes)
    gradient = slopes.T @ (weights * ways)
    for i in (4, 5):
        normal[i, i] += 1 / LIKELY_TILT**2
        gradient[i] -= start[i] / LIKELY_TILT**2
    normal += 1e-9 * np.trace(normal) * np.eye(len(start))
    change = np.linalg.solve(normal, gradient)
    limit = np.array([0.2, 0.2, 0.2, 0.2, 0.15, 0.15])
    change *= min(1.0, float((limit / np.maximum(np.abs(change), 1e-12)).min()))
    vector: CameraVector = tuple((start + change).tolist())
    return camera.moved(vector)


def _slopes(camera: PinholeCamera, points: Floats, normals: Floats) -> Floats:
    """How far each point moves along its normal per unit of each coordinate of the camera's vector, (n, 6)."""
    flat = np.column_stack([points, np.ones(len(points))])
    seen = flat @ camera.homography.T
    change = flat @ camera.slopes.transpose(0, 2, 1)
    places = seen[:, :2] / seen[:, 2:]
    moved = (change[..., :2] - places * change[..., 2:]) / seen[:, 2:]
    return np.asarray((moved * normals).sum(axis=-1).T, np.float64)
