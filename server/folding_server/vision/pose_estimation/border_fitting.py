"""The camera to a fraction of a pixel: drawn borders pulled onto those of the photo (edge ICP, Gauss-Newton)."""

from collections.abc import Callable, Sequence
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
"""How far, in shares of the paper's extent, points look along their normals in each round of a rough fit."""
FIRST_REACHES, LAST_REACHES = (0.12, 0.08, 0.06, 0.04), (0.03, 0.02, 0.02, 0.015, 0.015, 0.015)
"""The same of the two halves of a full one."""
FEWEST_POINTS = 16
"""With fewer points that find their border nothing is moved."""
SETTLED = 2e-4
"""Change of the camera's vector, in picture units and radians, below which another round as far moves nothing: a fiftieth of a pixel."""
LIKELY_TILT = 0.35
"""Standard deviation, in radians, that the tilt is taken to have: 20 degrees. People look down at what they fold."""
POINT_ERROR = 0.01
"""Standard deviation of a border's place, in shares of the extent: the outline's own error and the paper's thickness."""

INDEPENDENT_POINTS = 40
"""Points of all borders of a photo whose errors count as independent: neighbouring ones err together."""
FAR = 3.0
"""The part of its reach at which a point counts half, inverted."""
LARGEST_STEP = np.array([0.2, 0.2, 0.2, 0.2, 0.15, 0.15])
"""Change of the camera's vector in one round, at most."""


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
    extent = paper_extent(scene)
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


def paper_extent(scene: Scene) -> float:
    """The longer side of the box about the paper, in picture units."""
    rows, cols = np.nonzero(scene.paper)
    return max(int(np.ptp(rows)), int(np.ptp(cols)), 1) / scene.grid.pixels_per_unit


@dataclass(frozen=True)
class BorderMatches:
    """Points of drawn borders that found theirs in the photo: ``places`` (n, 2) and unit ``normals`` (n, 2) in picture units, and the
    ``ways`` (n,) along them to the photo's; ``lost`` points found none. ``moved`` says for another drawing how far its borders lie
    along the same normals.
    """

    places: Floats
    normals: Floats
    ways: Floats
    lost: int
    moved: Callable[[LabelImage], Floats]


def matched_borders(
    labels: LabelImage, scene: Scene, seen: Sequence[Image], reach: float
) -> BorderMatches | None:
    """The borders of a drawing matched with those of the photo, whose class maps are ``seen``, within a reach in picture units; None
    if too few find theirs.
    """
    grid = scene.grid
    width = max(2, round(reach * grid.pixels_per_unit))
    span = np.arange(-width, width + 1.0)
    maps = list(class_maps(labels, scene.known))
    borders = [border_of(image, scene.known) for image in maps]
    own = [crossings(image, border, span) for image, border in zip(maps, borders, strict=True)]
    ways = [
        crossings(photo, border, span) - here for photo, border, here in zip(seen, borders, own, strict=True)
    ]
    found = [np.isfinite(way) for way in ways]
    if sum(int(f.sum()) for f in found) < FEWEST_POINTS:
        return None

    def moved(other: LabelImage) -> Floats:
        others = class_maps(other, scene.known)
        parts = [crossings(m, b, span) - here for m, b, here in zip(others, borders, own, strict=True)]
        return np.concatenate([np.nan_to_num(p[f]) for p, f in zip(parts, found, strict=True)]) / (
            grid.pixels_per_unit
        )

    kept = list(zip(borders, ways, found, strict=True))
    return BorderMatches(
        grid.to_plane(np.concatenate([b.points[f] for b, _, f in kept])),
        np.concatenate([b.normals[f] for b, _, f in kept]) * (1, -1),
        np.concatenate([w[f] for _, w, f in kept]) / grid.pixels_per_unit,
        sum(int((~f).sum()) for f in found),
        moved,
    )


def _pulled(
    labels: LabelImage, scene: Scene, camera: PinholeCamera, seen: list[Image], reach: float, extent: float
) -> PinholeCamera | None:
    """The camera after one round, under which a stack looked as ``labels``; None if too few borders find theirs."""
    matches = matched_borders(labels, scene, seen, reach)
    if matches is None:
        return None
    return least_squares_step(camera, matches, reach, extent)[0]


def least_squares_step(
    camera: PinholeCamera,
    matches: BorderMatches,
    reach: float,
    extent: float,
    other: Floats | None = None,
    priors: Floats | None = None,
) -> tuple[PinholeCamera, Floats]:
    """Weighted least squares over the camera's vector, far points counting less, with the prior on the tilt. ``other`` (n, k) are the
    slopes of k more unknowns, ``priors`` (k,) the inverse squares of their standard deviations; their changes (k,) are given too.
    """
    start = np.array(camera.vector())
    slopes = camera_slopes(camera, matches)
    if other is not None:
        slopes = np.hstack([slopes, other])
    weights = point_weights(matches.ways, reach, POINT_ERROR * extent, len(matches.ways))
    normal = slopes.T @ (weights[:, None] * slopes)
    gradient = slopes.T @ (weights * matches.ways)
    add_tilt_prior(normal, gradient, camera)
    more = np.arange(len(start), len(normal))
    normal[more, more] += priors if priors is not None else 0.0
    normal += 1e-9 * np.trace(normal) * np.eye(len(normal))
    change = np.asarray(np.linalg.solve(normal, gradient), np.float64)
    change *= allowed_share(change[: len(start)])
    vector: CameraVector = tuple((start + change[: len(start)]).tolist())
    return camera.moved(vector), change[len(start) :]


def point_weights(ways: Floats, reach: float, error: float, points: int) -> Floats:
    """What each point counts that found its border ``ways`` (n,) off, in inverse variances: ``error`` is the standard deviation of one;
    far ones count less (Geman and McClure's loss), and all ``points`` together no more than INDEPENDENT_POINTS.
    """
    weights = 1 / (1 + (FAR * ways / reach) ** 2) / error**2
    return np.asarray(weights * min(1.0, INDEPENDENT_POINTS / points), np.float64)


def add_tilt_prior(normal: Floats, gradient: Floats, camera: PinholeCamera) -> None:
    """Add to normal equations, whose first unknowns are a camera's vector, that it is likely to look straight down."""
    for i in (4, 5):
        normal[i, i] += 1 / LIKELY_TILT**2
        gradient[i] -= camera.vector()[i] / LIKELY_TILT**2


def allowed_share(change: Floats) -> float:
    """The part of a change of a camera's vector (6,) that is made in one round."""
    return min(1.0, 1.0 / max(float(np.max(np.abs(change) / LARGEST_STEP)), 1e-12))


def camera_slopes(camera: PinholeCamera, matches: BorderMatches) -> Floats:
    """How far each matched point moves along its normal per unit of each coordinate of the camera's vector, (n, 6)."""
    points = projected(np.asarray(np.linalg.inv(camera.homography), np.float64), matches.places)
    flat = np.column_stack([points, np.ones(len(points))])
    seen = flat @ camera.homography.T
    change = flat @ camera.slopes.transpose(0, 2, 1)
    places = seen[:, :2] / seen[:, 2:]
    moved = (change[..., :2] - places * change[..., 2:]) / seen[:, 2:]
    return np.asarray((moved * matches.normals).sum(axis=-1).T, np.float64)
