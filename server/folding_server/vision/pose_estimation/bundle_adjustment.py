"""Bundle adjustment: the creases of a model and the camera of every photo of it, fitted to all photos at once.

Gauss-Newton over the distances between drawn borders and those of the photos; each camera shows in its own photo
alone and is eliminated from the normal equations by its Schur complement (Triggs et al., Bundle Adjustment: A
Modern Synthesis, 1999).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

import numpy as np

from folding_server.arrays import Floats, Image
from folding_server.vision.pose_estimation.border_fitting import (
    FAR,
    INDEPENDENT_POINTS,
    LIKELY_TILT,
    BorderMatches,
    add_tilt_prior,
    allowed_share,
    camera_slopes,
    drawn,
    matched_borders,
    paper_extent,
    point_weights,
)
from folding_server.vision.pose_estimation.pinhole import PinholeCamera
from folding_server.vision.registration.edge_matching import class_maps
from folding_server.vision.registration.scene import FaceStack, Scene

BORDER_ERROR = 0.005
"""Standard deviation of a border's place, in shares of the paper's extent: twice what is left after a fit of the right creases, since
paper that curls or is shaded is wrong along a whole border.
"""
OFFSET_ERROR = 0.008
"""Standard deviation, in sheet units, of how far a crease lies beside where it was taken to be."""
ADJUSTED_REACHES = (0.03, 0.02, 0.02, 0.015, 0.015)
"""How far, in shares of the paper's extent, points look along their normals in each round."""
OFFSET_STEP = 0.004
"""Sheet units by which an offset is changed for its slope: half a pixel or more of a photo, little enough to be straight."""
STEEPEST_SLOPE = 8.0
"""A border moves by at most so many times what an offset does: where more is seen, it was another border."""
LARGEST_CHANGE = 0.01
"""Change of an offset in one round, in sheet units, at most."""
SHARES = (1.0, 0.5, 0.25, 0.0)
"""Parts of a change of the offsets that are tried, until the photos are explained better."""
COST_SETTLED = 0.05
"""Change of the sum of squares below which another round as far moves nothing: a fortieth of what one more unknown must explain."""

FoldedStacks = Callable[[Floats], Sequence[FaceStack] | None]
"""The stack that each photo shows, its creases moved by offsets (m,) in sheet units; None if that cannot be folded."""


@dataclass(frozen=True)
class Bundle:
    """The photos of a model, each with the ``camera`` that is thought to have taken it. ``first_shown`` (m,) is the index of the
    first photo that shows each offset.
    """

    scenes: tuple[Scene, ...]
    cameras: tuple[PinholeCamera, ...]
    first_shown: tuple[int, ...]

    @cached_property
    def photos(self) -> "list[_Photo]":
        """The photos prepared for matching."""
        return [_Photo(scene) for scene in self.scenes]


@dataclass(frozen=True)
class Adjustment:
    """The ``offsets`` (m,) in sheet units, the cameras, and the sum of squares that is left, in variances of one point."""

    offsets: Floats
    cameras: tuple[PinholeCamera, ...]
    cost: float


def adjusted(folded: FoldedStacks, bundle: Bundle, start: Floats) -> Adjustment:
    """The offsets and cameras near a first guess under which all photos show the borders of the model where they are; the cameras
    alone where there are no offsets. The start if it cannot be folded.
    """
    photos = bundle.photos
    found, stacks = Adjustment(np.asarray(start, np.float64), bundle.cameras, np.inf), folded(start)
    settled = inf
    for reach in ADJUSTED_REACHES:
        if stacks is None or reach >= settled:
            continue
        matches = [p.matches(s, c, reach) for p, s, c in zip(photos, stacks, found.cameras, strict=True)]
        least = _cost(photos, matches, found, reach)
        moved = _moved(folded, found.offsets)
        equations = [
            photo.equations(index, matched, camera, moved, bundle.first_shown, reach)
            for index, (photo, matched, camera) in enumerate(zip(photos, matches, found.cameras, strict=True))
        ]
        change = _offset_change(found.offsets, equations)
        for share in SHARES if len(change) else SHARES[:1]:
            tried = _stepped(found, equations, share * change)
            tried_stacks = folded(tried.offsets)
            if (
                tried_stacks is not None
                and _cost_of(photos, tried_stacks, tried, reach) < least - COST_SETTLED
            ):
                found, stacks = tried, tried_stacks
                break
        else:
            settled = reach
    return (
        found
        if stacks is None
        else replace(found, cost=_cost_of(photos, stacks, found, ADJUSTED_REACHES[-1]))
    )


def _cost_of(photos: Sequence["_Photo"], stacks: Sequence[FaceStack], at: Adjustment, reach: float) -> float:
    """:func:`_cost` of what stacks look like."""
    matches = [p.matches(s, c, reach) for p, s, c in zip(photos, stacks, at.cameras, strict=True)]
    return _cost(photos, matches, at, reach)


def _cost(
    photos: Sequence["_Photo"], matches: Sequence[BorderMatches | None], at: Adjustment, reach: float
) -> float:
    """The sum of squares of all photos, with what the offsets themselves cost."""
    seen = (photo.cost(m, c, reach) for photo, m, c in zip(photos, matches, at.cameras, strict=True))
    return float(sum(seen) + (at.offsets**2).sum() / OFFSET_ERROR**2)


_Moved = list[tuple[Sequence[FaceStack], float] | None]
"""For each offset the stacks with it changed, and by how much; None if they cannot be folded so."""


def _moved(folded: FoldedStacks, offsets: Floats) -> _Moved:
    """The stacks with each offset changed a little."""
    moved: _Moved = []
    for k in range(len(offsets)):
        for step in (OFFSET_STEP, -OFFSET_STEP):
            changed = offsets.copy()
            changed[k] += step
            stacks = folded(changed)
            if stacks is not None:
                moved.append((stacks, step))
                break
        else:
            moved.append(None)
    return moved


@dataclass(frozen=True)
class _Equations:
    """Normal equations of one photo: of its camera (6, 6) and (6,), of the offsets (m, m) and (m,), and between them (6, m)."""

    camera: Floats
    between: Floats
    offsets: Floats
    camera_side: Floats
    offset_side: Floats


class _Photo:
    """One photo, with the class maps of its borders."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.extent = scene, paper_extent(scene)
        self.seen: list[Image] = list(class_maps(scene.labels, scene.known))

    def matches(self, stack: FaceStack, camera: PinholeCamera, reach: float) -> BorderMatches | None:
        """The borders of a stack matched with those of the photo."""
        labels = drawn(stack, camera, self.scene)
        return matched_borders(labels, self.scene, self.seen, reach * self.extent)

    def weights(self, matches: BorderMatches, reach: float) -> Floats:
        """What each matched point counts, far ones less, in inverse variances."""
        points = len(matches.ways) + matches.lost
        return point_weights(matches.ways, reach * self.extent, BORDER_ERROR * self.extent, points)

    def cost(self, matches: BorderMatches | None, camera: PinholeCamera, reach: float) -> float:
        """The weighted sum of squares, and what speaks against the tilt; a point that finds nothing is as bad as the farthest."""
        tilt = sum(x**2 for x in camera.vector()[4:]) / LIKELY_TILT**2
        most = (reach / FAR / BORDER_ERROR) ** 2
        if matches is None:
            return INDEPENDENT_POINTS * most + tilt
        points = len(matches.ways) + matches.lost
        lost = matches.lost * min(1.0, INDEPENDENT_POINTS / points) * most
        return float(self.weights(matches, reach) @ matches.ways**2) + lost + tilt

    def equations(
        self,
        index: int,
        matches: BorderMatches | None,
        camera: PinholeCamera,
        moved: _Moved,
        first_shown: Sequence[int],
        reach: float,
    ) -> _Equations | None:
        """The normal equations of the ``index``-th photo, with the prior on the tilt; None if too few borders find theirs."""
        if matches is None:
            return None
        steepest = STEEPEST_SLOPE * np.exp(camera.size)
        slopes = np.zeros((len(matches.ways), len(moved)))
        for k, changed in enumerate(moved):
            if changed is not None and first_shown[k] <= index:
                labels = drawn(changed[0][index], camera, self.scene)
                slopes[:, k] = np.clip(matches.moved(labels) / changed[1], -steepest, steepest)
        own = camera_slopes(camera, matches)
        weighted = self.weights(matches, reach)[:, None] * np.column_stack([own, slopes])
        square, side = own.T @ weighted[:, :6], weighted.T @ matches.ways
        add_tilt_prior(square, side, camera)
        square += 1e-9 * np.trace(square) * np.eye(6)
        return _Equations(square, own.T @ weighted[:, 6:], slopes.T @ weighted[:, 6:], side[:6], side[6:])


def _stepped(found: Adjustment, equations: Sequence[_Equations | None], change: Floats) -> Adjustment:
    """The offsets changed, and each camera to where it then is best."""
    cameras = []
    for camera, parts in zip(found.cameras, equations, strict=True):
        if parts is None:
            cameras.append(camera)
            continue
        side = parts.camera_side - parts.between @ change
        step = np.asarray(np.linalg.solve(parts.camera, side), np.float64)
        step *= allowed_share(step)
        cameras.append(camera.moved(tuple((np.array(camera.vector()) + step).tolist())))
    return replace(found, offsets=found.offsets + change, cameras=tuple(cameras))


def _offset_change(offsets: Floats, equations: Sequence[_Equations | None]) -> Floats:
    """The change of the offsets (m,) with every camera free, and offsets likely to be small."""
    square = np.eye(len(offsets)) / OFFSET_ERROR**2
    side = -offsets / OFFSET_ERROR**2
    for parts in equations:
        if parts is not None:
            freed = np.linalg.solve(parts.camera, np.column_stack([parts.between, parts.camera_side]))
            square += parts.offsets - parts.between.T @ freed[:, :-1]
            side += parts.offset_side - parts.between.T @ freed[:, -1]
    return np.clip(np.linalg.solve(square, side), -LARGEST_CHANGE, LARGEST_CHANGE)
