"""Laying the faces of a mesh side by side in the plane, and how far they are from being one rigid sheet."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import networkx as nx
import numpy as np

from folding_server.arrays import Floats
from folding_server.audit.mesh_record import Mesh, normal_of
from folding_server.geometry.graph import edge_of, sides

SQUARE_WITHIN = 1e-2
"""Share of the side by which an unfolded sheet may be off a square, and of its area that may be missing or covered twice."""


@dataclass(frozen=True)
class UnfoldedMesh:
    """A mesh in the plane.

    ``places`` (p, 2) of each point, in units of the side of the square that has the area of the sheet; ``stretch`` by how much a
    distance within a face differs from that in space at most, in the same unit; ``apart`` by how much faces disagree on a point.
    """

    places: Floats
    stretch: float
    apart: float


def unfolded_mesh(mesh: Mesh) -> UnfoldedMesh:
    """One piece of a mesh in the plane: by the places on the sheet that the file gives, else by unfolding face by face."""
    return _unwound(mesh) if mesh.sheet is None else _by_sheet(mesh, mesh.sheet)


def _by_sheet(mesh: Mesh, sheet: Floats) -> UnfoldedMesh:
    places = np.zeros((int(mesh.joints.max()) + 1, 2))
    places[mesh.joints] = sheet
    flat = np.concatenate([_distances(sheet[list(face)]) for face in mesh.faces])
    lying = np.concatenate([_distances(mesh.points[list(face)]) for face in mesh.faces])
    side = _side(places, mesh)
    scale = float(np.median(flat[flat > 0] / np.maximum(lying[flat > 0], 1e-12)))
    return UnfoldedMesh(places / side, float(np.abs(flat - lying * scale).max()) / side, 0.0)


def _unwound(mesh: Mesh) -> UnfoldedMesh:
    """Walk from face to face, each turned into the plane of the one before."""
    flat = [_flattened(mesh.points[list(face)]) for face in mesh.faces]
    laid = {0: flat[0]}
    graph: nx.Graph[int] = nx.Graph(list(mesh.neighbours()))
    graph.add_node(0)
    for before, face in nx.bfs_edges(graph, 0):
        laid[face] = _beside(mesh, before, laid[before], face, flat[face])
    count = int(mesh.joints.max()) + 1
    sums, counts = np.zeros((count, 2)), np.zeros(count)
    for face, outline in laid.items():
        np.add.at(sums, list(mesh.cycles[face]), outline)
        np.add.at(counts, list(mesh.cycles[face]), 1)
    places = sums / np.maximum(counts, 1)[:, None]
    apart = max(
        float(np.abs(outline - places[list(mesh.cycles[face])]).max()) for face, outline in laid.items()
    )
    bent = max(_unevenness(mesh.points[list(face)]) for face in mesh.faces)
    side = _side(places, mesh)
    return UnfoldedMesh(places / side, bent / side, 2 * apart / side)


def _beside(mesh: Mesh, before: int, laid: Floats, face: int, flat: Floats) -> Floats:
    """The corners of a face put beside one that is laid, along the edge they share."""
    shared = {edge_of(*side) for side in sides(mesh.cycles[before])}
    first, second = mesh.cycles[before], mesh.cycles[face]
    u, v = next(side for side in sides(second) if edge_of(*side) in shared)
    here = (flat @ [1, 1j])[[second.index(u), second.index(v)]]
    there = (laid @ [1, 1j])[[first.index(u), first.index(v)]]
    same_way = (u, v) in set(sides(first))  # the neighbour is wound the other way round: seen from behind
    z = flat @ [1, 1j]
    if same_way:
        z, here = z.conj(), here.conj()
    turn = (there[1] - there[0]) / (here[1] - here[0])
    w = there.mean() + (z - here.mean()) * turn / abs(turn)
    return np.stack([w.real, w.imag], axis=1)


def _flattened(corners: Floats) -> Floats:
    """(k, 2): the corners of a polygon in its own plane, counter-clockwise seen from its front."""
    normal = normal_of(corners)
    across = corners[1] - corners[0]
    across = across / max(float(np.linalg.norm(across)), 1e-12)
    return np.stack([corners @ across, corners @ np.cross(normal, across)], axis=1)


def _unevenness(corners: Floats) -> float:
    """How far the corners of a polygon are from one plane."""
    centered = corners - corners.mean(axis=0)
    return float(np.abs(centered @ np.linalg.svd(centered)[2][-1]).max()) if len(corners) > 3 else 0.0


def _distances(points: Floats) -> Floats:
    """Between all pairs of points."""
    first, second = zip(*combinations(range(len(points)), 2), strict=True)
    return np.asarray(np.linalg.norm(points[list(first)] - points[list(second)], axis=1))


def _side(places: Floats, mesh: Mesh) -> float:
    """The side of the square with the area of the faces in the plane."""
    covered = sum(abs(_area(places[list(cycle)])) for cycle in mesh.cycles)
    return max(float(np.sqrt(covered)), 1e-12)


def _area(outline: Floats) -> float:
    x, y = outline.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def square_misfits(unfolded: UnfoldedMesh, mesh: Mesh) -> Iterator[str]:
    """Why the faces in the plane are not one square, each once."""
    import shapely  # noqa: PLC0415  (slow to load)

    outlines = np.array([shapely.Polygon(unfolded.places[list(cycle)]) for cycle in mesh.cycles])
    sheet = shapely.union_all(shapely.buffer(outlines, SQUARE_WITHIN / 20, join_style="mitre"))
    frame = shapely.minimum_rotated_rectangle(sheet)
    corners = shapely.get_coordinates(frame)
    lengths = np.linalg.norm(np.diff(corners[:3], axis=0), axis=1)
    if abs(lengths[0] - lengths[1]) > 2 * SQUARE_WITHIN * lengths.max():
        short, long = sorted(lengths / lengths.max())
        yield f"Unfolded, it is {short:.3g} by {long:.3g}, not a square."
    covered, faces = float(shapely.area(sheet)), float(shapely.area(outlines).sum())
    if faces > covered * (1 + SQUARE_WITHIN):
        yield f"Unfolded, faces cover {faces / covered - 1:.1%} of the sheet twice."
    if covered < float(shapely.area(frame)) * (1 - 3 * SQUARE_WITHIN):
        yield f"Unfolded, {1 - covered / float(shapely.area(frame)):.1%} of the square is missing."
