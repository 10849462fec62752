"""A camera and the crease of a fold fitted to a photo together: alone, a camera would tilt to make up for a crease that is a little off."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from folding_server.vision.pose_estimation.border_fitting import (
    LAST_REACHES,
    Fitted,
    drawn,
    fitted,
    least_squares_step,
    matched_borders,
    paper_extent,
)
from folding_server.vision.pose_estimation.pinhole import PinholeCamera
from folding_server.vision.registration.edge_matching import class_maps
from folding_server.vision.registration.scene import FaceStack, Scene

SCANS, SCAN_STEPS = (0.1, 0.025), 3
"""How far either end of a crease is moved to both sides to see which places the outline leaves open, in sheet units: first from where
it was tried, then about the best place; and in how many steps.
"""
SCAN_REACHES = (0.06, 0.03, 0.02)
"""As REACHES, for each place that is tried."""
LEFT_OPEN = 0.012
"""Shares of the paper by which a place may agree less than the best: the outline of a sheet has few corners, and a camera that is
free makes up for most of what a crease does to them.
"""
REACHES = (0.06, 0.04, *LAST_REACHES)
"""How far, in shares of the paper's extent, points look along their normals in each round."""
CREASE_MOVES = 0.03
"""Standard deviation, in sheet units, of how far the ends of a crease lie beside the line that was tried: such lines lie half as far
apart.
"""
SLOPE_STEP = 1.5
"""Pixels by which an end is moved for the slope: enough for borders to move, little enough to be straight."""

Ends = tuple[float, float]
FoldedStack = Callable[[Ends], FaceStack]
"""A stack after a fold, the two ends of its crease moved along the normal by so many sheet units."""


@dataclass(frozen=True)
class CreaseFit:
    """Where the ends of the crease are, and the camera."""

    ends: Ends
    fitted: Fitted


def fitted_with_crease(folded: FoldedStack, scene: Scene, camera: PinholeCamera) -> CreaseFit:
    """The crease and the camera near a first guess under which the borders of the folded stack lie on those of the photo."""
    extent = paper_extent(scene)
    seen = list(class_maps(scene.labels, scene.known))
    delta = SLOPE_STEP / (scene.grid.pixels_per_unit * np.exp(camera.size))
    ends = (0.0, 0.0)
    labels = drawn(folded(ends), camera, scene)
    best = CreaseFit(ends, Fitted(camera, scene.agreement_of(labels)))
    priors = np.full(2, CREASE_MOVES**-2)
    for share in REACHES:
        matches = matched_borders(labels, scene, seen, share * extent)
        if matches is None:
            break
        moved = [(ends[0] + delta, ends[1]), (ends[0], ends[1] + delta)]
        slopes = [matches.moved(drawn(folded(other), camera, scene)) / delta for other in moved]
        camera, change = least_squares_step(
            camera, matches, share * extent, extent, np.column_stack(slopes), priors
        )
        ends = ends[0] + float(change[0]), ends[1] + float(change[1])
        labels = drawn(folded(ends), camera, scene)
        agreement = scene.agreement_of(labels)
        if agreement > best.fitted.agreement:
            best = replace(best, ends=ends, fitted=Fitted(camera, agreement))
    return best


def left_open(folded: FoldedStack, scene: Scene, start: CreaseFit, reach: float) -> list[CreaseFit]:
    """The places of a crease, up to so far from a first one, that the outline of the paper hardly tells apart, each with its camera."""
    amounts = np.linspace(-reach, reach, 2 * SCAN_STEPS + 1).tolist()
    first, second = start.ends
    places = [(first + one, second + other) for one, other in product(amounts, amounts)]
    camera = start.fitted.camera
    found = [CreaseFit(ends, fitted(folded(ends), scene, camera, SCAN_REACHES)) for ends in places]
    least = max(fit.fitted.agreement for fit in found) - LEFT_OPEN
    return [fit for fit in found if fit.fitted.agreement >= least]
