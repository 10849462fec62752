"""How many conditions the layers of a crease pattern have to meet, and how many of its vertices can lie flat."""

from collections.abc import Sequence
from math import atan2, pi, tau

from folding_schemas.state_measures import ConstraintCounts

from folding_server.geometry.line import Point
from folding_server.simulator.foldability import CreasePattern
from folding_server.simulator.foldability.constraints import Conditions, conditions
from folding_server.simulator.foldability.equations import rows_of
from folding_server.simulator.foldability.flat_faces import FlatFaces
from folding_server.simulator.foldability.local import ANGLE
from folding_server.simulator.foldability.orders import bits
from folding_server.simulator.foldability.pattern import PatternCrease
from folding_server.simulator.foldability.tolerances import first_tolerance

NO_CONSTRAINTS = ConstraintCounts(taco_taco=0, taco_tortilla=0, tortilla_tortilla=0, transitivity=0)


def constraint_counts(flat: FlatFaces) -> ConstraintCounts:
    """The conditions on the layer order of a pattern that lies flat, each counted once for the faces it is about.

    Transitivity is counted by threes of faces that cover a common cell.
    """
    found = conditions(flat, first_tolerance(flat))
    return ConstraintCounts(
        taco_taco=found.counts["taco-taco"],
        taco_tortilla=found.counts["taco-tortilla"],
        tortilla_tortilla=found.counts["tortilla-tortilla"],
        transitivity=_transitive_triples(found),
    )


def _transitive_triples(found: Conditions) -> int:
    """How many threes of faces share a cell."""
    covers: dict[int, int] = {}
    for face, cells in enumerate(found.cells):
        for cell in bits(cells):
            covers[cell] = covers.get(cell, 0) | 1 << face
    count = 0
    for i, j in rows_of(found.pairs, 2).tolist():
        third = 0
        for cell in bits(found.cells[i] & found.cells[j]):
            third |= covers[cell]
        count += (third >> (j + 1)).bit_count()
    return count


def locally_flat_share(pattern: CreasePattern) -> float:
    """The share of the vertices inside the sheet that satisfy Kawasaki's theorem to within ``ANGLE`` radians and, where
    every crease is folded, Maekawa's; 1 where there is none inside.
    """
    inner = pattern.creases
    between = {crease.edge for crease in inner}
    outline = {v for edge in pattern.edges_vertices if edge not in between for v in edge}
    around: dict[int, list[PatternCrease]] = {}
    for crease in inner:
        for v in crease.edge:
            if v not in outline:
                around.setdefault(v, []).append(crease)
    flat = [_lies_flat(pattern, v, creases) for v, creases in around.items()]
    return sum(flat) / len(flat) if flat else 1.0


def _lies_flat(pattern: CreasePattern, vertex: int, creases: Sequence[PatternCrease]) -> bool:
    folded = [crease for crease in creases if crease.folded]
    if not folded:
        return True
    ends = [pattern.vertices_coords[c.edge[0] if c.edge[1] == vertex else c.edge[1]] for c in folded]
    if len(folded) % 2 or _kawasaki_error(pattern.vertices_coords[vertex], ends) > ANGLE:
        return False
    mountains, valleys = (sum(c.assignment == letter for c in folded) for letter in "MV")
    directed = len(folded) == len(creases) == mountains + valleys
    return not directed or abs(mountains - valleys) == 2


def _kawasaki_error(vertex: Point, ends: Sequence[Point]) -> float:
    """By how much the alternate angles between an even number of creases are off half a turn, in radians."""
    angles = sorted(atan2(y - vertex[1], x - vertex[0]) for x, y in ends)
    gaps = [b - a for a, b in zip(angles, [*angles[1:], angles[0] + tau], strict=True)]
    return abs(sum(gaps[::2]) - pi)
