"""Laying the faces of a crease pattern flat: where each goes when every crease is folded, and whether that closes up."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from folding_server.arrays import Floats, Ints
from folding_server.geometry.isometry import IDENTITY, Isometry
from folding_server.simulator.foldability.face_walk import SharedEdge, faces_isometries
from folding_server.simulator.foldability.pattern import CreasePattern, PatternCrease


@dataclass(frozen=True)
class FlatFaces:
    """The faces of a pattern laid flat, lengths in units of the sheet's longer side.

    ``outlines`` gives each face's corners (k, 2) after folding, ``mirrored`` whether its back is up, ``spread`` how far
    faces disagree on a vertex at most, ``worst`` the vertex where they do; ``odd`` a vertex of a face that is reached
    with both sides up, or None; ``loose`` the faces
    that no crease joins to the first.
    """

    pattern: CreasePattern
    creases: Sequence[PatternCrease]
    outlines: Sequence[Floats]
    mirrored: Sequence[bool]
    spread: float
    worst: int
    odd: int | None
    loose: Sequence[int]

    @cached_property
    def segments(self) -> Floats:
        """(m, 2, 2): where each crease lies, read off the face left of it."""
        cycles = self.pattern.cycles
        rows = [self.outlines[c.left][[cycles[c.left].index(v) for v in c.edge]] for c in self.creases]
        return np.array(rows, float).reshape(-1, 2, 2)

    @cached_property
    def sides(self) -> Ints:
        """(m, 2): on which side of its folded segment each of a crease's faces lies, 1 left and -1 right of it."""
        return np.array(
            [[-1 if self.mirrored[c.left] else 1, 1 if self.mirrored[c.right] else -1] for c in self.creases],
            int,
        ).reshape(-1, 2)


def lay_flat(pattern: CreasePattern) -> FlatFaces:
    """Fold every crease flat, walking from face to face out of the first, which keeps its place front up."""
    points = np.array(pattern.vertices_coords, float)
    points = (points - points.min(axis=0)) / max(float(np.ptp(points, axis=0).max()), 1e-300)
    creases = pattern.creases
    isometries = faces_isometries(
        points.tolist(), [SharedEdge(c.edge, (c.left, c.right), c.folded) for c in creases]
    )
    faces = range(len(pattern.cycles))
    lying = [isometries.get(face, IDENTITY) for face in faces]
    outlines = [
        _outline(points[list(cycle)], isometry) for cycle, isometry in zip(pattern.cycles, lying, strict=True)
    ]
    spread, worst = _spread(pattern, outlines)
    return FlatFaces(
        pattern,
        creases,
        outlines,
        [isometry.mirrors for isometry in lying],
        spread,
        worst,
        _odd_vertex(creases, isometries),
        [face for face in faces if face not in isometries],
    )


def _outline(corners: Floats, isometry: Isometry) -> Floats:
    """Where the corners (k, 2) of a face go."""
    rows = np.array(isometry.rows[:2])
    return np.asarray(corners @ rows[:, :2].T + rows[:, 2])


def _odd_vertex(creases: Sequence[PatternCrease], isometries: Mapping[int, Isometry]) -> int | None:
    """A vertex at which the two ways round give a face different sides; None if there is none."""
    return next(
        (
            crease.edge[0]
            for crease in creases
            if crease.left in isometries
            and (isometries[crease.left].mirrors != isometries[crease.right].mirrors) != crease.folded
        ),
        None,
    )


def _spread(pattern: CreasePattern, outlines: Sequence[Floats]) -> tuple[float, int]:
    """How far the faces disagree on a vertex at most, and on which."""
    corners = np.concatenate(outlines)
    owner = np.concatenate([np.array(cycle) for cycle in pattern.cycles])
    low = np.full((len(pattern.vertices_coords), 2), np.inf)
    high = -low
    np.minimum.at(low, owner, corners)
    np.maximum.at(high, owner, corners)
    gap = np.where(np.isfinite(low[:, 0]), np.hypot(*(high - low).T), 0.0)
    return float(gap.max()), int(gap.argmax())
