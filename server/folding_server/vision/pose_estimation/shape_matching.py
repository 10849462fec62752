"""Which of many folded papers a photo may show, whatever the camera: shapes compared up to an affine map.

Both shapes are brought to a common form by the moments of their silhouettes (whitening), which leaves a rotation; that is
found by correlation over the angle of polar samples. What the two whitenings and the rotation make is an affine map, and
only those are allowed that a camera tilted by at most so much makes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Floats
from folding_server.geometry.line import Point
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACK, FRONT, LabelImage, is_paper

ANGLES, RADII = 96, 20
"""Polar samples of a shape."""
SAMPLED_RADIUS = 2.4
"""Radius, in standard deviations of the silhouette, up to which a shape is sampled."""
FORESHORTENED = 0.8
"""Least ratio of the two scales of an affine map that a camera makes: tilted by 25 degrees 0.91, seen 15 degrees beside the
middle of the picture 0.97, and errors of the outline and of the rotation, found in steps of 4 degrees, on top: 0.857 was
met at a tilt of 19 degrees.
"""
TOGETHER = 256
"""Shapes that are compared at once: more would take memory and no less time."""
WAYS = 4
"""Rotations kept of each shape: a square has as many."""


@dataclass(frozen=True)
class NormalForm:
    """A shape whitened by its silhouette: ``center`` (2,) and ``spread`` (2, 2) take normal coordinates to the plane,
    ``samples`` is (sides, RADII, ANGLES) uint8, 1 where the side shows.
    """

    center: Floats
    spread: Floats
    samples: npt.NDArray[np.uint8]


def normal_form(labels: LabelImage, grid: Grid) -> NormalForm | None:
    """The normal form of the paper in a label image; None if it shows too little."""
    moments = cv2.moments(is_paper(labels).astype(np.uint8), binaryImage=True)
    if moments["m00"] < 50:
        return None
    area = moments["m00"]
    pixel = np.array([moments["m10"], moments["m01"]]) / area
    second = np.array([[moments["mu20"], moments["mu11"]], [moments["mu11"], moments["mu02"]]]) / area
    values, vectors = np.linalg.eigh(second)
    root = vectors @ np.diag(np.sqrt(np.maximum(values, 0.05))) @ vectors.T
    flip = np.diag([1.0, -1.0]) / grid.pixels_per_unit
    angles = np.arange(ANGLES) * 2 * np.pi / ANGLES
    radii = (np.arange(RADII) + 0.5) * SAMPLED_RADIUS / RADII
    circle = np.stack([np.cos(angles), np.sin(angles)])
    spread = flip @ root @ np.diag([1.0, -1.0])
    places = pixel[:, None, None] + np.einsum(
        "ij,jra->ira", root @ np.diag([1.0, -1.0]), radii[:, None] * circle[:, None]
    )
    maps = places.astype(np.float32)
    sampled = cv2.remap(labels, maps[0], maps[1], cv2.INTER_NEAREST)
    samples = np.stack([sampled == side for side in (FRONT, BACK)]).astype(np.uint8)
    return NormalForm(grid.to_plane(pixel), spread, samples)


@dataclass(frozen=True)
class AffineMatch:
    """The candidate ``index`` explains the photo with this ``agreement`` under ``affine`` (2, 2) about its ``pivot``, which
    the photo shows at ``at``.
    """

    index: int
    agreement: float
    affine: Floats
    pivot: Point
    at: Point
    stretch: float


_WEIGHT = (np.arange(RADII) + 0.5)[None, :, None]


def affine_matches(
    seen: NormalForm, shapes: Sequence[NormalForm], most: int, each: int = WAYS
) -> list[AffineMatch]:
    """At most ``each`` ways, for each shape, in which a camera may show it as the photo does; the ``most`` best, best first."""
    parts = [_agreement(seen, shapes[i : i + TOGETHER]) for i in range(0, len(shapes), TOGETHER)]
    if not parts:
        return []
    agreement = np.concatenate(parts)
    reachable = agreement.max(axis=1)
    found: list[AffineMatch] = []
    for index in np.argsort(-reachable, kind="stable").tolist():
        if len(found) >= most and reachable[index] < found[most - 1].agreement:
            break
        found += _of_shape(index, agreement[index], seen, shapes[index], each)
        found.sort(key=lambda match: (-match.agreement, match.index))
        del found[most:]
    return found


def _agreement(seen: NormalForm, shapes: Sequence[NormalForm]) -> Floats:
    """The share of each shape and the photo, taken together, that is alike, under every rotation, (shapes, ANGLES)."""
    spectrum = np.fft.rfft(seen.samples * _WEIGHT, axis=-1)
    other = np.fft.rfft(np.stack([s.samples for s in shapes]), axis=-1)
    common = np.fft.irfft((spectrum * other.conj()).sum(axis=(1, 2)), n=ANGLES)
    seen_any, any_of = seen.samples.max(axis=0), np.stack([s.samples.max(axis=0) for s in shapes])
    shared = np.fft.irfft(
        (np.fft.rfft(seen_any * _WEIGHT[0], axis=-1) * np.fft.rfft(any_of, axis=-1).conj()).sum(axis=1),
        n=ANGLES,
    )
    union = (seen_any * _WEIGHT[0]).sum() + (any_of * _WEIGHT[0]).sum(axis=(1, 2))[:, None] - shared
    return np.asarray(common / np.maximum(union, 1e-6))


def _of_shape(
    index: int, agreement: Floats, seen: NormalForm, shape: NormalForm, each: int
) -> list[AffineMatch]:
    """The best rotations of one shape that make an affine map a camera makes."""
    angles = np.arange(ANGLES) * 2 * np.pi / ANGLES
    turns = np.stack([[np.cos(angles), -np.sin(angles)], [np.sin(angles), np.cos(angles)]]).transpose(2, 0, 1)
    affine = seen.spread @ turns @ np.linalg.inv(shape.spread)
    sizes = np.linalg.svd(affine, compute_uv=False)
    stretch = sizes[:, 1] / sizes[:, 0]
    allowed = np.where(stretch >= FORESHORTENED, agreement, -1.0)
    kept: list[int] = []
    for i in np.argsort(-allowed, kind="stable"):
        if allowed[i] < 0 or len(kept) == each:
            break
        if all(min(abs(i - k), ANGLES - abs(i - k)) > 4 for k in kept):
            kept.append(int(i))
    pivot, at = (
        (float(shape.center[0]), float(shape.center[1])),
        (float(seen.center[0]), float(seen.center[1])),
    )
    return [AffineMatch(index, float(agreement[k]), affine[k], pivot, at, float(stretch[k])) for k in kept]
