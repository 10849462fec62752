"""Layers: how the planes of a folded sheet lie over each other (paper, "Origami State"), as a directed graph."""

import networkx as nx

from folding_server.simulator.paper import Paper
from folding_server.simulator.planes import overlapping_pairs, plane_index, planes


def layers_of_planes(paper: Paper) -> list[list[list[int]]]:
    """Layers from bottom to top, each a list of planes, each a list of faces.

    A plane lies in the lowest layer above all planes that it lies over. Planes that are woven into each other
    (a face of one over the other and a face of the other over the first) are given face by face.
    """
    pairs = overlapping_pairs(paper)
    groups = _unwoven(planes(paper), pairs)
    layers = nx.topological_generations(_lies_over(groups, pairs))
    return [[groups[i] for i in sorted(layer)] for layer in layers]


def _lies_over(groups: list[list[int]], pairs: list[tuple[int, int]]) -> "nx.DiGraph[int]":
    """The relation between planes: an edge from each plane to those that lie over it."""
    plane_of = plane_index(groups)
    graph: nx.DiGraph[int] = nx.DiGraph()
    graph.add_nodes_from(range(len(groups)))
    relation = ((plane_of[lower], plane_of[upper]) for lower, upper in pairs)
    graph.add_edges_from((lower, upper) for lower, upper in relation if lower != upper)
    return graph


def _unwoven(groups: list[list[int]], pairs: list[tuple[int, int]]) -> list[list[int]]:
    """The planes with those split into single faces that are woven with another."""
    graph = _lies_over(groups, pairs)
    woven = {i for part in nx.strongly_connected_components(graph) if len(part) > 1 for i in part}
    return [
        part for i, group in enumerate(groups) for part in ([[f] for f in group] if i in woven else [group])
    ]
