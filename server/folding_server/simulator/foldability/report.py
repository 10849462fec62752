"""Is a crease pattern flat-foldable, how, and in how many ways."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from graphlib import CycleError, TopologicalSorter

from folding_server.geometry.planar import crossing_edges
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator.foldability.constraints import assigned_orders, conditions
from folding_server.simulator.foldability.equations import ContradictionError, FacePair
from folding_server.simulator.foldability.flat_faces import (
    FOLDED_ASSIGNMENTS,
    FlatFaces,
    creases_of,
    lay_flat,
)
from folding_server.simulator.foldability.local import VertexViolation, local_violations
from folding_server.simulator.foldability.orders import Orders
from folding_server.simulator.foldability.pattern import CreasePattern, pattern_of
from folding_server.simulator.foldability.search import count_orders, first_order
from folding_server.simulator.paper import Paper

CAP = 1000
"""How many layer orders are counted by default."""
CLOSING = 1e-3
"""How far faces may disagree on a folded vertex, in units of the sheet's longer side."""


@dataclass(frozen=True)
class FoldabilityReport:
    """Whether a pattern folds flat.

    ``reason``      one sentence
    ``violations``  vertices at which Maekawa or Kawasaki fails
    ``states``      layer orders found, at most the cap; an order says which of two faces lies higher for every pair of
                    faces that overlap, with the first face front up
    ``capped``      whether there may be more
    ``lying``       one layer order as pairs (lower, upper) of overlapping faces
    ``stack``       all faces bottom to top in agreement with ``lying``; None if that goes in a circle, or not foldable
    Faces are indices into the pattern's cycles, or the ids of a paper's faces.
    """

    foldable: bool
    reason: str
    violations: tuple[VertexViolation, ...] = ()
    states: int = 0
    capped: bool = False
    lying: tuple[FacePair, ...] = ()
    stack: tuple[int, ...] | None = None


def check_pattern(pattern: CreasePattern, cap: int = CAP) -> FoldabilityReport:
    """Whether a pattern folds flat with every crease folded: first vertex by vertex, then faces, then layers.

    ``cap`` bounds the number of layer orders that are counted; 1 asks for one order only.
    """
    refused = next(_not_a_pattern(pattern), None)
    if refused:
        return FoldabilityReport(foldable=False, reason=refused)
    violations = tuple(local_violations(pattern))
    if violations:
        first = violations[0]
        more = f" and {len(violations) - 1} more vertices" if len(violations) > 1 else ""
        reason = f"{first.condition} fails at vertex {first.vertex}{more}: {first.detail}"
        return FoldabilityReport(foldable=False, reason=reason, violations=violations)
    flat = lay_flat(pattern)
    refused = next(_does_not_close(flat), None)
    if refused:
        return FoldabilityReport(foldable=False, reason=refused)
    return _layered(flat, cap)


def check_paper(paper: Paper, cap: int = CAP) -> FoldabilityReport:
    """Whether the crease pattern of a paper folds flat; faces of the report are the paper's."""
    report = check_pattern(pattern_of(paper), cap)
    ids = sorted(paper.faces)
    lying = tuple((ids[x], ids[y]) for x, y in report.lying)
    return replace(report, lying=lying, stack=report.stack and tuple(ids[face] for face in report.stack))


def _not_a_pattern(pattern: CreasePattern) -> Iterator[str]:
    """Why a graph is no crease pattern of one sheet."""
    if not pattern.edges_vertices or not pattern.cycles:
        yield "The pattern has no face: its edges enclose nothing."
        return
    crossing = crossing_edges(pattern.vertices_coords, pattern.edges_vertices)
    if crossing:
        first, second = (_edge_name(pattern, pattern.edges_vertices[i]) for i in crossing)
        yield f"Edges {first} and {second} meet without a common vertex, so the pattern is not planar."
    joined = {crease.edge for crease in creases_of(pattern)}
    for edge, assignment in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True):
        if assignment in FOLDED_ASSIGNMENTS and edge not in joined:
            yield f"Crease {_edge_name(pattern, edge)} ({assignment}) does not lie between two faces, so it cannot be folded."


def _edge_name(pattern: CreasePattern, edge: tuple[int, int]) -> str:
    return f"{pattern.name(edge[0])}-{pattern.name(edge[1])}"


def _does_not_close(flat: FlatFaces) -> Iterator[str]:
    """Why the faces cannot all lie flat without tearing."""
    if flat.loose is not None:
        names = [flat.pattern.name(v) for v in flat.pattern.cycles[flat.loose]]
        yield f"The face {names} is not joined to the rest, so this is more than one sheet."
    if flat.odd is not None:
        yield f"Around vertex {flat.pattern.name(flat.odd)} an odd number of creases is folded, so faces meet wrong side up."
    if flat.spread > CLOSING:
        yield (
            f"The faces do not close up: folded, they are {flat.spread:.3g} of the sheet's side apart at vertex "
            f"{flat.pattern.name(flat.worst)} (allowed {CLOSING:g})."
        )


def tolerances(flat: FlatFaces) -> Sequence[float]:
    """What layers may reach into each other: the simulator's tolerance, or what the faces disagree by if that is more.

    Whether edges that almost coincide count as one line depends on it, so a pattern is foldable if this, a finer or a
    coarser one finds an order; on patterns without near coincidences all agree.
    """
    first = max(TOLERANCE, 2 * flat.spread)
    return first, first / 4, 3 * first


def _layered(flat: FlatFaces, cap: int) -> FoldabilityReport:
    for tolerance in tolerances(flat):
        try:
            orders = Orders(conditions(flat, tolerance))
        except ContradictionError:
            continue
        decided = len(orders.trail)
        if first_order(orders):
            lying = tuple(orders.lying())
            orders.undo(decided)
            states, capped = count_orders(orders, cap)
            count = f"{'at least ' if capped else ''}{states} layer order{'s' * (states > 1)}"
            return FoldabilityReport(
                True, f"The pattern folds flat: {count}.", (), states, capped, lying, _stack(flat, lying)
            )
    return FoldabilityReport(
        foldable=False, reason="Every vertex folds flat, but no order of the layers avoids crossings."
    )


def _stack(flat: FlatFaces, lying: Sequence[FacePair]) -> tuple[int, ...] | None:
    """All faces bottom to top, or None if the order goes in a circle.

    Slivers too thin to overlap anything go where the assignments of their creases put them, as far as that is possible.
    """
    faces = range(len(flat.outlines))
    stacked = _bottom_to_top(faces, [*lying, *assigned_orders(flat)])
    return stacked or _bottom_to_top(faces, lying)


def _bottom_to_top(faces: Iterable[int], pairs: Iterable[FacePair]) -> tuple[int, ...] | None:
    under: dict[int, set[int]] = {face: set() for face in faces}
    for lower, upper in pairs:
        under[upper].add(lower)
    try:
        return tuple(TopologicalSorter(under).static_order())
    except CycleError:
        return None
