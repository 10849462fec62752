"""Where the unmoved part of the sheet may lie in a photo: the motions from which folds are looked for."""

from collections.abc import Sequence
from math import dist

from folding_server.geometry.isometry import IDENTITY
from folding_server.geometry.line import Point
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.registration.alignment import Aligned, Freedom, align
from folding_server.vision.registration.chamfer_matching import DriftRange, drifts
from folding_server.vision.registration.edge_icp import snapped_to_edges
from folding_server.vision.registration.scene import Scene, Views, face_stack
from folding_server.vision.solver.whole_moves import best_turns, centered

LOCATED = 0.96
"""A paper that explains its photo less well where it was last put is looked for at all angles."""
SAME_DRIFT = 0.008
"""Motions that differ by less (sheet units) are tried once."""


def locate(paper: Paper, scene: Scene) -> Aligned:
    """The motion under which a paper explains the photo it was made from, and how well it does."""
    stack = face_stack(paper)
    freedom = Freedom(shift=0.04, turn=4.0, scale=0.04, halvings=5)
    starts = (IDENTITY, centered(stack, scene))
    best = max((align(stack, scene, start, freedom) for start in starts), key=lambda a: a.agreement)
    if best.agreement < LOCATED:
        best = max((best, *best_turns(stack, scene)), key=lambda a: a.agreement)
    return best


def likely_motions(
    paper: Paper, last: Similarity, views: Views, ranges: Sequence[DriftRange] = (DriftRange(),)
) -> list[Similarity]:
    """Motions under which what has not moved may be found: near the last, and with the most edges in common."""
    stack = face_stack(paper)
    found = [last, *(motion for reach in ranges for motion in drifts(stack, views.coarse, last, reach))]
    kept: list[Similarity] = []
    for motion in [*(snapped_to_edges(stack, views.fine, m) for m in found), last]:
        if all(_apart(motion, other, stack.center) > SAME_DRIFT for other in kept):
            kept.append(motion)
    return kept


def _apart(first: Similarity, second: Similarity, center: Point) -> float:
    """How far apart two motions put the middle of the paper and points half a sheet beside it, at most."""
    x, y = center
    return max(dist(first(p), second(p)) for p in (center, (x + 0.5, y), (x, y + 0.5)))
