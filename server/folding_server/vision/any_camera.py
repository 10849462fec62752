"""A folded paper against a photo that may come from another camera than the first photo."""

from dataclasses import dataclass, replace

from folding_server.simulator.paper import Paper
from folding_server.vision.comparison import Match, compare
from folding_server.vision.pose_estimation.estimate import PoseEstimate, estimates
from folding_server.vision.pose_estimation.pinhole import only_moved, upright_camera
from folding_server.vision.registration.scene import face_stack
from folding_server.vision.seeing import Observation, SequenceObserver

BETTER_BY = 0.01
"""How much better, in agreement, a paper must fit under a camera of its own for the first photo's to be given up."""


ANOTHER_BELOW = 0.95
"""Agreement below which a photo shows another paper, or, under a camera that stands, this one elsewhere."""


@dataclass(frozen=True)
class PhotoComparison:
    """How a paper agrees with a photo, and by which camera: ``observer`` sees ``seen``; ``estimate`` is that camera if it is
    not the first photo's.
    """

    match: Match
    seen: Observation
    observer: SequenceObserver
    estimate: PoseEstimate | None = None


def compare_with_photo(paper: Paper, observer: SequenceObserver, frame: int) -> PhotoComparison:
    """Compare a paper with a photo under the first photo's camera, and under one fitted to it where that explains too little: where the
    table proves that the camera stands, only where the sheet must have been moved, and by a motion of the sheet.

    PhotoError if there is no such photo.
    """
    seen = observer.frame(frame)
    first = PhotoComparison(compare(paper, seen), seen, observer)
    enough = ANOTHER_BELOW if observer.stands(frame) else 1.0
    if frame == 1 or first.match.verdict == "MATCH" or first.match.agreement > enough:
        return first
    other = _under_own_camera(paper, observer, frame)
    if other is None or other.match.agreement < first.match.agreement + BETTER_BY:
        return first
    return other


def _under_own_camera(paper: Paper, observer: SequenceObserver, frame: int) -> PhotoComparison | None:
    """The comparison under the camera that shows the paper best; None if the photo shows no paper."""
    stack = face_stack(paper)
    found = [
        (view, e)
        for view in observer.pictures(frame)
        for e in estimates([stack], view)[:1]
        if not observer.stands(frame) or only_moved(e.camera, upright_camera(observer.pose, view.frame))
    ]
    if not found:
        return None
    view, estimate = max(found, key=lambda pair: pair[1].value)
    own = observer.under(estimate.camera.pose(view.frame), view, stack.surroundings)
    seen = replace(own.frame(frame), scales=(1.0, 1.0))
    return PhotoComparison(compare(paper, seen), seen, own, estimate)
