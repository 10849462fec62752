"""Whether two folded papers are one model, wherever it lies and whatever its faces are called: no later photo tells them apart."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

from folding_server.arrays import Floats
from folding_server.geometry.point_batch import hausdorff_distance
from folding_server.simulator.paper import Paper

NEARLY_SAME = 0.01
"""Corners that are nearer to each other, in sheet units, are the same: half of what a result may be off to count as exact."""
NEARLY_SAME_REFRAMED = 0.03
"""The same under a camera of its own, which shows no crease more precisely than to half of it; creases that near are put right by
later photos."""
EIGHTH_TURNS = [np.array([[cos(a), -sin(a)], [sin(a), cos(a)]]) for a in (k * pi / 4 for k in range(8))]
"""By multiples of 45 degrees, the first by none."""


@dataclass(frozen=True)
class _Face:
    """A face's corners (n, 2) about the middle of the model, whether its back is up, and how many faces lie below its middle."""

    number: int
    outline: Floats
    back: bool
    below: int

    @property
    def kind(self) -> tuple[bool, int]:
        """What no turn changes: side and layers below. The number of corners says nothing: two may be a hair apart."""
        return self.back, self.below


@dataclass(frozen=True)
class _Model:
    """The faces of a paper, bottom to top, and for each two that a crease joins its middle; about the mean of all corners."""

    faces: tuple[_Face, ...]
    joints: dict[frozenset[int], Floats]

    @classmethod
    def of(cls, paper: Paper) -> "_Model":
        """What is compared of a paper."""
        corners = [np.array(paper.polygon(face)) for face in paper.order]
        middle = np.concatenate(corners).mean(axis=0)
        outlines = [corners_of - middle for corners_of in corners]
        middles = [outline.mean(axis=0) for outline in outlines]
        faces = tuple(
            _Face(
                face,
                outline,
                paper.back_up(face),
                sum(_covers(other, middles[rank]) for other in outlines[:rank]),
            )
            for rank, (face, outline) in enumerate(zip(paper.order, outlines, strict=True))
        )
        lie = paper.folded_vertices_coords
        joints = {
            frozenset(pair): (np.array(lie[u]) + lie[v]) / 2 - middle
            for (u, v), pair in paper.edge_faces.items()
            if len(pair) == 2
        }
        return cls(faces, joints)


def same_model(first: Paper, second: Paper, *, turned: bool = False) -> bool:
    """Whether each face of one lies as one of the other does: the same corners, the same side up, as many layers below, joined to the
    same others. A model that is ``turned`` by multiples of 45 degrees is the same to a camera that may be anywhere.
    """
    if len(first.faces) != len(second.faces):
        return False
    near = NEARLY_SAME_REFRAMED if turned else NEARLY_SAME
    one, other = _Model.of(first), _Model.of(second)
    if sorted(face.kind for face in one.faces) != sorted(face.kind for face in other.faces):
        return False
    return any(_alike(one, other, turn, near) for turn in (EIGHTH_TURNS if turned else EIGHTH_TURNS[:1]))


def _alike(one: _Model, other: _Model, turn: Floats, near: float) -> bool:
    """Whether one model, turned by a matrix (2, 2), is the other: each face has its twin, joined to the same others at the same places."""
    twins = _twins(one.faces, other.faces, turn, near)
    if twins is None:
        return False
    places = {frozenset(twins[face] for face in pair): turn @ place for pair, place in one.joints.items()}
    return places.keys() == other.joints.keys() and all(
        float(np.linalg.norm(place - other.joints[pair])) < near for pair, place in places.items()
    )


def _twins(
    faces: Sequence[_Face], others: Sequence[_Face], turn: Floats, near: float
) -> dict[int, int] | None:
    """For each face its twin among the others, its corners that ``near`` once it is turned by a matrix (2, 2); None if one has none."""
    left, twins = list(others), dict[int, int]()
    for face in faces:
        outline = face.outline @ turn.T
        twin = next(
            (
                i
                for i, other in enumerate(left)
                if face.kind == other.kind and hausdorff_distance(outline, other.outline) < near
            ),
            None,
        )
        if twin is None:
            return None
        twins[face.number] = left.pop(twin).number
    return twins


def _covers(outline: Floats, place: Floats) -> bool:
    """Whether a convex outline has a place inside."""
    edges = np.roll(outline, -1, axis=0) - outline
    sides = edges[:, 0] * (place[1] - outline[:, 1]) - edges[:, 1] * (place[0] - outline[:, 0])
    return bool((sides > 0).all() or (sides < 0).all())
