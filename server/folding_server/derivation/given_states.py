"""States of a data set, read and snapped: on the unit square, faces moved as rigid bodies, letters left aside.

Data sets round coordinates to three decimals, and some swap mountains and valleys when the model is flipped. So a
state is taken by what its faces show and how they lie; which crease is a mountain follows from that.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from folding_server.arrays import Floats, Ints
from folding_server.derivation.slivers import without_slivers
from folding_server.errors import ProgramError
from folding_server.geometry.convex import area
from folding_server.geometry.isometry import IDENTITY, Isometry
from folding_server.geometry.line import Point
from folding_server.interchange.face_ordering import stacked
from folding_server.interchange.flat_motions import best_motion
from folding_server.interchange.fold_frames import parse_json_object
from folding_server.interchange.fold_reading import FaceOrders
from folding_server.measuring.stated_model import StatedModel, stated_model
from folding_server.simulator import Paper
from folding_server.simulator.foldability import CreasePattern
from folding_server.simulator.foldability.equations import FacePair
from folding_server.simulator.foldability.face_walk import SharedEdge, faces_isometries

ROUNDING = 5e-4
"""Sheet units by which a coordinate with three decimals is off at most."""
NEAR = 5 * ROUNDING
"""Sheet units within which points are one: both are rounded, and a folded one has been carried through several faces."""


@dataclass(frozen=True)
class GivenState:
    """A state of a data set.

    ``pattern``   crease pattern on the unit square; its folded creases are called U, whatever the file calls them
    ``motions``   how each face lies, an isometry of the sheet
    ``over``      pairs (upper, lower) of faces as the model is seen
    ``posed``     whether the file says where the model lies; without, face 0 lies as on the sheet
    """

    pattern: CreasePattern
    motions: tuple[Isometry, ...]
    over: frozenset[FacePair]
    posed: bool

    @cached_property
    def outlines(self) -> tuple[list[Point], ...]:
        """The faces on the sheet."""
        return tuple([self.pattern.vertices_coords[v] for v in cycle] for cycle in self.pattern.cycles)

    @cached_property
    def vertices(self) -> Floats:
        """(v, 2): the vertices on the sheet."""
        return np.array(self.pattern.vertices_coords, float)

    @cached_property
    def probes(self) -> Floats:
        """(f + n, 2): the middle of each face, then all corners of the first, of the second, and so on, on the sheet."""
        middles = [np.mean(outline, axis=0) for outline in self.outlines]
        return np.array([*middles, *(corner for outline in self.outlines for corner in outline)], float)

    @cached_property
    def corner_faces(self) -> Ints:
        """(n,): the face of each corner among the probes."""
        return np.repeat(np.arange(len(self.outlines)), [len(outline) for outline in self.outlines])

    @cached_property
    def largest(self) -> int:
        """The face with the largest area, which says best how the model lies."""
        return max(range(len(self.outlines)), key=lambda face: abs(area(self.outlines[face])))

    def paper(self) -> Paper:
        """The state as a paper, its letters by layers and sides. ProgramError if its layers have no order."""
        relation = {(lower, upper) for upper, lower in self.over}
        ids = range(1, len(self.pattern.vertices_coords) + 1)
        return stacked(self.pattern, self.motions, relation, list(ids))


def given_state(source: str | Mapping[str, Any], face_orders: FaceOrders) -> GivenState:
    """The state in a FOLD file. ProgramError if it cannot be read, or its faces do not lie as rigid bodies."""
    document = parse_json_object(source, "FOLD file") if isinstance(source, str) else source
    model = _on_unit_square(stated_model(without_slivers(document), face_orders))
    pattern = model.pattern
    if model.folded_coords is None:
        motions = _folded_by_letters(pattern)
    else:
        motions = [
            _motion(i, [pattern.vertices_coords[v] for v in cycle], [model.folded_coords[v] for v in cycle])
            for i, cycle in enumerate(pattern.cycles)
        ]
    if model.over is None and any(letter in "MVU" for letter in pattern.edges_assignment):
        raise ProgramError("The FOLD file has folded creases and no faceOrders; give the order of its faces.")
    unlettered = replace(
        pattern,
        faces_vertices=pattern.cycles,
        edges_assignment=tuple("U" if letter in "MV" else letter for letter in pattern.edges_assignment),
    )
    return GivenState(unlettered, tuple(motions), model.over or frozenset(), model.folded_coords is not None)


def _motion(face: int, flat: Sequence[Point], folded: Sequence[Point]) -> Isometry:
    motion = best_motion(flat, folded)
    worst = max(abs(complex(*motion(p)) - complex(*q)) for p, q in zip(flat, folded, strict=True))
    if worst > NEAR:
        raise ProgramError(
            f"Face {face} of the FOLD file has another shape when folded (a corner is out by {worst:.3g} of the sheet); the "
            "folded form and the crease pattern do not belong together."
        )
    return motion


def _folded_by_letters(pattern: CreasePattern) -> list[Isometry]:
    """The motions when every crease but the marks is folded and face 0 stays. What rounding leaves open is left so."""
    shared = [SharedEdge(c.edge, (c.left, c.right), c.folded) for c in pattern.creases]
    found = faces_isometries(pattern.vertices_coords, shared)
    if len(pattern.cycles) == 1:
        return [IDENTITY]
    if len(found) < len(pattern.cycles):
        raise ProgramError(
            "The faces of the FOLD file are not all joined; only sheets in one piece are read."
        )
    return [found[face] for face in range(len(pattern.cycles))]


def _on_unit_square(model: StatedModel) -> StatedModel:
    """The model scaled and shifted so that its sheet is the unit square, points of the outline exactly on it."""
    points = model.pattern.vertices_coords
    left, low = (min(c) for c in zip(*points, strict=True))
    width, height = (max(c) - min(c) for c in zip(*points, strict=True))
    if min(width, height) <= 0 or abs(width - height) > 2 * NEAR * max(width, height):
        raise ProgramError(
            f"The sheet of the FOLD file is {width:.4g} by {height:.4g}; actions are derived for squares only."
        )

    def placed(point: Point) -> Point:
        return (point[0] - left) / width, (point[1] - low) / height

    sheet = tuple((_snapped(x), _snapped(y)) for x, y in map(placed, points))
    folded = model.folded_coords and tuple(map(placed, model.folded_coords))
    return StatedModel(replace(model.pattern, vertices_coords=sheet), folded, model.over)


def _snapped(value: float) -> float:
    """A coordinate on the sheet, on its outline if it is as near as rounding explains."""
    return next((side for side in (0.0, 1.0) if abs(value - side) <= 2 * ROUNDING), value)
