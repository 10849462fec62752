"""The cameras under which one photo may show one of many folded papers, the likeliest first."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import degrees, log, log1p, pi

import numpy as np

from folding_server.arrays import Floats
from folding_server.geometry.isometry import IDENTITY
from folding_server.geometry.point_batch import hausdorff_distance
from folding_server.vision.evidence import Evidence
from folding_server.vision.grid import grid_over
from folding_server.vision.pose_estimation.border_fitting import (
    FIRST_REACHES,
    LAST_REACHES,
    ROUGH_REACHES,
    Fitted,
    fitted,
)
from folding_server.vision.pose_estimation.picture_view import PictureView
from folding_server.vision.pose_estimation.pinhole import PinholeCamera, camera_of, projected
from folding_server.vision.pose_estimation.shape_matching import (
    WAYS,
    AffineMatch,
    NormalForm,
    affine_matches,
    normal_form,
)
from folding_server.vision.raster import draw_labels
from folding_server.vision.registration.paper_alignment import coarser
from folding_server.vision.registration.scene import FaceStack, Scene

SHAPE_RESOLUTION = 40.0
"""Pixels per sheet unit at which papers are drawn to be compared as shapes."""
FITTED, FULLY_FITTED = 48, 14
"""Matches of shape whose camera is fitted roughly, and those of them, the best, that are fitted in full: by shape alone
the truth was among the first 6 of 22 transitions, all but those whose line no construction gives.
"""
EACH_ALWAYS = 2
"""Matches of each stack that is fitted always."""
FAR_BEHIND = 0.05
"""Cameras half fitted that are worth less than the best by more, in shares of the paper, are left so: the second half of a fit
moves the camera by at most 3 % of the extent.
"""
EITHER_TILT = 6.0
"""Degrees of tilt from which a camera is fitted from both tilts that foreshorten alike."""
USUAL_TILT, STEEP = 20.0, 28.0
"""Degrees: tilts count by the square of their share of the first, and besides by what they are beyond the second."""
USUAL_ROLL = 20.0
"""Degrees that a camera is turned against the photo before, or the model on the table: 18 of 22 transitions had less."""
USUAL_NEARNESS = 0.3
"""Natural logarithm by which the camera is nearer or farther than for the photo before: hands move it by a third."""
LARGEST_ZOOM, SMALLEST_ZOOM = 3.0, 0.33
"""The camera may come so near and go so far, by scale, for nothing."""
SAME_PLACE = 0.02
"""Corners nearer to each other, in picture units, are the same."""


@dataclass(frozen=True)
class PoseEstimate:
    """The ``index``-th paper under a camera: ``agreement``, 0 to 1, ``evidence`` of such a camera, and ``prior``, what the paper costs
    in the same shares.
    """

    index: int
    camera: PinholeCamera
    agreement: float
    evidence: Evidence
    prior: float = 0.0

    @property
    def value(self) -> float:
        """Agreement less the cost of the camera and the paper."""
        return self.agreement + self.evidence.score - self.prior


def shape_of(stack: FaceStack) -> NormalForm | None:
    """A stack prepared for :func:`estimates`."""
    points = np.array([p for outline in stack.outlines for p in outline])
    low, high = points.min(axis=0) - 0.1, points.max(axis=0) + 0.1
    grid = grid_over(SHAPE_RESOLUTION, (float(low[0]), float(low[1]), float(high[0]), float(high[1])))
    return normal_form(draw_labels(stack.outlines, stack.backs, grid, IDENTITY), grid)


def estimates(
    stacks: Sequence[FaceStack],
    view: PictureView,
    before: PinholeCamera | None = None,
    prior: Sequence[float] | None = None,
    always: Sequence[int] = (),
    grown: float = 0.0,
) -> list[PoseEstimate]:
    """For the stacks that the photo resembles most: their cameras, the most valuable first.

    ``before`` is the camera of the photo before, if it is known: its size and roll are what is likely, but for its size where the
    paper has not ``grown`` in the picture, see :func:`camera_evidence`. ``prior`` is what each stack costs, in shares of the
    paper. The ``always``-th stacks are fitted however many others look more alike.
    """
    costs = prior or [0.0] * len(stacks)
    coarse = coarser(view.scene)
    begun = [
        (match, _begun(stacks[match.index], coarse, view, match))
        for match in _alike(view.scene, stacks, always)
    ]

    def estimate(index: int, fit: Fitted) -> PoseEstimate:
        return PoseEstimate(
            index, fit.camera, fit.agreement, camera_evidence(fit.camera, before, grown), costs[index]
        )

    begun.sort(key=lambda pair: -estimate(pair[0].index, pair[1]).value)
    half = [
        estimate(match.index, _half_fitted(stacks[match.index], view.scene, start.camera))
        for match, start in _worth_fitting(begun, always)
    ]
    enough = max((e.value for e in half), default=0.0) - FAR_BEHIND
    found = [
        estimate(e.index, fitted(stacks[e.index], view.scene, e.camera, LAST_REACHES))
        if e.value >= enough
        else e
        for e in half
    ]
    return sorted(found, key=lambda e: -e.value)


def _alike(scene: Scene, stacks: Sequence[FaceStack], always: Sequence[int]) -> list[AffineMatch]:
    """The FITTED best matches of all stacks with a photo, and all matches of the ``always``-th; none if it shows too little."""
    seen = normal_form(scene.labels, scene.grid)
    if seen is None:
        return []
    shapes = [shape_of(stack) for stack in stacks]

    def matched(indices: Sequence[int], most: int, each: int) -> list[AffineMatch]:
        shaped = [(i, shape) for i in indices if (shape := shapes[i]) is not None]
        found = affine_matches(seen, [shape for _, shape in shaped], most, each)
        return [replace(match, index=shaped[match.index][0]) for match in found]

    best = matched(range(len(shapes)), FITTED, WAYS)
    others = [match for match in best if match.index not in always]
    return [*others, *matched(always, WAYS * len(always), WAYS)]


_Begun = tuple[AffineMatch, Fitted]


def _worth_fitting(begun: Sequence[_Begun], always: Sequence[int]) -> list[_Begun]:
    """The first of all matches, and the first of each of the ``always``-th: of one alone the rotation may be wrong, where others
    foreshorten alike.
    """
    others = [pair for pair in begun if pair[0].index not in always]
    return [
        *others[:FULLY_FITTED],
        *(pair for i in always for pair in [p for p in begun if p[0].index == i][:EACH_ALWAYS]),
    ]


def _begun(stack: FaceStack, coarse: Scene, view: PictureView, match: AffineMatch) -> Fitted:
    """The camera of a match, roughly fitted."""
    at = match.at[0] - 0.5, match.at[1] - 0.5
    return fitted(stack, coarse, camera_of(match.affine, match.pivot, at, view.frame.focal), ROUGH_REACHES)


def _half_fitted(stack: FaceStack, scene: Scene, first: PinholeCamera) -> Fitted:
    """The better of the cameras half fitted from a first guess and from the tilt that foreshortens as it does."""
    starts = [first]
    if first.tilt > EITHER_TILT:
        x, y, roll, size, tilt_x, tilt_y = first.vector()
        starts.append(first.moved((x, y, roll, size, -tilt_x, -tilt_y)))
    return max(
        (fitted(stack, scene, start, FIRST_REACHES) for start in starts),
        key=lambda f: f.agreement + camera_evidence(f.camera, None).score,
    )


def camera_evidence(camera: PinholeCamera, before: PinholeCamera | None, grown: float = 0.0) -> Evidence:
    """What speaks against a camera after that of the photo before, or by itself if that is not known.

    The paper has ``grown`` in the picture by so much, as a natural logarithm: where it has not, photos are cropped to the model, and
    that the camera is nearer says nothing.
    """
    tilted = Evidence(tilt=(camera.tilt / USUAL_TILT) ** 2, steep_tilt=max(0.0, camera.tilt - STEEP))
    if before is None:
        return tilted
    size = float(camera.size - before.size)
    turned = abs((camera.roll - before.roll + pi) % (2 * pi) - pi)
    zoom = max(0.0, size - log(LARGEST_ZOOM), log(SMALLEST_ZOOM) - size)
    nearness = log1p((min(abs(size), abs(grown)) / USUAL_NEARNESS) ** 2)
    return replace(tilted, zoom=zoom, nearness=nearness, roll=roll_evidence(degrees(turned)))


def roll_evidence(angle: float) -> float:
    """The term that says that the camera is turned by so many degrees: large turns count by their logarithm only."""
    return log1p((angle / USUAL_ROLL) ** 2)


SeenFaces = list[tuple[bool, Floats]]
"""Whether each face lies back up, and its corners (n, 2) in picture units."""


def seen_faces(stack: FaceStack, camera: PinholeCamera) -> SeenFaces:
    """Each face as the photo would show it if none hid another: back up, and its corners in picture units."""
    return [
        (back, projected(camera.homography, np.array(outline)))
        for outline, back in zip(stack.outlines, stack.backs, strict=True)
    ]


def same_sight(first: SeenFaces, second: SeenFaces) -> bool:
    """Whether two stacks are one model under other names: the same faces at the same places in the same order."""
    return len(first) == len(second) and all(
        back == other_back and len(points) == len(other) and hausdorff_distance(points, other) < SAME_PLACE
        for (back, points), (other_back, other) in zip(first, second, strict=True)
    )
