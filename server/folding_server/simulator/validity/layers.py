"""Layers that cross: the conditions on the order of overlapping faces (Bern and Hayes; Akitaya et al.).

Everything is shrunk by a slack first: what reaches into something else by less does not touch it. A crossing is where
the edges meet, so the faces beside them must have room there: a face that tapers to nothing along the edge is not in
the way, however thick it is elsewhere.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from folding_server.arrays import Bools, Floats, Geometries, Indices
from folding_server.simulator.validity.contacts import (
    along,
    common_stretch,
    meet_across,
    overlapping,
    through,
)
from folding_server.simulator.validity.measures import SLACK, EdgeKey, Measured
from folding_server.simulator.validity.violation import Kind, Violation, listed

FINER = (2e-4, 1e-4)
"""Slacks down to the simulator's tolerance. Edges that lie apart by less than one and more than the next count as one
line for the first only; a crossing is real if it is one either way."""


@dataclass(frozen=True)
class LayerStack:
    """The faces as arrays over their index ``0..n-1`` in ``faces``, and the inner edges as arrays over theirs.

    ``beside`` (m, 2) holds the indices of the two faces of an inner edge, ``segments`` (m, 2, 2) where the edge lies
    read off the first, ``side`` (m, 2) on which side of it each of the two faces is, ``turned`` whether it is folded.
    ``slack`` is what everything is shrunk by.
    """

    faces: Sequence[int]
    edges: Sequence[EdgeKey]
    rank: Indices
    outlines: Geometries
    beside: Indices
    segments: Floats
    side: Floats
    turned: Bools
    slack: float

    @cached_property
    def overlapping(self) -> Bools:
        """(n, n): faces that overlap by more than the slack."""
        i, j = overlapping(self.outlines, self.slack)
        found = np.zeros((len(self.faces), len(self.faces)), bool)
        found[i, j] = found[j, i] = True
        return found

    def meet(self, faces: Sequence[int], stretch: Floats) -> bool:
        """Whether faces have a part in common, thicker than the slack, straight across from a stretch."""
        return meet_across(self.outlines[list(faces)], stretch, self.slack)

    def stretch(self, i: int, j: int) -> Floats:
        """Where two inner edges run along each other."""
        return common_stretch(self.segments[i], self.segments[j])


def layer_stack(sheet: Measured, slack: float) -> LayerStack:
    """The arrays of a measured paper."""
    faces = list(sheet.paper.faces)
    index = {face: i for i, face in enumerate(faces)}
    beside = np.array([[index[f] for f in sheet.edges[e]] for e in sheet.inner], np.intp).reshape(-1, 2)
    own = np.array([[sheet.segment(e, f) for f in sheet.edges[e]] for e in sheet.inner]).reshape(-1, 2, 2, 2)
    centers = np.array([sheet.folded[face].mean(axis=0) for face in faces])
    run, arm = own[:, :, 1] - own[:, :, 0], centers[beside] - own[:, :, 0]
    side = np.sign(run[..., 0] * arm[..., 1] - run[..., 1] * arm[..., 0])
    return LayerStack(
        faces,
        sheet.inner,
        np.array([sheet.rank[face] for face in faces]),
        np.array([shapely.Polygon(sheet.folded[face]) for face in faces]),
        beside,
        own[:, 0],
        side,
        np.array([sheet.turned(edge) for edge in sheet.inner], bool),
        slack,
    )


def crossing_violations(sheet: Measured) -> list[Violation]:
    """The crossings of layers that no tolerance from the simulator's own up to the slack explains.

    The stack is one order of all faces, so transitivity holds if the record is sound.
    """
    if not sheet.inner:
        return []
    found = _crossings(layer_stack(sheet, SLACK))
    for slack in FINER:
        if found:
            finer = {(v.kind, v.faces) for v in _crossings(layer_stack(sheet, slack))}
            found = [v for v in found if (v.kind, v.faces) in finer]
    return found


def _crossings(stack: LayerStack) -> list[Violation]:
    """Every crossing of layers at one slack."""
    return [*_through_faces(stack), *_along_creases(stack)]


def _through_faces(stack: LayerStack) -> Iterator[Violation]:
    """Edges that run through the inside of a face: a fold must not enclose it, flat neighbours lie on one side."""
    edge, face = through(stack.segments, stack.outlines, stack.slack)
    first, second = stack.beside[edge].T
    apart = (
        (first != face) & (second != face) & stack.overlapping[first, face] & stack.overlapping[second, face]
    )
    between = (stack.rank[first] < stack.rank[face]) != (stack.rank[second] < stack.rank[face])
    for i in np.flatnonzero(apart & between):
        if not _has_room(stack, edge[i], face[i]):
            continue
        kind: Kind = "taco-tortilla" if stack.turned[edge[i]] else "tortilla-tortilla"
        found = (stack.faces[first[i]], stack.faces[second[i]], stack.faces[face[i]])
        u, v = stack.edges[edge[i]]
        detail = f"Face {found[2]} lies between faces {found[0]} and {found[1]} but spans their edge {u}-{v}."
        yield Violation(kind, detail, found, ((u, v),))


def _has_room(stack: LayerStack, edge: int, face: int) -> bool:
    """Whether both faces of an edge overlap a face where the edge runs through it: on one side if folded, else on each."""
    first, second = stack.beside[edge]
    inside = shapely.intersection(shapely.LineString(stack.segments[edge]), stack.outlines[face])
    stretch = shapely.get_coordinates(inside)[[0, -1]]
    if stack.turned[edge]:
        return stack.meet((first, second, face), stretch)
    return stack.meet((first, face), stretch) and stack.meet((second, face), stretch)


def _along_creases(stack: LayerStack) -> Iterator[Violation]:
    """Pairs of inner edges that lie along one line: their four faces must not interleave."""
    pairs, ways = along(stack.segments, stack.slack)
    for (i, j), way in zip(pairs.T, ways, strict=True):
        if stack.turned[i] and stack.turned[j]:
            yield from _taco_taco(stack, i, j, way)
        elif stack.turned[i] or stack.turned[j]:
            yield from _taco_tortilla(stack, *((i, j) if stack.turned[i] else (j, i)), way)
        else:
            yield from _tortilla_tortilla(stack, i, j, way)


def _crossing(
    stack: LayerStack, kind: Kind, faces: tuple[int, ...], edges: tuple[int, ...], what: str
) -> Violation:
    ids = tuple(stack.faces[f] for f in faces)
    names = tuple(stack.edges[e] for e in edges)
    where = listed(f"{u}-{v}" for u, v in names)
    return Violation(kind, f"Faces {listed(ids)} {what} along edges {where}.", ids, names)


def _taco_taco(stack: LayerStack, i: int, j: int, way: int) -> Iterator[Violation]:
    """Two folds on one side of a line: nested or apart, never interleaved."""
    if stack.side[i, 0] != stack.side[j, 0] * way:
        return
    (a, b), (c, d) = stack.beside[i], stack.beside[j]
    if len({a, b, c, d}) < 4 or not stack.overlapping[[a, a, b, b], [c, d, c, d]].all():
        return
    low, high = sorted((stack.rank[a], stack.rank[b]))
    interleaved = (low < stack.rank[c] < high) != (low < stack.rank[d] < high)
    if interleaved and stack.meet((a, b, c, d), stack.stretch(i, j)):
        yield _crossing(stack, "taco-taco", (a, b, c, d), (i, j), "interleave")


def _taco_tortilla(stack: LayerStack, fold: int, flat: int, way: int) -> Iterator[Violation]:
    """A fold and a flat pair along one line: the face of the pair on the fold's side is not inside the fold.

    A pair whose other face is thinner than the slack does not reach across the line.
    """
    a, b = stack.beside[fold]
    on = stack.side[flat] * way == stack.side[fold, 0]
    for c, other in zip(stack.beside[flat][on], stack.beside[flat][~on], strict=True):
        inside = (stack.rank[a] < stack.rank[c]) != (stack.rank[b] < stack.rank[c])
        stretch = stack.stretch(fold, flat)
        if inside and stack.meet((a, b, c), stretch) and stack.meet((other,), stretch):
            yield _crossing(stack, "taco-tortilla", (a, b, c), (fold, flat), "cross")


def _tortilla_tortilla(stack: LayerStack, i: int, j: int, way: int) -> Iterator[Violation]:
    """Two flat pairs along one line: one pair is above the other on both sides of it."""
    a, b = stack.beside[i]
    c, d = stack.beside[j] if stack.side[i, 0] == stack.side[j, 0] * way else stack.beside[j][::-1]
    if not (stack.overlapping[a, c] and stack.overlapping[b, d]):
        return
    stretch = stack.stretch(i, j)
    crossed = (stack.rank[a] < stack.rank[c]) != (stack.rank[b] < stack.rank[d])
    if crossed and stack.meet((a, c), stretch) and stack.meet((b, d), stretch):
        yield _crossing(stack, "tortilla-tortilla", (a, b, c, d), (i, j), "cross")
