"""A paper from a crease pattern, the motions of its faces and which face lies over which."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from folding_server.errors import ProgramError
from folding_server.geometry.convex import overlap
from folding_server.geometry.graph import Edge, edge_of
from folding_server.geometry.isometry import Isometry
from folding_server.geometry.line import Line, line_through
from folding_server.interchange.crease_pattern import turned_round
from folding_server.interchange.flat_motions import ROUNDED
from folding_server.simulator import overlapping_pairs
from folding_server.simulator.foldability import CreasePattern
from folding_server.simulator.paper import FoldedCrease, Paper

if TYPE_CHECKING:
    import networkx as nx

Relation = set[tuple[int, int]]


def stacked(
    pattern: CreasePattern, motions: Sequence[Isometry], relation: Relation, vertex_ids: Sequence[int]
) -> Paper:
    """The paper whose faces lie as ``motions`` says, stacked so that (lower, upper) in ``relation`` holds.

    Faces take ids from 1 by index. Neighbours across a folded crease may be left out of the relation: the
    assignment of the crease orders them. ProgramError if overlapping faces are not ordered or are ordered
    in a circle.
    """
    sheet = max(x for x, _ in pattern.vertices_coords), max(y for _, y in pattern.vertices_coords)
    vertices_coords = {
        v: pattern.vertices_coords[i] for v, i in sorted(zip(vertex_ids, range(len(vertex_ids)), strict=True))
    }
    faces = {
        i + 1: turned_round([vertex_ids[v] for v in cycle]) for i, cycle in enumerate(pattern.faces_vertices)
    }
    isometries = {i + 1: motion for i, motion in enumerate(motions)}
    loose = Paper(sheet, vertices_coords, faces, isometries, tuple(faces), {}, 0, {})
    assignments = {
        edge_of(vertex_ids[u], vertex_ids[v]): assignment
        for (u, v), assignment in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
    }
    order = _order(loose, {(low + 1, high + 1) for low, high in relation}, assignments)
    ordered = Paper(sheet, vertices_coords, faces, isometries, order, {}, 0, {})
    creases, fold_edges = _folds(ordered)
    return Paper(sheet, vertices_coords, faces, isometries, order, creases, len(fold_edges), fold_edges)


def _order(paper: Paper, given: Relation, assignments: Mapping[Edge, str]) -> tuple[int, ...]:
    """A total order, bottom to top, of all faces that agrees with the relation between overlapping ones."""
    known = {frozenset(pair) for pair in given}
    relation = given | {pair for pair in _by_assignments(paper, assignments) if frozenset(pair) not in known}
    import networkx as nx

    graph: nx.DiGraph[int] = nx.DiGraph()
    graph.add_nodes_from(paper.faces)
    graph.add_edges_from(relation)
    order = _topological(graph)
    _check_all_ordered(paper, order, graph)
    return order


def _by_assignments(paper: Paper, assignments: Mapping[Edge, str]) -> Iterable[tuple[int, int]]:
    """(lower, upper) across each folded crease: the lower face has its front up at a valley."""
    for edge, beside in paper.edge_faces.items():
        assignment = assignments.get(edge)
        if assignment in ("M", "V") and paper.is_folded(edge):
            front, back = sorted(beside, key=paper.back_up)
            yield (front, back) if assignment == "V" else (back, front)


def _topological(graph: "nx.DiGraph[int]") -> tuple[int, ...]:
    """The faces in an order in which every lower face comes first; smallest id first at a choice."""
    import networkx as nx

    order: list[int] = []
    with suppress(nx.NetworkXUnfeasible):  # raised at a circle, when all faces outside of it have been given
        order.extend(nx.lexicographical_topological_sort(graph))
    stuck = sorted(face - 1 for face in set(graph).difference(order))
    if stuck:
        raise ProgramError(
            f"The face orders go round in a circle through faces {', '.join(map(str, stuck[:6]))} "
            "(numbered from 0); "
            "check faceOrders, and whether the file follows another convention for their signs."
        )
    return tuple(order)


def _check_all_ordered(paper: Paper, order: Sequence[int], graph: "nx.DiGraph[int]") -> None:
    """Every pair that clearly overlaps must be ordered, directly or through the faces between."""
    above: dict[int, set[int]] = {}
    for face in reversed(order):
        above[face] = set(graph[face]).union(*(above[high] for high in graph[face]))
    for f, g in overlapping_pairs(paper):
        ordered = g in above[f] or f in above[g]
        if not ordered and overlap(paper.polygon(f), paper.polygon(g), ROUNDED):
            raise ProgramError(
                f"Faces {f - 1} and {g - 1} (numbered from 0) overlap when folded, but neither "
                "faceOrders nor the "
                "letters say which is on top; add faceOrders, or check the pattern for foldability to "
                "find an order."
            )


def _folds(paper: Paper) -> tuple[dict[Edge, FoldedCrease], dict[int, tuple[int, int]]]:
    """Records for unfolding: folded creases on one line are taken as one fold, the upper face as the mover.

    Folds are numbered by the height of what they moved, so that the newest lies on top.
    """
    groups: list[tuple[Line, list[Edge]]] = []
    for edge in sorted(paper.edge_faces):
        if paper.is_folded(edge):
            line = line_through(paper.folded_vertices_coords[edge[0]], paper.folded_vertices_coords[edge[1]])
            for other, edges in groups:
                if all(abs(other.distance(paper.folded_vertices_coords[v])) <= ROUNDED for v in edge):
                    edges.append(edge)
                    break
            else:
                groups.append((line, [edge]))
    lines = sorted(
        (edges for _, edges in groups), key=lambda edges: max(paper.rank[_mover(paper, e)] for e in edges)
    )
    creases = {
        edge: FoldedCrease(number, _mover(paper, edge), None)
        for number, edges in enumerate(lines, 1)
        for edge in edges
    }
    return creases, {number: edges[0] for number, edges in enumerate(lines, 1)}


def _mover(paper: Paper, edge: Edge) -> int:
    return max(paper.edge_faces[edge], key=paper.rank.__getitem__)
