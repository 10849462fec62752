"""Faces that rounding has left without area, taken out of a FOLD document.

Real folds are not exact, so that states have slivers of 1e-4 of the sheet; with three decimals their corners coincide or lie on one
line. What is beside a sliver is joined across it; where a fold lay on each side of it, the two are none.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from folding_server.arrays import Floats
from folding_server.geometry.graph import Edge, edge_of, sides

THIN = 1e-3
"""Width of a face, by the side of the sheet, up to which it is a sliver: twice the rounding."""
MOUNTAINS_AND_VALLEYS = frozenset("MVU")
DERIVED_LISTS = (
    "edges_faces",
    "edges_foldAngle",
    "faces_edges",
    "vertices_vertices",
    "vertices_edges",
    "vertices_faces",
)
"""What follows from the mesh and would not fit it any more."""


@dataclass
class _Mesh:
    """Faces by their numbers in the file, edges with their letters."""

    faces: dict[int, list[int]]
    letters: dict[Edge, str] = field(default_factory=dict)

    def add(self, edge: Edge, letter: str) -> None:
        """An edge, laid upon one that may be there: two folds are none."""
        both = self.letters.get(edge, "F"), letter
        if "B" in both:
            self.letters[edge] = "B"
        else:
            folded = [each for each in both if each in MOUNTAINS_AND_VALLEYS]
            self.letters[edge] = folded[0] if len(folded) == 1 else "F"


def without_slivers(document: Mapping[str, Any]) -> Mapping[str, Any]:
    """The document without slivers; as it is if there are none, or if its frames do not share one mesh."""
    frames = [document, *document.get("file_frames", ())]
    flat = next((f for f in frames if "creasePattern" in f.get("frame_classes", ())), document)
    shape = [f for f in (flat, *frames) if f.get("faces_vertices") and f.get("edges_vertices")]
    if not shape or not _sound(flat, shape[0]):
        return document
    places = np.array([point[:2] for point in flat["vertices_coords"]], float)
    places = places / max(float(np.ptp(places, axis=0).max()), THIN)
    number = _one_number_each(places)
    mesh = _welded_mesh(shape[0], number)
    thin = [face for face, cycle in mesh.faces.items() if _width(places[cycle]) <= THIN]
    if not thin and len(set(number)) == len(number):
        return document
    for face in thin:
        _join_across(mesh, face, places)
    return _written(document, mesh, len(places))


def _sound(flat: Mapping[str, Any], shape: Mapping[str, Any]) -> bool:
    """Whether the lists fit each other so far that they can be looked at; what does not is told when the file is read."""
    count = len(flat.get("vertices_coords", ()))
    used = [v for cycle in (*shape["faces_vertices"], *shape["edges_vertices"]) for v in cycle]
    lettered = len(shape.get("edges_assignment", ())) == len(shape["edges_vertices"])
    return lettered and count > 0 and all(isinstance(v, int) and 0 <= v < count for v in used)


def _one_number_each(places: Floats) -> list[int]:
    """For each vertex the first that lies at its place."""
    first: dict[tuple[float, float], int] = {}
    return [first.setdefault((round(x, 6), round(y, 6)), i) for i, (x, y) in enumerate(places.tolist())]


def _welded_mesh(shape: Mapping[str, Any], number: Sequence[int]) -> _Mesh:
    mesh = _Mesh({})
    for index, cycle in enumerate(shape["faces_vertices"]):
        joined = [number[v] for v in cycle]
        mesh.faces[index] = [
            v for v, before in zip(joined, (joined[-1], *joined), strict=False) if v != before
        ]
    for (u, v), letter in zip(shape["edges_vertices"], shape["edges_assignment"], strict=True):
        if number[u] != number[v]:
            mesh.add(edge_of(number[u], number[v]), letter)
    return mesh


def _width(outline: Floats) -> float:
    """Area by longest side; 0 for fewer than three corners."""
    if len(outline) < 3:
        return 0.0
    x, y = outline.T
    longest = float(np.hypot(*(outline - np.roll(outline, 1, axis=0)).T).max())
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2 / max(longest, THIN)


def _join_across(mesh: _Mesh, face: int, places: Floats) -> None:
    """Take a sliver out: each of its sides is divided where corners of it lie along that, as the faces beyond are."""
    cycle = mesh.faces.pop(face)
    for u, v in sides(tuple(cycle)) if len(cycle) > 2 else ():
        run = places[v] - places[u]
        along = {w: float((places[w] - places[u]) @ run / (run @ run)) for w in cycle if w not in (u, v)}
        between = sorted((w for w, t in along.items() if 0 < t < 1), key=along.__getitem__)
        if between:
            chain = [u, *between, v]
            letter = mesh.letters.pop(edge_of(u, v), "F")
            for a, b in pairwise(chain):
                mesh.add(edge_of(a, b), letter)
            for other, corners in mesh.faces.items():
                mesh.faces[other] = _divided(corners, chain)


def _divided(corners: list[int], chain: list[int]) -> list[int]:
    """A cycle with the corners of a chain put into the side that joins its ends."""
    u, v = chain[0], chain[-1]
    found: list[int] = []
    for a, b in sides(tuple(corners)):
        found.append(a)
        if (a, b) == (u, v):
            found += chain[1:-1]
        elif (a, b) == (v, u):
            found += chain[-2:0:-1]
    return found


def _written(document: Mapping[str, Any], mesh: _Mesh, count: int) -> Mapping[str, Any]:
    """The document with the new mesh in every frame that has one, and the vertices of it in those that have ``count``."""
    kept = {face: index for index, face in enumerate(mesh.faces)}
    used = sorted(
        {v for edge in mesh.letters for v in edge} | {v for cycle in mesh.faces.values() for v in cycle}
    )
    new = {v: index for index, v in enumerate(used)}
    changed: dict[str, Any] = {
        "edges_vertices": [[new[u], new[v]] for u, v in mesh.letters],
        "edges_assignment": list(mesh.letters.values()),
        "faces_vertices": [[new[v] for v in cycle] for cycle in mesh.faces.values()],
    }

    def rewritten(frame: Mapping[str, Any]) -> dict[str, Any]:
        plain = {name: value for name, value in frame.items() if name not in DERIVED_LISTS}
        plain |= {name: changed[name] for name in changed if name in frame}
        if len(frame.get("vertices_coords", ())) == count:
            plain["vertices_coords"] = [frame["vertices_coords"][v] for v in used]
        if "faceOrders" in frame:
            orders = frame["faceOrders"]
            plain["faceOrders"] = [[kept[f], kept[g], s] for f, g, s in orders if f in kept and g in kept]
        return plain

    below = [rewritten(frame) for frame in document.get("file_frames", ())]
    return rewritten(document) | ({"file_frames": below} if below else {})
