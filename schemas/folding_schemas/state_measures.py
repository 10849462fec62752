"""What evaluation is told of a state by the server: its mesh, whether it compiles, and what constrains its layers."""

from typing import Literal

from folding_schemas.wire import Wire

PatternLetter = Literal["B", "F", "M", "V", "U"]


class ConstraintCounts(Wire):
    """How many conditions of each kind the layer order of a crease pattern has to meet."""

    taco_taco: int
    taco_tortilla: int
    tortilla_tortilla: int
    transitivity: int


class StateMeasures(Wire):
    """Answer of ``measure_state``. Vertices, edges and faces are numbered from 0 in the order of the lists.

    ``compiles``: the crease pattern is planar, in one piece and covers the unit square, it closes up when folded, and some
    order of its layers agrees with its letters; else ``problem`` says why not. ``vertices_coords`` are on the
    sheet, ``folded_coords`` where they lie now, both in sheet units; ``folded_coords`` is None where nothing says it and
    the pattern does not fold. ``over`` lists the pairs (upper, lower) of faces that overlap. ``locally_flat`` is the share
    of the vertices inside the sheet that satisfy Kawasaki's theorem and, where every crease is folded, Maekawa's.
    """

    compiles: bool
    problem: str
    vertices_coords: list[tuple[float, float]]
    folded_coords: list[tuple[float, float]] | None
    edges_vertices: list[tuple[int, int]]
    edges_assignment: list[PatternLetter]
    faces_vertices: list[list[int]]
    over: list[tuple[int, int]]
    constraints: ConstraintCounts
    locally_flat: float
