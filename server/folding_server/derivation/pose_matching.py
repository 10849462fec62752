"""Whether a paper is a given state up to where the model lies, and the motion that takes it there."""

from math import hypot

import numpy as np

from folding_server.arrays import Floats
from folding_server.derivation.given_states import NEAR, ROUNDING, GivenState
from folding_server.geometry.convex import area
from folding_server.geometry.isometry import Isometry
from folding_server.geometry.line import Point
from folding_server.simulator import Paper

POSED_WITHIN = 2 * NEAR
"""Sheet units that a corner may lie off: where a face lies is fitted to rounded corners, and small faces lie far from the fit."""


def origins_of(given: GivenState, paper: Paper) -> list[int] | None:
    """For each given face the face of the paper that it is a part of; None if one is not within a single face."""
    faces = list(paper.faces)
    beyond = np.array([_outside(np.array(paper.sheet_polygon(face)), given.probes) for face in faces])
    count = len(given.outlines)
    nearest = beyond[:, :count].argmin(axis=0)
    if (beyond[nearest[given.corner_faces], np.arange(count, beyond.shape[1])] > NEAR).any():
        return None
    return [faces[index] for index in nearest]


def pose_between(paper: Paper, given: GivenState) -> Isometry | None:
    """The motion of the plane that makes a paper the given state; None if none does.

    The faces are the same, lie alike to each other, and their layers are in the same order, reversed if the model is turned
    over.
    """
    origins = origins_of(given, paper)
    if origins is None or len(set(origins)) < len(origins) or not _only_slivers(paper, set(origins)):
        return None
    pose = given.motions[given.largest].after(paper.isometries[origins[given.largest]].inverse())
    for outline, motion, face in zip(given.outlines, given.motions, origins, strict=True):
        moved = pose.after(paper.isometries[face])
        if moved.mirrors != motion.mirrors or _apart(moved, motion, outline) > POSED_WITHIN:
            return None
    for upper, lower in given.over:
        above = paper.rank[origins[upper]] > paper.rank[origins[lower]]
        if above == pose.mirrors:
            return None
    return pose


def spare_vertices(given: GivenState, paper: Paper) -> int:
    """How many vertices of a paper the given state has not, or has only once where the paper has two."""
    places = np.array(list(paper.vertices_coords.values()))
    apart = np.hypot(*(places[:, None] - given.vertices[None, :]).transpose(2, 0, 1))
    found = apart.argmin(axis=1)[apart.min(axis=1) <= NEAR]
    return len(places) - len(np.unique(found))


def _only_slivers(paper: Paper, known: set[int]) -> bool:
    """Whether all other faces are so thin that a state with three decimals may lack them."""
    return all(_width(paper.sheet_polygon(face)) <= NEAR for face in paper.faces if face not in known)


def _width(outline: list[Point]) -> float:
    """Area by longest side: the width of a sliver."""
    longest = max(
        hypot(p[0] - q[0], p[1] - q[1]) for p, q in zip(outline, (*outline[1:], outline[0]), strict=True)
    )
    return abs(area(outline)) / longest


def is_still(pose: Isometry, paper: Paper) -> bool:
    """Whether a motion leaves every vertex of a paper where it is, as far as rounding tells."""
    return not pose.mirrors and all(
        hypot(pose(p)[0] - p[0], pose(p)[1] - p[1]) <= POSED_WITHIN
        for p in paper.folded_vertices_coords.values()
    )


def _outside(outline: Floats, points: Floats) -> Floats:
    """(n,): how far points (n, 2) are outside a convex outline (k, 2), negative inside."""
    run = np.roll(outline, -1, axis=0) - outline
    turn = np.sign(outline[:, 0] @ np.roll(outline[:, 1], -1) - outline[:, 1] @ np.roll(outline[:, 0], -1))
    normals = (
        np.stack([run[:, 1], -run[:, 0]], axis=1)
        * turn
        / np.maximum(np.hypot(*run.T), ROUNDING / 100)[:, None]
    )
    return np.asarray((points @ normals.T - (outline * normals).sum(axis=1)).max(axis=1))


def _apart(first: Isometry, second: Isometry, outline: list[Point]) -> float:
    """How far two motions put a corner apart at most."""
    pairs = ((first(p), second(p)) for p in outline)
    return max(hypot(p[0] - q[0], p[1] - q[1]) for p, q in pairs)
