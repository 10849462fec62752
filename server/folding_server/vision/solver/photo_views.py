"""Photos as the solver's views of them: two resolutions, cut out around the paper."""

from dataclasses import dataclass, replace
from math import ceil, floor

import cv2
import numpy as np

from folding_server.arrays import Floats
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.grid import Grid
from folding_server.vision.labels import is_paper
from folding_server.vision.pose_estimation.estimate import PoseEstimate, estimates
from folding_server.vision.pose_estimation.picture_view import PictureView
from folding_server.vision.pose_estimation.pinhole import PinholeCamera, upright_camera
from folding_server.vision.registration.alignment import Freedom, align
from folding_server.vision.registration.scene import FaceStack, Scene, Views, face_stack
from folding_server.vision.seeing import Observation, SequenceObserver
from folding_server.vision.solver.inner_edges import USUAL_SIGHT, sight
from folding_server.vision.solver.sheet_motions import locate

COARSE, FINE = 64.0, 160.0
"""Pixels per sheet unit for searching and for refining."""
SEARCH_MARGIN = 0.2
"""How far around the paper to look, in sheet units."""


@dataclass(frozen=True)
class SeenBefore:
    """Where the sheet lay in the photo before a frame under the first photo's camera, with what agreement, and that photo."""

    frame: int
    motion: Similarity
    agreement: float
    coarse: Observation
    fine: Scene


def likeliest_view(
    stack: FaceStack, observer: SequenceObserver, frame: int
) -> tuple[PictureView, PoseEstimate] | None:
    """The piece of a photo that shows a stack best, and the camera under which it does; None if the photo shows no paper.

    Of the cameras that a symmetrical stack allows, the one that is turned least against the first photo's.
    """
    found = [
        (view, estimate)
        for view in observer.pictures(frame)
        for estimate in estimates([stack], view, upright_camera(observer.pose, view.frame))[:1]
    ]
    return max(found, key=lambda pair: pair[1].value, default=None)


def seen_before(paper: Paper, observer: SequenceObserver, frame: int) -> SeenBefore:
    """A paper in the photo before a frame, which it is known to explain."""
    earlier = max(1, frame - 1)
    coarse = observer.frame(earlier, COARSE)
    found = locate(paper, Scene(coarse.grid, coarse.labels, coarse.two_coloured)).motion
    fine = _scene(observer.frame(earlier, FINE), coarse)
    settled = align(face_stack(paper), fine, found, Freedom(shift=0.01, turn=1.0, scale=0.01))
    return SeenBefore(frame, settled.motion, settled.agreement, coarse, fine)


def views_after(paper: Paper, observer: SequenceObserver, known: SeenBefore) -> Views:
    """The photo of a frame under the first photo's camera, with what the photo before says of it."""
    frame, before = known.frame, known.coarse
    after = observer.frame(frame, COARSE)
    fine = replace(_scene(observer.frame(frame, FINE), before), sight=sight(paper, known.fine, known.motion))
    handheld = after.scales[0] != after.scales[1]

    def closely() -> tuple[Scene, Scene]:
        """Both photos at their finest."""
        earlier, later = observer.closely(max(1, frame - 1)), observer.closely(frame)
        return _scene(earlier, before, lit=True), _scene(later, before, lit=True)

    return Views(_scene(after, before), fine, handheld, known.agreement, closely)


def views_under(
    camera: PinholeCamera,
    view: PictureView,
    stack: FaceStack,
    observer: SequenceObserver,
    frame: int,
    expected: float,
) -> Views:
    """A photo as a camera of its own shows it, about where a stack lies; ``expected`` is the agreement to hope for."""
    own = observer.under(camera.pose(view.frame), view, stack.surroundings)
    coarse, fine = own.frame(frame, COARSE), own.frame(frame, FINE)
    scene = replace(_scene(fine, coarse), sight=USUAL_SIGHT)
    return Views(_scene(coarse, coarse), scene, handheld=True, expected=expected, own_camera=True)


def _scene(seen: Observation, before: Observation, *, lit: bool = False) -> Scene:
    """The part of a photo around its paper and that of the photo before; ``lit`` with its lightness."""
    corners = [*_paper_corners(before), *_paper_corners(seen)]
    if not corners:
        return Scene(seen.grid, seen.labels, seen.two_coloured)
    points = np.concatenate(corners)
    return _cropped(seen, points.min(axis=0) - SEARCH_MARGIN, points.max(axis=0) + SEARCH_MARGIN, lit=lit)


def _paper_corners(seen: Observation) -> list[Floats]:
    """Two opposite corners of the box around the paper in the plane, (2, 2); nothing if there is no paper."""
    rows, cols = np.nonzero(is_paper(seen.labels))
    return [seen.grid.to_plane([(cols.min(), rows.min()), (cols.max(), rows.max())])] if len(rows) else []


def _cropped(seen: Observation, low: Floats, high: Floats, *, lit: bool) -> Scene:
    """A window of a seen frame, given its lower left and upper right in the plane."""
    grid, s = seen.grid, seen.grid.pixels_per_unit
    left, right = max(0, floor((low[0] - grid.left) * s)), min(grid.cols, ceil((high[0] - grid.left) * s))
    upper, lower = max(0, floor((grid.top - high[1]) * s)), min(grid.rows, ceil((grid.top - low[1]) * s))
    window_rows = (slice(upper, lower), slice(left, right))
    window = Grid(grid.left + left / s, grid.top - upper / s, s, lower - upper, right - left)
    return Scene(
        window,
        np.ascontiguousarray(seen.labels[window_rows]),
        seen.two_coloured,
        seen.edges[window_rows],
        light=cv2.cvtColor(seen.rgb[window_rows], cv2.COLOR_RGB2LAB)[..., 0].astype(np.float32)
        if lit
        else None,
        sheet_lines=seen.sheet_lines,
        shaded=seen.shaded,
    )
