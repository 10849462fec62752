"""The folded sheet as plain arrays, made from the record alone, and the tolerances the validators allow."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from folding_server.arrays import Floats
from folding_server.simulator.paper import Paper

EdgeKey = tuple[int, int]

EXACT = 1e-9
"""Rounding allowed where the sheet itself is measured (lengths in sheet units, areas in their squares)."""

SLACK = 5e-4
"""Five times the simulator's tolerance, in sheet units: how far two faces may disagree on a shared vertex, and how far
layers may reach into each other. A fold through a vertex that lies a tolerance off its line moves it two tolerances
away from its neighbours, and a later fold through the same place adds as much again."""


TILT = 2e-4
"""How far, in sheet units, a crease may lie off the line it was folded along: both its ends by the tolerance."""


@dataclass(frozen=True)
class Measured:
    """A paper measured without the simulator's own geometry.

    ``flat`` and ``folded`` give each face's outline (n, 2) on the sheet and where it lies; ``mirrored`` whether the
    face lies back up; ``rank`` its index in the stack; ``edges`` the faces beside each edge, smaller vertex id first.
    """

    paper: Paper
    flat: Mapping[int, Floats]
    folded: Mapping[int, Floats]
    mirrored: Mapping[int, bool]
    edges: Mapping[EdgeKey, tuple[int, ...]]

    @cached_property
    def rank(self) -> dict[int, int]:
        """Face -> index in the stack, 0 at the bottom."""
        return {face: index for index, face in enumerate(self.paper.order)}

    @cached_property
    def inner(self) -> list[EdgeKey]:
        """The edges between two faces."""
        return [edge for edge, beside in self.edges.items() if len(beside) == 2]

    @cached_property
    def corners(self) -> dict[int, list[tuple[int, int]]]:
        """Vertex -> (face, index in its cycle) for every face that has it."""
        found: dict[int, list[tuple[int, int]]] = {}
        for face, cycle in self.paper.faces.items():
            for index, vertex in enumerate(cycle):
                found.setdefault(vertex, []).append((face, index))
        return found

    def turned(self, edge: EdgeKey) -> bool:
        """Whether an inner edge is folded: its two faces show different sides."""
        first, second = self.edges[edge]
        return self.mirrored[first] != self.mirrored[second]

    def segment(self, edge: EdgeKey, face: int) -> Floats:
        """Where an edge lies now, (2, 2), read off one face beside it."""
        cycle = self.paper.faces[face]
        return self.folded[face][[cycle.index(edge[0]), cycle.index(edge[1])]]


def measure(paper: Paper) -> Measured:
    """The arrays of a paper whose record is sound (see ``sheet.record_violations``)."""
    flat = {f: np.array([paper.vertices_coords[v] for v in cycle], float) for f, cycle in paper.faces.items()}
    folded = {f: moved_points(flat[f], tuple(paper.isometries[f])) for f in paper.faces}
    mirrored = {f: determinant(tuple(paper.isometries[f])) < 0 for f in paper.faces}
    return Measured(paper, flat, folded, mirrored, beside_edges(paper.faces))


def beside_edges(faces: Mapping[int, tuple[int, ...]]) -> dict[EdgeKey, tuple[int, ...]]:
    """Edge -> the faces that have it on their boundary."""
    beside: dict[EdgeKey, list[int]] = {}
    for face, cycle in faces.items():
        for u, v in zip(cycle, (*cycle[1:], cycle[0]), strict=True):
            beside.setdefault((min(u, v), max(u, v)), []).append(face)
    return {edge: tuple(found) for edge, found in beside.items()}


def moved_points(points: Floats, motion: tuple[float, ...]) -> Floats:
    """Points (n, 2) after (x, y) -> (a x + b y + e, c x + d y + f)."""
    a, b, c, d, e, f = motion
    moved: Floats = points @ np.array([[a, c], [b, d]]) + np.array([e, f])
    return moved


def determinant(motion: tuple[float, ...]) -> float:
    """1 for a rotation, -1 for a reflection."""
    return motion[0] * motion[3] - motion[1] * motion[2]


def signed_area(outline: Floats) -> float:
    """Area of an outline (n, 2), positive if it runs counter-clockwise."""
    x, y = outline.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
