"""Graphs of vertices, edges and faces: sides of a face, the faces beside an edge, and what hangs together.

Plain Python, since it loads with the server and every fold asks for it. networkx, which is used where graphs are asked
more, takes one and a half to five times as long for the planes of papers of 200 faces (``benchmarks/simulator.py``).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence

Edge = tuple[int, int]
"""Two vertices; where edges are keys or are listed, the smaller first."""

Cycle = tuple[int, ...]
"""The vertices around a face."""


def edge_of(u: int, v: int) -> Edge:
    """The edge between two vertices, in the order used as a key."""
    return (u, v) if u < v else (v, u)


def sides(cycle: Cycle) -> Iterator[Edge]:
    """The edges of a cycle in the direction it runs, from its first vertex on."""
    return zip(cycle, cycle[1:] + cycle[:1], strict=True)


def edge_faces(faces: Mapping[int, Cycle]) -> dict[Edge, tuple[int, ...]]:
    """Edge -> the faces that have it as a side, in the order of ``faces``."""
    beside: dict[Edge, tuple[int, ...]] = {}
    for face, cycle in faces.items():
        u = cycle[-1]
        for v in cycle:
            key = (u, v) if u < v else (v, u)
            beside[key] = (*beside[key], face) if key in beside else (face,)
            u = v
    return beside


def without_dead_ends(edges: Sequence[Edge]) -> list[Edge]:
    """The edges without those that end in a vertex no other edge meets, again and again: they bound no face."""
    beside: dict[int, set[int]] = {}
    for u, v in edges:
        beside.setdefault(u, set()).add(v)
        beside.setdefault(v, set()).add(u)
    waiting = [v for v, others in beside.items() if len(others) == 1]
    while waiting:
        v = waiting.pop()
        for other in beside.pop(v):
            beside[other].discard(v)
            if len(beside[other]) == 1:
                waiting.append(other)
    return [(u, v) for u, v in edges if u in beside and v in beside]


def component_of(nodes: Iterable[int], edges: Iterable[Sequence[int]]) -> dict[int, int]:
    """For each node the least node of its connected component. Union-find with path halving."""
    parent = {node: node for node in nodes}

    def root(node: int) -> int:
        while parent[node] != node:
            parent[node] = parent[parent[node]]
            node = parent[node]
        return node

    for first, second in edges:
        a, b = root(first), root(second)
        parent[max(a, b)] = min(a, b)
    return {node: root(node) for node in parent}


def components(nodes: Iterable[int], edges: Iterable[Sequence[int]]) -> list[list[int]]:
    """The connected components, each ascending, in the order of their least node."""
    least = component_of(nodes, edges)
    members: dict[int, list[int]] = {}
    for node in sorted(least):
        members.setdefault(least[node], []).append(node)
    return list(members.values())
