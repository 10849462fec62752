"""A mesh as it is audited: faces with their corners in space, joined where they share an edge."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import networkx as nx
import numpy as np

from folding_server.arrays import Floats, Ints
from folding_server.geometry.graph import Edge, edge_of, sides

WELDED = 1e-4
"""Corners nearer than this, in units of the model's extent, are one point: files are written with four digits or more."""
LEAST_NORMAL = 1e-12


@dataclass(frozen=True)
class Mesh:
    """Faces as cycles of indices of vertices.

    ``points`` (n, 3) where the vertices lie. ``sheet`` (n, 2) where they lie on the unfolded sheet, from texture coordinates or
    a crease pattern, None where the file does not say. ``over`` pairs (upper, lower) of faces, None without an order.
    """

    points: Floats
    faces: tuple[tuple[int, ...], ...]
    sheet: Floats | None = None
    over: frozenset[tuple[int, int]] | None = None

    @cached_property
    def extent(self) -> float:
        """The longest side of the bounding box."""
        return float(np.ptp(self.points, axis=0).max())

    @cached_property
    def joints(self) -> Ints:
        """(n,): the number of the point that each vertex is: by place on the sheet if that is known, else in space."""
        places = self.points if self.sheet is None else self.sheet
        return welded_numbers(places, WELDED * float(np.ptp(places, axis=0).max()))

    @cached_property
    def cycles(self) -> tuple[tuple[int, ...], ...]:
        """The faces as cycles of points."""
        return tuple(tuple(int(self.joints[v]) for v in face) for face in self.faces)

    @cached_property
    def beside(self) -> dict[Edge, list[int]]:
        """Each edge between points with the faces beside it."""
        found: dict[Edge, list[int]] = {}
        for index, cycle in enumerate(self.cycles):
            for side in sides(cycle):
                found.setdefault(edge_of(*side), []).append(index)
        return found

    @cached_property
    def components(self) -> list[list[int]]:
        """The faces of each piece, largest first."""
        graph: nx.Graph[int] = nx.Graph()
        graph.add_nodes_from(range(len(self.faces)))
        graph.add_edges_from(pair for pair in self.neighbours())
        return sorted(
            (sorted(part) for part in nx.connected_components(graph)), key=lambda part: (-len(part), part)
        )

    @cached_property
    def normals(self) -> Floats:
        """(f, 3): unit normals (Newell)."""
        return np.array([normal_of(self.points[list(face)]) for face in self.faces]).reshape(-1, 3)

    def neighbours(self) -> Iterator[tuple[int, int]]:
        """The pairs of faces that share an edge."""
        return ((a, b) for faces in self.beside.values() for a, b in pairwise(faces))

    def part(self, faces: Sequence[int]) -> "Mesh":
        """Some of the faces alone."""
        number = {face: index for index, face in enumerate(faces)}
        over = self.over and frozenset(
            (number[a], number[b]) for a, b in self.over if a in number and b in number
        )
        return Mesh(self.points, tuple(self.faces[face] for face in faces), self.sheet, over)


def normal_of(corners: Floats) -> Floats:
    """The unit normal of a polygon (k, 3) by Newell's method; 0 for one without area."""
    after = np.roll(corners, -1, axis=0)
    normal = np.cross(corners, after).sum(axis=0)
    length = np.linalg.norm(normal)
    return np.asarray(normal / length if length > LEAST_NORMAL else np.zeros(3))


def welded_numbers(places: Floats, within: float) -> Ints:
    """(n,): the same number for places that lie within a distance of each other, directly or by way of others."""
    import shapely  # noqa: PLC0415  (slow to load)

    seen = np.array([shapely.Point(place[:2]) for place in places])
    first, second = shapely.STRtree(seen).query(seen, predicate="dwithin", distance=within)
    near = np.abs(places[first] - places[second]).max(axis=1) <= within
    graph: nx.Graph[int] = nx.Graph()
    graph.add_nodes_from(range(len(places)))
    graph.add_edges_from(zip(first[near].tolist(), second[near].tolist(), strict=True))
    numbers = np.zeros(len(places), int)
    for number, part in enumerate(nx.connected_components(graph)):
        numbers[list(part)] = number
    return numbers
