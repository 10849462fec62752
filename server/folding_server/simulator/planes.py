"""Planes and layers: which faces lie flat together, and how the planes lie over each other (paper, "Origami State")."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from folding_server.geometry.convex import bounding_box, boxes_meet, overlap
from folding_server.geometry.union_find import joined
from folding_server.simulator.paper import Paper


def planes(paper: Paper) -> list[list[int]]:
    """Maximal sets of faces joined by flat edges, each sorted, in the order of their lowest face id."""
    flat = (
        beside
        for beside in paper.edge_faces.values()
        if len(beside) == 2 and paper.back_up(beside[0]) == paper.back_up(beside[1])
    )
    lowest = joined(paper.faces, flat)
    members: dict[int, list[int]] = {}
    for face in sorted(paper.faces):
        members.setdefault(lowest[face], []).append(face)
    return list(members.values())


def overlapping_pairs(paper: Paper) -> list[tuple[int, int]]:
    """All pairs (lower face, upper face) that overlap by more than the tolerance, in stack order."""
    outlines = {face: paper.polygon(face) for face in paper.order}
    boxes = {face: bounding_box(outline) for face, outline in outlines.items()}
    return [
        (lower, upper)
        for i, lower in enumerate(paper.order)
        for upper in paper.order[i + 1 :]
        if boxes_meet(boxes[lower], boxes[upper]) and overlap(outlines[lower], outlines[upper])
    ]


if TYPE_CHECKING:
    import networkx as nx


def layers_of_planes(paper: Paper) -> list[list[list[int]]]:
    """Layers from bottom to top, each a list of planes, each a list of faces.

    A plane lies in the lowest layer above all planes that it lies over. Planes that are woven into each other
    (a face of one over the other and a face of the other over the first) are given face by face.
    """
    import networkx as nx  # noqa: PLC0415  (loaded when the first layers are asked for, not at start-up)

    groups = planes(paper)
    pairs = overlapping_pairs(paper)
    groups = _unwoven(groups, pairs)
    plane_of = plane_index(groups)
    below: dict[int, set[int]] = {i: set() for i in range(len(groups))}
    for lower, upper in pairs:
        if plane_of[lower] != plane_of[upper]:
            below[plane_of[upper]].add(plane_of[lower])
    depth: dict[int, int] = {}
    for i in nx.topological_sort(_lies_over(groups, pairs)):
        depth[i] = 1 + max((depth[j] for j in below[i]), default=-1)
    layers: list[list[list[int]]] = [[] for _ in range(max(depth.values()) + 1)]
    for i, group in enumerate(groups):
        layers[depth[i]].append(group)
    return layers


def _lies_over(groups: list[list[int]], pairs: list[tuple[int, int]]) -> "nx.DiGraph[int]":
    """The relation between planes: an edge from each plane to those that lie over it."""
    import networkx as nx  # noqa: PLC0415

    plane_of = plane_index(groups)
    graph: nx.DiGraph[int] = nx.DiGraph()
    graph.add_nodes_from(range(len(groups)))
    relation = ((plane_of[lower], plane_of[upper]) for lower, upper in pairs)
    graph.add_edges_from((lower, upper) for lower, upper in relation if lower != upper)
    return graph


def _unwoven(groups: list[list[int]], pairs: list[tuple[int, int]]) -> list[list[int]]:
    """The planes with those split into single faces that are woven with another."""
    import networkx as nx  # noqa: PLC0415

    graph = _lies_over(groups, pairs)
    woven = {i for part in nx.strongly_connected_components(graph) if len(part) > 1 for i in part}
    return [
        part for i, group in enumerate(groups) for part in ([[f] for f in group] if i in woven else [group])
    ]


def plane_index(groups: list[list[int]]) -> Mapping[int, int]:
    """Face -> index of its plane."""
    return {face: i for i, group in enumerate(groups) for face in group}
