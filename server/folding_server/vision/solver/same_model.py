"""Whether two folded papers are one model, wherever it lies and whatever its faces are called: no later photo tells them apart."""

import numpy as np

from folding_server.arrays import Floats
from folding_server.geometry.point_batch import hausdorff_distance
from folding_server.simulator.paper import Paper

NEARLY_SAME = 0.01
"""Corners that are nearer to each other, in sheet units, are the same: half of what a result may be off to count as exact."""


def same_model(first: Paper, second: Paper) -> bool:
    """Whether each face of one lies as one of the other does: the same corners, the same side up, as many layers below."""
    if len(first.faces) != len(second.faces):
        return False
    others = _lying(second)
    for outline, back, below in _lying(first):
        twin = next(
            (
                i
                for i, (other, other_back, other_below) in enumerate(others)
                if (back, below, len(outline)) == (other_back, other_below, len(other))
                and hausdorff_distance(outline, other) < NEARLY_SAME
            ),
            None,
        )
        if twin is None:
            return False
        del others[twin]
    return True


def _lying(paper: Paper) -> list[tuple[Floats, bool, int]]:
    """Each face's corners (n, 2) about the middle of the model, whether its back is up, and how many faces lie below its middle."""
    corners = np.array(list(paper.folded_vertices_coords.values()))
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    outlines = [np.array(paper.polygon(face)) - middle for face in paper.order]
    middles = [outline.mean(axis=0) for outline in outlines]
    return [
        (outline, paper.back_up(face), sum(_covers(other, middles[rank]) for other in outlines[:rank]))
        for rank, (face, outline) in enumerate(zip(paper.order, outlines, strict=True))
    ]


def _covers(outline: Floats, place: Floats) -> bool:
    """Whether a convex outline has a place inside."""
    edges = np.roll(outline, -1, axis=0) - outline
    sides = edges[:, 0] * (place[1] - outline[:, 1]) - edges[:, 1] * (place[0] - outline[:, 0])
    return bool((sides > 0).all() or (sides < 0).all())
