"""Predicting a fold without making it: which faces would move, and what the stack would look like.

A search tries thousands of lines; this follows the same rule as the simulator's ``fold`` but cuts nothing and numbers
nothing. The plan that wins is made of real actions and checked against the simulator.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import dist

import numpy as np

from folding_server.arrays import Bools, Floats
from folding_server.geometry.convex import SPECK, area, clip, overlap
from folding_server.geometry.isometry import mirror
from folding_server.geometry.line import Line, Point, line_through
from folding_server.simulator.paper import Paper
from folding_server.vision.registration.scene import FaceStack

RankPair = tuple[int, int]
"""Ranks of two faces in the stack; the first takes the second along."""
NEAR_LINE = 0.009
"""A corner this near a line counts as on it while searching, as a line is found no more exactly than that."""
AT = 0.001
"""The same for a line that was constructed."""
NARROWEST_STRIP = 0.03
"""Nobody folds a strip narrower than this (sheet units), but what photos leave unexplained often looks like one."""
LEAST_STAYING = 0.06
"""So narrow a strip (sheet units) is not left lying where all else is folded over: the model is turned over, and the strip folded."""


@dataclass(frozen=True)
class MovingSet:
    """The faces that a fold along ``line`` turns, at least in part, when it starts at ``seed``."""

    line: Line
    seed: int
    faces: frozenset[int]


_Part = tuple[int, Sequence[Point], bool]
"""A face, its outline as it lies or what a fold leaves of it, and whether that lies back up."""


def is_thin(paper: Paper, moving: MovingSet) -> bool:
    """Whether a fold turns nothing but a narrow strip, or all but one."""
    line = moving.line
    turned = max(line.distance(p) for face in moving.faces for p in paper.polygon(face))
    stays = max(
        (abs(line.distance(p)) if face not in moving.faces else -line.distance(p))
        for face in paper.faces
        for p in paper.polygon(face)
    )
    return turned < NARROWEST_STRIP or stays < LEAST_STAYING


class MovableLayers:
    """A paper prepared for trying many folds: outlines, neighbours and overlaps worked out once."""

    def __init__(self, paper: Paper) -> None:
        self.paper = paper
        self.outlines: dict[int, list[Point]] = {f: paper.polygon(f) for f in paper.order}
        self.backs = {f: paper.back_up(f) for f in paper.order}
        self._lying = [(f, self.outlines[f], self.backs[f]) for f in paper.order]
        self._faces = _Shapes([self.outlines[f] for f in paper.order])
        tied = [*self._joined(), *self._covered()]
        self._pairs = np.array([pair for pair, _ in tied], np.intp).reshape(-1, 2)
        self._ties = _Shapes([shape for _, shape in tied])

    def moving_sets(self, line: Line, near: float = NEAR_LINE) -> Iterator[MovingSet]:
        """The different sets of layers that a fold along a line can turn, topmost seed first; never all faces. Corners that
        are ``near`` the line count as on it.
        """
        least, most = self._faces.reach(line)
        left = _as_bits(least < -near)
        takes = self._takes(line, near)
        known: dict[int, int] = {}
        seen: set[int] = set()
        for seed in range(len(least) - 1, -1, -1):
            if most[seed] <= near or least[seed] > near:
                continue
            known[seed] = moved = _closure(seed, takes, known)
            if moved in seen:
                continue
            seen.add(moved)
            if moved.bit_count() < len(least) or left & moved:
                yield MovingSet(line, self.paper.order[seed], self._named(moved))

    def moving_from(self, line: Line, seed: int) -> MovingSet | None:
        """The set turned by a fold along a line from one seed; None if the seed has nothing on the moving side."""
        if max(line.distance(p) for p in self.outlines[seed]) <= NEAR_LINE:
            return None
        return MovingSet(
            line, seed, self._named(_closure(self.paper.rank[seed], self._takes(line, NEAR_LINE), {}))
        )

    def overreach(self, moving: MovingSet) -> float:
        """How far what ties a moving layer to one that stays reaches over the line: at most NEAR_LINE, 0 if nothing does."""
        if not len(self._pairs):
            return 0.0
        first, second = np.isin(self.paper.order, list(moving.faces))[self._pairs].T
        most = self._ties.reach(moving.line)[1]
        return max(0.0, float(np.max(most[first & ~second], initial=0.0)))

    def folded(self, moving: MovingSet) -> FaceStack:
        """What the stack looks like after a fold."""
        lying, turned = _parted(self._lying, moving, *self._spans(moving.line))
        return _stack(lying + turned)

    def folded_both(self, first: MovingSet, second: MovingSet) -> FaceStack | None:
        """What the stack looks like after two folds; None if the first lays something over what the second turns."""
        lying, turned = _parted(self._lying, first, *self._spans(first.line))
        if any(second.line.distance(p) > SPECK for _, outline, _ in turned for p in outline):
            return None
        distances = [[second.line.distance(p) for p in outline] for _, outline, _ in lying]
        lying, turned_next = _parted(lying, second, [min(d) for d in distances], [max(d) for d in distances])
        return _stack(lying + turned + turned_next)

    def _spans(self, line: Line) -> tuple[list[float], list[float]]:
        """The least and greatest signed distance from a line of each face's corners, bottom to top."""
        least, most = self._faces.reach(line)
        return least.tolist(), most.tolist()

    def _joined(self) -> list[tuple[RankPair, Sequence[Point]]]:
        """Faces joined by an edge, both ways, and that edge."""
        positions, rank = self.paper.folded_vertices_coords, self.paper.rank
        return [
            ((rank[face], rank[other]), (positions[u], positions[v]))
            for (u, v), beside in self.paper.edge_faces.items()
            if len(beside) == 2
            for face, other in (beside, beside[::-1])
        ]

    def _covered(self) -> list[tuple[RankPair, Sequence[Point]]]:
        """Each face and each one above that covers some of it, and what both cover."""
        outlines = [self.outlines[f] for f in self.paper.order]
        return [
            ((low, high), _intersection(outlines[low], outlines[high]) or outlines[low])
            for low, high in combinations(range(len(outlines)), 2)
            if overlap(outlines[low], outlines[high])
        ]

    def _takes(self, line: Line, near: float) -> list[int]:
        """For each rank the faces, as bits, that it takes along: joined off the line, or lying over its moving part."""
        count = len(self.paper.order)
        if not len(self._pairs):
            return [0] * count
        taken = np.zeros((count, count), bool)
        faces, others = self._pairs[self._ties.reach(line)[1] > near].T
        taken[faces, others] = True
        rows = np.packbits(taken, axis=1, bitorder="little")
        return [int.from_bytes(row.tobytes(), "little") for row in rows]

    def _named(self, moved: int) -> frozenset[int]:
        return frozenset(face for rank, face in enumerate(self.paper.order) if moved >> rank & 1)


def _parted(
    parts: Sequence[_Part], moving: MovingSet, least: Sequence[float], most: Sequence[float]
) -> tuple[list[_Part], list[_Part]]:
    """What stays of parts, bottom to top, and what a fold lays on it; ``least`` and ``most`` are their distances from its line."""
    line = moving.line
    away, reflection = line.opposite(), mirror(line)
    lying: list[_Part] = []
    turned: list[_Part] = []
    for part, low, high in zip(parts, least, most, strict=True):
        face, outline, back = part
        if face not in moving.faces or high <= 0:
            lying.append(part)
            continue
        stays = clip(outline, away) if low < 0 else []
        if len(stays) > 2:
            lying.append((face, stays, back))
        moves = clip(outline, line) if low < 0 else outline
        if len(moves) > 2:
            turned.append((face, [reflection(p) for p in moves], not back))
    return lying, turned[::-1]


def _stack(parts: Sequence[_Part]) -> FaceStack:
    return FaceStack([outline for _, outline, _ in parts], [back for _, _, back in parts])


class _Shapes:
    """Outlines of different lengths whose distances from a line are found all at once."""

    def __init__(self, outlines: Sequence[Sequence[Point]]) -> None:
        self._points = np.array([p for outline in outlines for p in outline]).reshape(-1, 2)
        self._starts = np.cumsum([0, *(len(outline) for outline in outlines)])[:-1]

    def reach(self, line: Line) -> tuple[Floats, Floats]:
        """The least and greatest signed distance from a line of each outline's corners."""
        distances = self._points @ (line.nx, line.ny) - line.offset
        return np.minimum.reduceat(distances, self._starts), np.maximum.reduceat(distances, self._starts)


def _closure(seed: int, takes: Sequence[int], known: Mapping[int, int]) -> int:
    """Everything that moves with a seed, as bits; ``known`` are closures found before."""
    found = waiting = 1 << seed
    while waiting:
        face = waiting.bit_length() - 1
        waiting &= ~(1 << face)
        new = (known[face] if face in known else takes[face]) & ~found
        found |= new
        waiting |= 0 if face in known else new
        waiting &= ~known.get(face, 0)
    return found


def _as_bits(flags: Bools) -> int:
    """The places that are true, as bits."""
    return sum(1 << i for i in np.nonzero(flags)[0].tolist())


def _intersection(first: Sequence[Point], second: Sequence[Point]) -> list[Point]:
    """The common part of two convex outlines, empty if they only touch."""
    common = list(second)
    corners = list(first) if area(first) > 0 else list(reversed(first))
    for p, q in zip(corners, [*corners[1:], corners[0]], strict=True):
        if len(common) > 2 and dist(p, q) > SPECK:
            common = clip(common, line_through(p, q))
    return common if len(common) > 2 else []
