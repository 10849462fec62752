"""A state as a FOLD file states it, sound or not: crease pattern, where it lies folded, which face lies over which."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from folding_server.geometry.convex import area
from folding_server.geometry.line import Point
from folding_server.interchange.fold_frames import FoldFrame, frame_of, read_frames
from folding_server.interchange.fold_reading import FaceOrders, read_crease_pattern
from folding_server.interchange.welding import welded
from folding_server.simulator.foldability import CreasePattern
from folding_server.simulator.foldability.equations import FacePair

AS_SEEN = (FaceOrders.VIEWER, FaceOrders.REVERSED)
"""Conventions by which the sign does not depend on how the faces are turned."""


@dataclass(frozen=True)
class StatedModel:
    """What is stated of a model; nothing is checked but the shape of the file.

    ``folded_coords``  (x, y) of each vertex of the pattern in the folded form; None where no frame says it
    ``over``           pairs (upper, lower) of indices of faces, as the model is seen; None without ``faceOrders``
    """

    pattern: CreasePattern
    folded_coords: tuple[Point, ...] | None = None
    over: frozenset[FacePair] | None = None


def stated_model(source: str | Mapping[str, Any], face_orders: FaceOrders = FaceOrders.SPEC) -> StatedModel:
    """The state in a FOLD file, given as its text or the parsed document. ProgramError if it cannot be read."""
    frames = welded(read_frames(source))
    pattern = read_crease_pattern(source)
    folded = frame_of(frames, "foldedForm")
    orders = next((frame.face_orders for frame in frames if frame.face_orders), None)
    if folded is None or not _belongs(folded, pattern):
        as_seen = face_orders in AS_SEEN and orders is not None
        return StatedModel(pattern, None, _over(orders, (), face_orders) if as_seen and orders else None)
    coords = tuple((point[0], point[1]) for point in folded.vertices_coords)
    orders = folded.face_orders or orders
    over = None if orders is None else _over(orders, mirrored_faces(pattern, coords), face_orders)
    return StatedModel(pattern, coords, over)


def mirrored_faces(pattern: CreasePattern, folded_coords: Sequence[Point]) -> list[bool]:
    """For each face whether its back is up: the cycles of a pattern run counter-clockwise on the front."""
    return [area([folded_coords[v] for v in cycle]) < 0 for cycle in pattern.cycles]


def _belongs(folded: FoldFrame, pattern: CreasePattern) -> bool:
    """Whether a folded form has the vertices and the faces of a pattern, in its order."""
    same_vertices = len(folded.vertices_coords) == len(pattern.vertices_coords)
    same_faces = [set(face) for face in folded.faces_vertices] == [set(face) for face in pattern.cycles]
    return same_vertices and same_faces


def _over(
    orders: Sequence[tuple[int, int, int]], mirrored: Sequence[bool], convention: FaceOrders
) -> frozenset[FacePair]:
    """Pairs (upper, lower) from ``faceOrders`` by the convention that the file follows."""
    found = set()
    for f, g, sign in orders:
        if sign:
            judge = {FaceOrders.SPEC: g, FaceOrders.FIRST: f}.get(convention)
            turned = convention is FaceOrders.REVERSED if judge is None else mirrored[judge]
            found.add((f, g) if (sign > 0) != turned else (g, f))
    return frozenset(found)
