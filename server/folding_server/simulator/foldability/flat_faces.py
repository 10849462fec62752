"""Laying the faces of a crease pattern flat: where each goes when every crease is folded, and whether that closes up."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from heapq import heapify, heappop, heappush

import numpy as np
from numpy.typing import NDArray

from folding_server.geometry.planar import edge_faces
from folding_server.simulator.foldability.pattern import Assignment, CreasePattern

Floats = NDArray[np.float64]
Edge = tuple[int, int]

FOLDED = frozenset("MVU")
"""Letters of creases that are folded: a crease without a direction is folded one way or the other."""


@dataclass(frozen=True)
class Crease:
    """An edge between two faces, ``left`` of u -> v on the sheet and ``right`` of it."""

    edge: Edge
    assignment: Assignment
    left: int
    right: int

    @property
    def folded(self) -> bool:
        """Whether the two faces lie on top of each other at this crease."""
        return self.assignment in FOLDED


@dataclass(frozen=True)
class FlatFaces:
    """The faces of a pattern laid flat, lengths in units of the sheet's longer side.

    ``outlines`` gives each face's corners (k, 2) after folding, ``mirrored`` whether its back is up, ``spread`` how far
    faces disagree on a vertex at most, ``worst`` the vertex where they do; ``odd`` a vertex of a face that is reached
    with both sides up, or None; ``walk`` the faces in the order they were reached, each beside one before; ``loose`` a face that no crease
    joins to the first, or None.
    """

    pattern: CreasePattern
    creases: Sequence[Crease]
    outlines: Sequence[Floats]
    mirrored: Sequence[bool]
    spread: float
    worst: int
    odd: int | None
    walk: Sequence[int]
    loose: int | None

    @cached_property
    def segments(self) -> Floats:
        """(m, 2, 2): where each crease lies, read off the face left of it."""
        cycles = self.pattern.cycles
        rows = [self.outlines[c.left][[cycles[c.left].index(v) for v in c.edge]] for c in self.creases]
        return np.array(rows, float).reshape(-1, 2, 2)

    @cached_property
    def sides(self) -> NDArray[np.int_]:
        """(m, 2): on which side of its folded segment each of a crease's faces lies, 1 left and -1 right of it."""
        return np.array(
            [[-1 if self.mirrored[c.left] else 1, 1 if self.mirrored[c.right] else -1] for c in self.creases],
            int,
        ).reshape(-1, 2)


def creases_of(pattern: CreasePattern) -> list[Crease]:
    """The edges that join two faces; a boundary edge between two is a cut and joins nothing."""
    beside = edge_faces(pattern.cycles)
    leaves = {
        (u, v): face
        for face, cycle in enumerate(pattern.cycles)
        for u, v in zip(cycle, (*cycle[1:], cycle[0]), strict=True)
    }
    found = []
    for (u, v), assignment in zip(pattern.edges, pattern.edges_assignment, strict=True):
        joins = len(set(beside.get((min(u, v), max(u, v)), ()))) == 2 and assignment != "B"
        if joins and (u, v) in leaves and (v, u) in leaves:
            found.append(Crease((u, v), assignment, leaves[u, v], leaves[v, u]))
    return found


def lay_flat(pattern: CreasePattern) -> FlatFaces:
    """Fold every crease flat, walking from face to face out of the first, which keeps its place front up."""
    points = np.array(pattern.vertices, float)
    points = (points - points.min(axis=0)) / max(float(np.ptp(points, axis=0).max()), 1e-300)
    creases = creases_of(pattern)
    reached, odd = _motions(points, len(pattern.cycles), creases)
    loose = next((face for face in range(len(pattern.cycles)) if face not in reached), None)
    motions = [reached.get(face, np.eye(2, 3)) for face in range(len(pattern.cycles))]
    outlines = [
        points[list(cycle)] @ m[:, :2].T + m[:, 2] for cycle, m in zip(pattern.cycles, motions, strict=True)
    ]
    spread, worst = _spread(pattern, outlines)
    mirrored = [bool(np.linalg.det(m[:, :2]) < 0) for m in motions]
    return FlatFaces(pattern, creases, outlines, mirrored, spread, worst, odd, list(reached), loose)


def _motions(points: Floats, faces: int, creases: Sequence[Crease]) -> tuple[dict[int, Floats], int | None]:
    """The motion (2, 3) of every face that is reached, and a vertex at which the two ways round give a face different
    sides. Long creases are crossed first: a short one says little about the direction it lies in.
    """
    beside: Mapping[int, list[tuple[float, int, int]]] = {face: [] for face in range(faces)}
    for k, crease in enumerate(creases):
        p, q = points[list(crease.edge)]
        length = float(np.hypot(*(q - p)))
        beside[crease.left].append((-length, k, crease.right))
        beside[crease.right].append((-length, k, crease.left))
    motions: dict[int, Floats] = {0: np.eye(2, 3)}
    parity, waiting = {0: False}, [(rank, k, 0, other) for rank, k, other in beside[0]]
    heapify(waiting)
    while waiting:
        _, k, face, other = heappop(waiting)
        if other not in motions:
            motions[other] = _over(motions[face], points, creases[k])
            parity[other] = parity[face] != creases[k].folded
            for rank, further, beyond in beside[other]:
                heappush(waiting, (rank, further, other, beyond))
    odd = (c.edge[0] for c in creases if c.left in parity and (parity[c.left] != parity[c.right]) != c.folded)
    return motions, next(odd, None)


def _over(motion: Floats, points: Floats, crease: Crease) -> Floats:
    """The motion of the face on the other side of a crease."""
    if not crease.folded:
        return motion
    p, q = points[list(crease.edge)]
    normal = np.array([p[1] - q[1], q[0] - p[0]]) / np.hypot(*(q - p))
    flip = np.eye(2) - 2 * np.outer(normal, normal)
    shift = 2 * (normal @ p) * normal
    turned = motion[:, :2] @ flip
    return np.column_stack([turned, motion[:, :2] @ shift + motion[:, 2]])


def _spread(pattern: CreasePattern, outlines: Sequence[Floats]) -> tuple[float, int]:
    """How far the faces disagree on a vertex at most, and on which."""
    corners = np.concatenate(outlines)
    owner = np.concatenate([np.array(cycle) for cycle in pattern.cycles])
    low = np.full((len(pattern.vertices), 2), np.inf)
    high = -low
    np.minimum.at(low, owner, corners)
    np.maximum.at(high, owner, corners)
    gap = np.where(np.isfinite(low[:, 0]), np.hypot(*(high - low).T), 0.0)
    return float(gap.max()), int(gap.argmax())
