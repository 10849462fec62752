"""A measured state as arrays, and the questions that several metrics ask of it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from folding_schemas.state_measures import ConstraintCounts, StateMeasures
from numpy.typing import NDArray

Reals = NDArray[np.float64]
Flags = NDArray[np.bool_]
Places = NDArray[np.intp]
BOUNDARY = "B"


@dataclass(frozen=True)
class ComparedState:
    """A state as it is compared.

    ``sheet`` (v, 2) on the unit square, ``folded`` (v, 2) where it lies or None, both in sheet units; ``edges`` (e, 2)
    indices of vertices, ``letters`` one for each; ``faces`` cycles of indices; ``over`` (f, f) true where the first face lies
    over the second; ``problem`` why it does not compile, empty if it does.
    """

    sheet: Reals
    folded: Reals | None
    edges: Places
    letters: tuple[str, ...]
    faces: tuple[tuple[int, ...], ...]
    over: Flags
    constraints: ConstraintCounts
    locally_flat: float
    problem: str = ""

    @property
    def compiles(self) -> bool:
        """Whether it does."""
        return not self.problem

    @cached_property
    def degrees(self) -> Places:
        """(v,): how many edges end at each vertex."""
        return np.bincount(self.edges.ravel(), minlength=len(self.sheet))

    @cached_property
    def creases(self) -> Places:
        """(c,): the numbers of the edges that are not boundary."""
        return np.flatnonzero(np.array(self.letters) != BOUNDARY)

    @cached_property
    def lengths(self) -> Reals:
        """(e,): how long each edge is on the sheet."""
        ends = self.sheet[self.edges]
        return np.asarray(np.hypot(*(ends[:, 1] - ends[:, 0]).T))

    @cached_property
    def motions(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """(f,) complex factors and (f,) offsets of the faces: z goes to factor * z + offset, z conjugated if ``mirrored``."""
        assert self.folded is not None, "the state says where it lies"
        found = [
            face_motion(self.sheet[list(face)], self.folded[list(face)], turned_over=bool(turned))
            for face, turned in zip(self.faces, self.mirrored, strict=True)
        ]
        factors, offsets = zip(*found, strict=True)
        return np.array(factors), np.array(offsets)

    @cached_property
    def mirrored(self) -> Flags:
        """(f,): whether the back of each face is up."""
        assert self.folded is not None, "the state says where it lies"
        return np.array(
            [
                doubled_area(self.sheet[list(face)]) * doubled_area(self.folded[list(face)]) < 0
                for face in self.faces
            ],
            bool,
        )

    def turned(self, quarters: int) -> "ComparedState":
        """The same state with the sheet's corners called by other names: the sheet turned counter-clockwise."""
        z = (self.sheet[:, 0] - 0.5 + 1j * (self.sheet[:, 1] - 0.5)) * 1j**quarters
        return replace(self, sheet=np.stack([z.real + 0.5, z.imag + 0.5], axis=1))


def compared_state(measured: StateMeasures) -> ComparedState:
    """The arrays of what the server answered."""
    faces = tuple(tuple(face) for face in measured.faces_vertices)
    over = np.zeros((len(faces), len(faces)), bool)
    for upper, lower in measured.over:
        over[upper, lower] = True
    return ComparedState(
        np.array(measured.vertices_coords, float).reshape(-1, 2),
        None if measured.folded_coords is None else np.array(measured.folded_coords, float).reshape(-1, 2),
        np.array(measured.edges_vertices, np.intp).reshape(-1, 2),
        tuple(measured.edges_assignment),
        faces,
        over,
        measured.constraints,
        measured.locally_flat,
        "" if measured.compiles else measured.problem or "it does not compile",
    )


def doubled_area(outline: Reals) -> float:
    """Twice the area of a polygon (k, 2), negative if it runs clockwise."""
    x, y = outline.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def face_motion(flat: Reals, folded: Reals, *, turned_over: bool) -> tuple[complex, complex]:
    """The isometry from one outline (k, 2) to another as factor and offset in the complex plane, least squares."""
    z, w = flat @ [1, 1j], folded @ [1, 1j]
    z = z.conj() if turned_over else z
    factor = complex(np.sum((w - w.mean()) * (z - z.mean()).conj()))
    factor /= abs(factor) or 1.0
    return factor, complex(w.mean() - factor * z.mean())


def common_part(first: Reals, second: Reals) -> Reals:
    """The corners (k, 2) of what two convex polygons have in common, none if nothing (Sutherland and Hodgman 1974)."""
    clip = second if doubled_area(second) > 0 else second[::-1]
    found = list(first)
    for start, end in zip(clip, np.roll(clip, -1, axis=0), strict=True):
        corners, found = found, []
        run = end - start
        sides = [run[0] * (y - start[1]) - run[1] * (x - start[0]) for x, y in corners]
        for i, (corner, side) in enumerate(zip(corners, sides, strict=True)):
            before = sides[i - 1]
            if before * side < 0:
                found.append(corners[i - 1] + (corner - corners[i - 1]) * before / (before - side))
            if side >= 0:
                found.append(corner)
    return np.array(found).reshape(-1, 2)


def inside(points: Reals, outlines: Sequence[Reals]) -> Flags:
    """(n, f): which of the points (n, 2) lie in which polygon, by the even-odd rule."""
    found = np.zeros((len(points), len(outlines)), bool)
    x, y = points.T
    for index, outline in enumerate(outlines):
        for (ax, ay), (bx, by) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            if ay != by:
                crosses = (ay > y) != (by > y)
                found[:, index] ^= crosses & (x < ax + (y - ay) * (bx - ax) / (by - ay))
    return found
