"""A folded sheet as a FOLD 1.2 document: the folded form, then the crease pattern, same vertices.

The standard properties say all that other software reads. Properties named ``folding:...`` add what the
simulator needs to go on exactly where it was: ids, isometries, the total order of the stack, and who folded
which crease. Coordinates are written in full double precision.
"""

import json
from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version
from typing import Any

from folding_server.geometry.convex import area
from folding_server.geometry.graph import Edge, edge_of, sides
from folding_server.interchange.crease_pattern import crease_pattern_of
from folding_server.simulator import overlapping_pairs
from folding_server.simulator.foldability import CreasePattern
from folding_server.simulator.paper import FoldedCrease, Paper

Document = dict[str, Any]

FOLD_ANGLES = {"V": 180, "M": -180}
RECORD_VERSION = 1
"""Version of the ``folding:`` properties."""


def fold_document(paper: Paper, title: str | None = None) -> Document:
    """The full document: frame 0 the folded form, frame 1 the crease pattern, which inherits the rest."""
    pattern = crease_pattern_of(paper)
    pairs = overlapping_pairs(paper)
    touching = "selfTouching" if pairs else "nonSelfTouching"
    return {
        **_file_properties(title),
        "frame_classes": ["foldedForm"],
        "frame_attributes": _attributes(touching),
        "frame_unit": "unit",
        "vertices_coords": [list(paper.folded_vertices_coords[v]) for v in sorted(paper.vertices_coords)],
        **_mesh(pattern),
        "faceOrders": _face_orders(paper, pairs),
        **_ids(paper),
        **_record(paper),
        "file_frames": [
            {
                "frame_classes": ["creasePattern"],
                "frame_attributes": _attributes("nonSelfTouching"),
                "frame_parent": 0,
                "frame_inherit": True,
                "vertices_coords": [list(coords) for coords in pattern.vertices_coords],
                "faceOrders": [],
            }
        ],
    }


def crease_pattern_document(paper: Paper, title: str | None = None) -> Document:
    """The crease pattern of a paper alone, as the only frame, with the ids that actions use."""
    return {**_pattern_frame(crease_pattern_of(paper), title), **_ids(paper)}


def pattern_document(pattern: CreasePattern, title: str | None = None) -> Document:
    """A crease pattern that no paper was folded from, as the only frame."""
    edges = tuple(edge_of(*edge) for edge in pattern.edges_vertices)
    return _pattern_frame(replace(pattern, edges_vertices=edges, faces_vertices=pattern.cycles), title)


def _pattern_frame(pattern: CreasePattern, title: str | None) -> Document:
    return {
        **_file_properties(title),
        "frame_classes": ["creasePattern"],
        "frame_attributes": _attributes("nonSelfTouching"),
        "frame_unit": "unit",
        "vertices_coords": [list(coords) for coords in pattern.vertices_coords],
        **_mesh(pattern),
    }


def fold_text(document: Mapping[str, Any]) -> str:
    """A document as the text of a ``.fold`` file: one property a line."""
    lines = (f" {json.dumps(key)}: {json.dumps(value)}" for key, value in document.items())
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _file_properties(title: str | None) -> Document:
    named = {"file_title": title} if title else {}
    creator = f"foldingagent-mcp {version('foldingagent-mcp')}"
    return {"file_spec": 1.2, "file_creator": creator, **named, "file_classes": ["singleModel"]}


def _attributes(touching: str) -> list[str]:
    return [
        "2D",
        "manifold",
        "orientable",
        touching,
        "nonSelfIntersecting",
        "noCuts",
        "noJoins",
        "convexFaces",
    ]


def _mesh(pattern: CreasePattern) -> Document:
    """Everything that both frames share: edges, assignments, angles, faces and how they are joined."""
    edge_index = {edge: i for i, edge in enumerate(pattern.edges_vertices)}
    left: dict[Edge, int] = {}
    faces_edges = []
    for f, cycle in enumerate(pattern.faces_vertices):
        left.update((side, f) for side in sides(cycle))
        faces_edges.append([edge_index[edge_of(*side)] for side in sides(cycle)])
    return {
        "edges_vertices": [list(edge) for edge in pattern.edges_vertices],
        "edges_faces": [[left[s] for s in ((u, v), (v, u)) if s in left] for u, v in pattern.edges_vertices],
        "edges_assignment": list(pattern.edges_assignment),
        "edges_foldAngle": [FOLD_ANGLES.get(assignment, 0) for assignment in pattern.edges_assignment],
        "faces_vertices": [list(cycle) for cycle in pattern.faces_vertices],
        "faces_edges": faces_edges,
    }


def _face_orders(paper: Paper, pairs: list[tuple[int, int]]) -> list[list[int]]:
    """[f, g, s] for each overlapping pair: s = +1 if f lies on the side of g that g's normal points to.

    Faces run counter-clockwise on the front, so the normal of g points to the viewer if the front of g is up.
    """
    index = {face: i for i, face in enumerate(paper.faces)}
    return [[index[upper], index[lower], -1 if paper.back_up(lower) else 1] for lower, upper in pairs]


def _ids(paper: Paper) -> Document:
    return {"folding:vertex_ids": sorted(paper.vertices_coords), "folding:face_ids": list(paper.faces)}


def _record(paper: Paper) -> Document:
    """What only the simulator needs, by the ids of vertices and faces."""
    return {
        "folding:record": {
            "version": RECORD_VERSION,
            "sheet": list(paper.sheet),
            "order": list(paper.order),
            "isometries": [list(paper.isometries[face]) for face in paper.faces],
            "counterclockwise": [face for face in paper.faces if area(paper.sheet_polygon(face)) > 0],
            "creases": [[list(edge), _crease_chain(crease)] for edge, crease in paper.creases.items()],
            "folds": paper.folds,
            "fold_edges": [[number, *edge] for number, edge in paper.fold_edges.items()],
        }
    }


def _crease_chain(crease: FoldedCrease | None) -> list[list[int]]:
    """The records of a crease as [fold, face that moved], the newest first."""
    chain = []
    while crease is not None:
        chain.append([crease.fold, crease.moved])
        crease = crease.below
    return chain
