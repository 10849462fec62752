"""Layer orders of a crease pattern, counted by trying: slow, plain, and sharing no code with the solver.

An order says which of two faces lies higher, for each two that overlap. It is possible if no face passes through a
crease, no crease through another (Justin's conditions), and no three faces over one point lie in a circle. The pattern
has to list its faces.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import shapely
from folding_server.simulator.foldability import CreasePattern
from plain_folder import Motion

THIN = 1e-6
"""Overlaps thinner or shorter than this are none."""

Over = dict[tuple[int, int], bool]
"""Whether the first face lies over the second, for each two that overlap, either way round."""


class Joint(NamedTuple):
    """Two faces that a crease joins, its letter, and where it lies when all is folded."""

    first: int
    second: int
    letter: str
    line: shapely.LineString

    def holds_between(self, face: int, over: Over) -> bool:
        """Whether a face lies between the two."""
        return over[face, self.first] != over[face, self.second]


def laid_flat(pattern: CreasePattern) -> tuple[list[Motion], list[shapely.Polygon], list[Joint]]:
    """How each face moves when all is folded and the first stays, where the faces lie, and what joins them."""
    points = [complex(*vertex) for vertex in pattern.vertices_coords]
    letters = {frozenset(e): a for e, a in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)}
    joints = [(*faces, side) for side, faces in _beside(pattern).items() if len(faces) == 2]
    motions = {0: Motion()}
    while len(motions) < len(pattern.faces_vertices):
        for one, other, side in joints:
            for known, new in ((one, other), (other, one)):
                if known in motions and new not in motions:
                    turn = Motion() if letters[side] == "F" else _mirror(*(points[v] for v in side))
                    motions[new] = motions[known].after(turn)
    lies = {
        face: [_xy(motions[face](points[v])) for v in cycle]
        for face, cycle in enumerate(pattern.faces_vertices)
    }
    lines = [
        Joint(one, other, letters[side], shapely.LineString([_xy(motions[one](points[v])) for v in side]))
        for one, other, side in joints
    ]
    return [motions[face] for face in lies], list(map(shapely.Polygon, lies.values())), lines


def count_orders(pattern: CreasePattern) -> int:
    """The number of layer orders."""
    motions, outlines, joints = laid_flat(pattern)
    pairs = [(f, g) for f, g in combinations(range(len(outlines)), 2) if _share(outlines[f], outlines[g])]
    given = dict(_lettered(motions, joints))
    rules = [[] for _ in pairs]
    for asked, rule in _rules(outlines, joints, set(pairs)):
        rules[max(pairs.index(pair) for pair in asked)].append(rule)

    def count(decided: int, over: Over) -> int:
        if decided == len(pairs):
            return 1
        (f, g), found = pairs[decided], 0
        for higher in (True, False):
            if given.get((f, g), higher) != higher:
                continue
            over[f, g], over[g, f] = higher, not higher
            if all(rule(over) for rule in rules[decided]):
                found += count(decided + 1, over)
        return found

    return count(0, {})


def _lettered(motions: Sequence[Motion], joints: Sequence[Joint]) -> Iterator[tuple[tuple[int, int], bool]]:
    """What the letters say: the lower face of a valley has its front up."""
    for joint in joints:
        if joint.letter in "MV":
            pair = min(joint[:2]), max(joint[:2])
            yield pair, motions[pair[0]].over == (joint.letter == "V")


def _rules(outlines: Sequence[shapely.Polygon], joints: Sequence[Joint], pairs: set[tuple[int, int]]):
    """Conditions, each with the pairs that it asks about."""
    for joint in joints:
        for face in set(range(len(outlines))) - set(joint[:2]):
            if outlines[face].buffer(-THIN).intersection(joint.line).length > THIN:
                yield (
                    _pairs([face], joint[:2]),
                    lambda over, joint=joint, face=face: not joint.holds_between(face, over),
                )
    for one, other in combinations(joints, 2):
        apart = len({*one[:2], *other[:2]}) == 4
        if apart and _along(one.line, other.line) and _same_side(outlines, one, other):
            yield (
                _pairs(one[:2], other[:2]),
                lambda over, one=one, other=other: (
                    one.holds_between(other.first, over) == one.holds_between(other.second, over)
                ),
            )
    for f, g, h in combinations(range(len(outlines)), 3):
        around = {(f, g), (g, h), (f, h)}
        if around <= pairs and _share(outlines[f].intersection(outlines[g]), outlines[h]):
            yield around, lambda over, f=f, g=g, h=h: not over[f, g] == over[g, h] == over[h, f]


def _pairs(some: Sequence[int], others: Sequence[int]) -> set[tuple[int, int]]:
    return {(min(f, g), max(f, g)) for f in some for g in others}


def _beside(pattern: CreasePattern) -> dict[frozenset[int], list[int]]:
    """The faces beside each edge."""
    beside: dict[frozenset[int], list[int]] = {}
    for face, cycle in enumerate(pattern.faces_vertices):
        for side in zip(cycle, cycle[1:] + cycle[:1], strict=True):
            beside.setdefault(frozenset(side), []).append(face)
    return beside


def _along(one: shapely.LineString, other: shapely.LineString) -> bool:
    return one.buffer(THIN).intersection(other).length > 10 * THIN


def _same_side(outlines: Sequence[shapely.Polygon], one: Joint, other: Joint) -> bool:
    """Whether both folds open to the same side of the line that they share."""
    (ax, ay), (bx, by) = one.line.coords
    sides = [
        (bx - ax) * (outlines[face].centroid.y - ay) > (by - ay) * (outlines[face].centroid.x - ax)
        for face in (one.first, other.first)
    ]
    return sides[0] == sides[1]


def _share(one: shapely.Polygon, other: shapely.Polygon) -> bool:
    return not one.intersection(other).buffer(-THIN).is_empty


def _mirror(p: complex, q: complex) -> Motion:
    across = ((q - p) / abs(q - p)) ** 2
    return Motion(across, p - across * p.conjugate(), over=True)


def _xy(z: complex) -> tuple[float, float]:
    return z.real, z.imag
