"""Is a crease pattern flat-foldable, how, and in how many ways."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from graphlib import CycleError, TopologicalSorter
from time import perf_counter
from typing import Literal

import shapely

from folding_server.simulator.foldability.classes import ContradictionError
from folding_server.simulator.foldability.conflict import SECONDS, SHORT, conflicting_faces
from folding_server.simulator.foldability.constraints import assigned_orders, constraint_conditions
from folding_server.simulator.foldability.equations import FacePair
from folding_server.simulator.foldability.fault import Fault, said
from folding_server.simulator.foldability.flat_faces import FlatFaces, lay_flat
from folding_server.simulator.foldability.local import VertexViolation, local_violations
from folding_server.simulator.foldability.orders import Orders
from folding_server.simulator.foldability.pattern import CreasePattern, pattern_of
from folding_server.simulator.foldability.planarity import does_not_close, not_a_pattern
from folding_server.simulator.foldability.search import count_orders, first_order
from folding_server.simulator.foldability.single_vertex_pattern import single_vertex_order
from folding_server.simulator.foldability.tolerances import contacts_to_try
from folding_server.simulator.foldability.vertex_faults import unfoldable_vertices
from folding_server.simulator.paper import Paper

CAP = 1000
"""How many layer orders of each part are counted by default."""
CLOSING = 1e-3
"""How far faces may disagree on a folded vertex, in units of the sheet's longer side."""
BRIEF = 1.0
"""Seconds of counting up to which a number of orders is not what was asked for."""
NAMED = 6
"""Faces that a sentence names the places of."""


@dataclass(frozen=True)
class Counting:
    """How layer orders are counted, once one is found.

    ``cap``       orders counted of each part that does not depend on the others, None for all
    ``seconds``   how long, None for as long as it takes
    ``announce``  told after each part how many of how many questions are done, and the product so far
    """

    cap: int | None = CAP
    seconds: float | None = None
    announce: Callable[[int, int, int], None] | None = None

    @property
    def briefly(self) -> bool:
        """Whether one order is asked for, and others only if they cost little."""
        return self.cap == 1 or (self.seconds is not None and self.seconds <= BRIEF)


@dataclass(frozen=True)
class FoldabilityReport:
    """Whether a pattern folds flat.

    ``reason``      one sentence
    ``violations``  vertices at which Maekawa or Kawasaki fails
    ``states``      layer orders found; an order says which of two faces lies higher for every pair of faces that overlap, with
                    the first face front up. The product over parts that do not depend on each other, each counted up to the cap
    ``capped``      whether there may be more
    ``lying``       one layer order as pairs (lower, upper) of overlapping faces
    ``stack``       all faces bottom to top in agreement with ``lying``; None if that goes in a circle, or not foldable
    ``faults``      all that keeps it from folding flat, with places
    Faces are indices into the pattern's cycles, or the ids of a paper's faces.
    """

    foldable: bool
    reason: str
    violations: tuple[VertexViolation, ...] = ()
    states: int = 0
    capped: bool = False
    lying: tuple[FacePair, ...] = ()
    stack: tuple[int, ...] | None = None
    faults: tuple[Fault, ...] = ()


def check_pattern(
    pattern: CreasePattern, cap: int | None = CAP, *, counting: Counting | None = None
) -> FoldabilityReport:
    """Whether a pattern folds flat with every crease folded: first vertex by vertex, then faces, then layers.

    ``cap`` bounds the number of layer orders that are counted of each part; 1 asks for one order only. ``counting`` says
    more about how they are counted.
    """
    faults = not_a_pattern(pattern)
    if faults:
        return _refused(faults[0].detail + _and_more(len(faults) - 1, "fault"), faults)
    violations = tuple(local_violations(pattern))
    if violations:
        faults = [_fault_of(pattern, violation) for violation in violations]
        return replace(_refused(_at_vertices(faults), faults), violations=violations)
    flat = lay_flat(pattern)
    faults = list(does_not_close(flat, CLOSING))
    if faults:
        return _refused(faults[0].detail + _and_more(len(faults) - 1, "fault"), faults)
    faults = unfoldable_vertices(pattern)
    if faults:
        return _refused(_at_vertices(faults), faults)
    return _layered(flat, counting or Counting(cap))


def check_paper(
    paper: Paper, cap: int | None = CAP, *, counting: Counting | None = None
) -> FoldabilityReport:
    """Whether the crease pattern of a paper folds flat; faces of the report are the paper's."""
    report = check_pattern(pattern_of(paper), cap, counting=counting)
    ids = sorted(paper.faces)
    lying = tuple((ids[x], ids[y]) for x, y in report.lying)
    return replace(report, lying=lying, stack=report.stack and tuple(ids[face] for face in report.stack))


def _refused(reason: str, faults: Iterable[Fault]) -> FoldabilityReport:
    return FoldabilityReport(foldable=False, reason=reason, faults=tuple(faults))


def _and_more(count: int, kind: Literal["fault", "vertex"]) -> str:
    """The end of a sentence about the first of several."""
    if not count:
        return ""
    words = {"fault": ("fault", "faults"), "vertex": ("vertex", "vertices")}[kind][count > 1]
    return (
        f" and {count} more {words}"
        if kind == "vertex"
        else f" There {'are' if count > 1 else 'is'} {count} more {words}."
    )


def _fault_of(pattern: CreasePattern, violation: VertexViolation) -> Fault:
    vertex = pattern.names.index(violation.vertex) if pattern.names else violation.vertex
    return Fault(violation.condition, violation.detail, (violation.vertex,), (pattern.place(vertex),))


def _at_vertices(faults: Sequence[Fault]) -> str:
    """The first fault of a vertex in words, and how many other vertices have one."""
    first = faults[0]
    others = len({fault.vertices for fault in faults}) - 1
    return (
        f"{first.kind} fails at vertex {first.vertices[0]} at {said(first.places[0])}{_and_more(others, 'vertex')}: "
        f"{first.detail}"
    )


def _layered(flat: FlatFaces, counting: Counting) -> FoldabilityReport:
    found = None if counting.cap is None else single_vertex_order(flat)
    if found and (found.only or counting.briefly):
        return _folds(found.lying, found.stack, 1, capped=not found.only)
    return _searched(flat, counting)


def _searched(flat: FlatFaces, counting: Counting) -> FoldabilityReport:
    """The report on a pattern by the search for an order of its layers."""
    tried, started = None, perf_counter()
    for contacts in contacts_to_try(flat):
        given = constraint_conditions(contacts)
        tried = tried or given
        try:
            orders = Orders(given)
        except ContradictionError:
            continue
        decided = len(orders.trail)
        if first_order(orders):
            return _counted(flat, orders, decided, counting)
    assert tried is not None
    naming = min(SECONDS, max(SHORT, perf_counter() - started))
    fault = _layer_conflict(flat, conflicting_faces(tried, naming))
    return _refused(fault.detail, [fault])


def _counted(flat: FlatFaces, orders: Orders, decided: int, counting: Counting) -> FoldabilityReport:
    """The report on a pattern of which one order was found; ``decided`` is how much was decided before."""
    lying = tuple(orders.lying())
    orders.undo(decided)
    states, capped = count_orders(orders, counting.cap, counting.seconds, counting.announce)
    return _folds(lying, _stack(flat, lying), states, capped=capped)


def _folds(
    lying: tuple[FacePair, ...], stack: tuple[int, ...] | None, states: int, *, capped: bool
) -> FoldabilityReport:
    """The report on a pattern that folds flat."""
    count = f"{'at least ' if capped else ''}{states} layer order{'s' * (states > 1)}"
    return FoldabilityReport(True, f"The pattern folds flat: {count}.", (), states, capped, lying, stack)


def _layer_conflict(flat: FlatFaces, faces: Sequence[int]) -> Fault:
    """The fault of faces that have no order, named by a place inside each."""
    pattern = flat.pattern
    middles = [
        shapely.point_on_surface(shapely.Polygon([pattern.vertices_coords[v] for v in pattern.cycles[face]]))
        for face in faces
    ]
    places = tuple(pattern.place_of((p.x, p.y)) for p in middles)
    named = ", ".join(map(said, places[:NAMED])) + (
        f" and {len(places) - NAMED} more" if len(places) > NAMED else ""
    )
    outlines = [[pattern.place(v) for v in pattern.cycles[face]] for face in faces]
    return Fault(
        "layers",
        "Maekawa, Kawasaki and big-little-big hold at every vertex, but no order of the layers avoids crossings: there is none for "
        f"the faces around {named}.",
        (),
        places,
        tuple(
            (p, q) for outline in outlines for p, q in zip(outline, (*outline[1:], outline[0]), strict=True)
        ),
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
