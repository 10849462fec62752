"""Layers: how the planes of a folded sheet lie over each other (paper, "Origami State"), as a directed graph.

The standard library sorts the graph, in less than half of networkx's time for papers of under ten faces: every answer to
an action holds a state. networkx, which finds the planes that are woven, is loaded where there are such.
"""

from collections.abc import Iterable, Mapping
from graphlib import CycleError, TopologicalSorter

from folding_server.simulator.paper import Paper
from folding_server.simulator.planes import overlapping_pairs, plane_index, planes

Below = Mapping[int, Iterable[int]]
"""Index of a plane -> the indices of the planes that it lies over."""


def layers_of_planes(paper: Paper) -> list[list[list[int]]]:
    """Layers from bottom to top, each a list of planes, each a list of faces.

    A plane lies in the lowest layer above all planes that it lies over. Planes that are woven into each other
    (a face of one over the other and a face of the other over the first) are given face by face.
    """
    pairs, groups = overlapping_pairs(paper), planes(paper)
    try:
        return _generations(groups, _below(groups, pairs))
    except CycleError:
        unwoven = _unwoven(groups, pairs)
        return _generations(unwoven, _below(unwoven, pairs))


def _below(groups: list[list[int]], pairs: list[tuple[int, int]]) -> Below:
    """The relation between planes, for every plane."""
    plane_of = plane_index(groups)
    below: dict[int, set[int]] = {plane: set() for plane in range(len(groups))}
    for lower, upper in pairs:
        if plane_of[lower] != plane_of[upper]:
            below[plane_of[upper]].add(plane_of[lower])
    return below


def _generations(groups: list[list[int]], below: Below) -> list[list[list[int]]]:
    """The planes by layer. CycleError if some are woven."""
    sorter = TopologicalSorter(below)
    sorter.prepare()
    layers = []
    while layer := sorter.get_ready():
        layers.append([groups[plane] for plane in sorted(layer)])
        sorter.done(*layer)
    return layers


def _unwoven(groups: list[list[int]], pairs: list[tuple[int, int]]) -> list[list[int]]:
    """The planes with those split into single faces that are woven with another."""
    import networkx as nx

    graph = nx.DiGraph(dict(_below(groups, pairs)))
    woven = {i for part in nx.strongly_connected_components(graph) if len(part) > 1 for i in part}
    return [
        part for i, group in enumerate(groups) for part in ([[f] for f in group] if i in woven else [group])
    ]
