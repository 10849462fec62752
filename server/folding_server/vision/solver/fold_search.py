"""Searching for the fold that explains a photo: analysis by synthesis.

Landmark lines and a grid of all lines, filtered by what changed, are tried with every set of layers they can turn; the
best are refined below the pixel together with the sheet's drift, then snapped to landmarks where the photo allows it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from folding_server.geometry.line import Line, Point
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.labels import LabelImage
from folding_server.vision.registration.alignment import Vector, climb, nudged, polished
from folding_server.vision.registration.scene import Scene, Views, face_stack
from folding_server.vision.solver.constructions import constructions
from folding_server.vision.solver.creases import Family, handles_of, midpoint, shifted
from folding_server.vision.solver.lines import (
    ChangedPoints,
    Lines,
    all_lines,
    angle_between,
    as_line,
    best_supported,
    both_ways,
    crease_lines,
    distinct_lines,
    distinct_points,
    edge_directions,
    landmark_lines,
)
from folding_server.vision.solver.movable_layers import AT, NEAR_LINE, MovableLayers, MovingSet
from folding_server.vision.solver.plan import scale_change_cost

_PARALLEL = 0.9992
"""Cosine of the angle (2.3 degrees) within which a line may be meant to be parallel to another."""


SUB_PIXEL = 0.004
"""Sheet units by which thick paper and a slanting camera alone move a fold line in a photo."""
MEANT, MEANT_SLACK, EXACTLY = 0.016, 0.006, 1e-6
"""A line that misses two vertices by less than the first (sheet units) is meant to pass through them, and taken to if that
explains less by at most the second; one that passes within the third of a vertex does pass through it.
"""
NEAR_ENDS = 0.03
"""Lines that pass the ends of a crease by less (sheet units) are near it."""
MOST_CREASED = 3
"""Creases that are near a found line and are tried although others look better where the sheet lies: a fold along one 0.02
beside moves the sheet too.
"""
HANDHELD_ALLOWANCE = 1.6
"""So many times more is forgiven under a camera in the hand: no photo but the first says how it looks at the sheet."""
SPOILT = 5.0
"""How many pixels put right one that is changed but wrong is worth, when a part of the change is looked for."""


@dataclass(frozen=True)
class Effort:
    """How hard to look. Angles in degrees, lengths in sheet units.

    ``share`` of the change must be explained; ``partial`` ranks folds by what they put right, not by how all looks.
    A simpler line is taken if it explains at most ``snap`` less, and ``snap_noise`` of what no line explains.
    """

    degrees: float = 4.0
    spacing: float = 0.02
    most_lines: int = 240
    refined: int = 10
    polished: int = 4
    share: float = 0.8
    partial: bool = False
    snap: float = 0.001
    snap_noise: float = 0.08


@dataclass(frozen=True)
class FoldFound:
    """A fold that explains a scene under a motion with some agreement; ``exact`` if its line was constructed."""

    moving: MovingSet
    motion: Similarity
    agreement: float
    exact: bool = False


class FoldSearch:
    """The search for one transition: a paper, the photo after it, what changed, and the scale of the photo before."""

    def __init__(
        self, paper: Paper, views: Views, changed: Sequence[ChangedPoints], effort: Effort, scale: float
    ) -> None:
        self.paper, self.changed, self.effort, self.scale = paper, changed, effort, scale
        self.coarse, self.fine, self.handheld = views.coarse, views.fine, views.handheld
        self.layers = MovableLayers(paper)
        self.before = face_stack(paper)
        self.landmarks = both_ways(landmark_lines(paper))
        self.grid = both_ways(all_lines(paper, effort.degrees, effort.spacing))
        self.directions = edge_directions(paper)
        self.creases = both_ways(distinct_lines(crease_lines(paper)))
        self.points: list[Point] = [(x, y) for x, y in distinct_points(paper).tolist()]
        self._before: dict[tuple[bool, Similarity], LabelImage] = {}

    @property
    def calm(self) -> bool:
        """Whether the photo's classes show no change on the coarse view under some drift: then the fine one is searched."""
        return any(change.scene is self.fine for change in self.changed)

    def run(self) -> list[FoldFound]:
        """Folds that explain the photo, best first, each line with every set of layers that does nearly as well."""
        view = self.changed[0].scene if self.changed else self.coarse
        refined = _best_first([self._refined(f, view, 3) for f in self._rough()])
        polished = [self._refined(f, self.fine, 3) for f in _different(refined)[: self.effort.polished]]
        snapped = [s for f in _different(_best_first(polished)) for s in self.snapped(f)]
        return _best_first(snapped)

    def near(self, found: FoldFound) -> list[FoldFound]:
        """Folds near one whose line is nearly right, found below the pixel, and snapped as well, best first."""
        refined = replace(self._refined(found, self.fine, 3), exact=False)
        return _best_first(list(dict.fromkeys([refined, *self.snapped(refined)])))

    def _worth(self, scene: Scene, after: LabelImage, motion: Similarity) -> float:
        """The agreement of a drawing or, looking for a part of the change, what it puts right less what it spoils."""
        if not self.effort.partial:
            return scene.agreement_of(after) - self._scale_change_cost(motion)
        changed = (self._drawn_before(scene, motion) != after) & scene.known
        right = int(np.count_nonzero(changed & (after == scene.labels)))
        wrong = int(np.count_nonzero(changed & (after != scene.labels)))
        return (right - SPOILT * wrong) / max(1, int(np.count_nonzero(scene.paper)))

    def _looks(self, moving: MovingSet, motion: Similarity) -> float:
        """What a fold as it stands is worth on the fine view."""
        return self._worth(self.fine, self.fine.draw(self.layers.folded(moving), motion), motion)

    def _scale_change_cost(self, motion: Similarity) -> float:
        """What it costs that the sheet looks larger or smaller under a motion than it did before."""
        return scale_change_cost(motion.scale / self.scale, self.handheld)

    def _drawn_before(self, scene: Scene, motion: Similarity) -> LabelImage:
        """The paper as it was, under a motion."""
        key = (scene is self.fine, motion)
        if key not in self._before:
            self._before[key] = scene.draw(self.before, motion)
        return self._before[key]

    def _rough(self) -> list[FoldFound]:
        """The most promising lines and layers, scored without moving anything, on the view that shows the change."""
        found: list[FoldFound] = []
        for change in self.changed:
            for row in self._plausible(change):
                for moving in self.layers.moving_sets(as_line(row)):
                    drawn = change.scene.draw(self.layers.folded(moving), change.motion)
                    found.append(
                        FoldFound(moving, change.motion, self._worth(change.scene, drawn, change.motion))
                    )
        return _different(_best_first(found))[: self.effort.refined]

    def _plausible(self, change: ChangedPoints) -> Lines:
        """Landmarks and grid lines that could explain the change, at most ``most_lines`` of each."""
        effort = self.effort
        kept = []
        for lines in (self.landmarks, self.grid):
            support = change.support(lines)
            if effort.partial:
                support = np.where(support >= effort.share, 1.0, 0.0)
            kept.append(best_supported(lines, support, effort.share, effort.most_lines))
        return np.concatenate(kept)

    def _refined(self, found: FoldFound, scene: Scene, halvings: int) -> FoldFound:
        """Both ends of the crease and the sheet's drift, climbed together."""
        handles = handles_of(self.layers, found.moving)
        pivot = midpoint(*handles)
        seed = found.moving.seed

        def drawn(x: Vector) -> LabelImage:
            moving = self.layers.moving_from(shifted(handles, found.moving.line, x[0], x[1]), seed)
            stack = self.layers.folded(moving or found.moving)
            return scene.draw(stack, nudged(found.motion, pivot, x[2:]))

        def value(x: Vector) -> float:
            return self._worth(scene, drawn(x), nudged(found.motion, pivot, x[2:]))

        step = 2.0 / scene.grid.pixels_per_unit
        steps = (
            (step, step, 0.0, 0.0, 0.0, 0.0)
            if self.effort.partial
            else (step, step, step / 2, step / 2, 1.5, 0.02)
        )
        x, best = climb(value, (0.0,) * 6, steps, halvings - 1)
        if not self.effort.partial:
            fine_steps = (step / 2, step / 2, step / 2, step / 2, 50 * step, step)
            x, best = polished(drawn, value, scene, x, best, fine_steps)
        moving = self.layers.moving_from(shifted(handles, found.moving.line, x[0], x[1]), seed)
        return FoldFound(moving or found.moving, nudged(found.motion, pivot, x[2:]), best)

    def snapped(self, found: FoldFound) -> list[FoldFound]:
        """The line the photo cannot tell from ``found`` that is simplest, with each set of layers it can turn."""
        exact = [self._settled(found, Family(line)) for line in self._landmarks_near(found)]
        bound = [
            self._settled(found, family)
            for family in (*self._through_vertices(found), *self._parallels(found))
        ]
        allowed = max(f.agreement for f in (found, *exact, *bound))
        slack = self.effort.snap + self.effort.snap_noise * (1 - allowed)
        best = [found]
        for group, share, near_share in ((exact, 1.0, 4.0), (bound, 0.7, 1.4)):
            good = [
                replace(f, exact=group is exact)
                for f in group
                if f.agreement >= allowed - self._allowance(found, f, slack * share, slack * near_share)
            ]
            if good:
                best = [max(some, key=lambda f: f.agreement) for some in (good, self._meant(good)) if some]
                break
        return [snapped for f in dict.fromkeys(best) for snapped in (f, *self._other_layers(f))]

    def _meant(self, found: Sequence[FoldFound]) -> list[FoldFound]:
        """Those of the folds whose line passes through two vertices near their creases."""
        return [
            f for f in found if f.exact and self._is_meant(f.moving.line, handles_of(self.layers, f.moving))
        ]

    def _is_meant(self, line: Line, ends: tuple[Point, Point]) -> bool:
        """Whether a line passes through two vertices between its ``ends`` or little beyond."""
        return len(self._beside(line, ends, EXACTLY, NEAR_ENDS)) > 1

    def _beside(self, line: Line, ends: tuple[Point, Point], reach: float, beyond: float) -> list[Point]:
        """Vertices within reach of a line, between its ends or so far beyond them."""
        low, high = sorted(line.ny * x - line.nx * y for x, y in ends)
        return [
            p
            for p in self.points
            if abs(line.distance(p)) < reach
            and low - beyond < line.ny * p[0] - line.nx * p[1] < high + beyond
        ]

    def _allowance(self, found: FoldFound, snapped: FoldFound, far: float, near: float) -> float:
        """How much less a snapped line may explain: ``near`` if a photo can hardly tell it from the found one, else
        ``far``, and more where both vertices that it passes through are as good as met.
        """
        line, old = snapped.moving.line, found.moving.line
        moved = max(abs(line.distance(handle)) for handle in handles_of(self.layers, found.moving))
        loose = HANDHELD_ALLOWANCE if self.handheld else 1.0
        met = [
            p for p in self.points if abs(line.distance(p)) < EXACTLY and abs(old.distance(p)) < loose * MEANT
        ]
        return (near if moved < SUB_PIXEL else far) + (loose * MEANT_SLACK if len(met) > 1 else 0.0)

    def _other_layers(self, found: FoldFound) -> Iterator[FoldFound]:
        """The same line with other sets of layers."""
        for moving in self._sets(found.moving.line, exact=found.exact):
            if moving.faces != found.moving.faces:
                got = self._looks(moving, found.motion)
                yield FoldFound(moving, found.motion, got, found.exact)

    def _sets(self, line: Line, *, exact: bool) -> list[MovingSet]:
        """The sets of layers that a fold along a line can turn; of one that was constructed, also those that turn because a
        hair of them lies beyond it.
        """
        nears = (NEAR_LINE, AT) if exact else (NEAR_LINE,)
        sets = {moved.faces: moved for near in nears for moved in self.layers.moving_sets(line, near)}
        return list(sets.values())

    def _settled(self, found: FoldFound, family: Family) -> FoldFound:
        """The best line of a family near the found one, with the drift climbed anew."""
        start = found.motion
        sets = self._sets(family.line, exact=not family.free)
        if not sets:
            return FoldFound(found.moving, start, 0.0)
        moving = max(sets, key=lambda m: self._looks(m, start))
        handles = handles_of(self.layers, moving)
        pivot = midpoint(*handles)

        def folded(amount: float) -> MovingSet:
            line = family.member(amount, handles)
            return (self.layers.moving_from(line, moving.seed) or moving) if amount else moving

        def drawn(x: Vector) -> LabelImage:
            return self.fine.draw(self.layers.folded(folded(x[0])), nudged(start, pivot, x[1:]))

        def value(x: Vector) -> float:
            return self._worth(self.fine, drawn(x), nudged(start, pivot, x[1:]))

        step = 1.0 / self.fine.grid.pixels_per_unit
        x: Vector = (0.0,) * 5
        if self.effort.partial:
            x, best = climb(value, x, (step if family.free else 0.0, 0.0, 0.0, 0.0, 0.0), 1)
        else:
            steps = (step if family.free else 0.0, step, step, 100 * step, 2 * step)
            x, _ = polished(drawn, value, self.fine, x, value(x), steps)
            x, best = climb(value, x, [s / 2 for s in steps], 1)
        return FoldFound(folded(x[0]), nudged(start, pivot, x[1:]), best)

    def _through_vertices(self, found: FoldFound) -> Iterator[Family]:
        """Lines near the found one through one existing vertex, to be turned about it."""
        line = found.moving.line
        for p in self._near_points(found, 0.02):
            yield Family(Line(line.nx, line.ny, line.nx * p[0] + line.ny * p[1]), pinned=p)

    def _parallels(self, found: FoldFound) -> Iterator[Family]:
        """Lines near the found one that are parallel or square to an edge, to be shifted."""
        line = found.moving.line
        x, y = midpoint(*handles_of(self.layers, found.moving))
        for nx, ny in self.directions:
            along = nx * line.nx + ny * line.ny
            if abs(along) > _PARALLEL:
                sign = 1.0 if along > 0 else -1.0
                yield Family(Line(sign * nx, sign * ny, sign * (nx * x + ny * y)), shifts=True)

    def _near_points(self, found: FoldFound, reach: float) -> list[Point]:
        """Vertices within reach of the crease, by distance."""
        line = found.moving.line
        near = self._beside(line, handles_of(self.layers, found.moving), reach, reach)
        return sorted(near, key=lambda p: abs(line.distance(p)))[:4]

    def _landmarks_near(self, found: FoldFound) -> list[Line]:
        """Landmark and constructed lines that pass near both ends of the crease: the six best-looking, those that are meant, and
        creases that are there.
        """
        line, handles = found.moving.line, handles_of(self.layers, found.moving)
        built = constructions(self.paper, line, midpoint(*handles))
        nearest = _near(
            np.concatenate([self.landmarks, built]) if len(built) else self.landmarks, line, handles
        )
        best = sorted(nearest[:24], key=lambda other: -self._at_once(found, other))[:6]
        meant = (other for other in nearest if other not in best and self._is_meant(other, handles))
        creased = _near(self.creases, line, handles)[:MOST_CREASED]
        return _distinct([*best, *islice(meant, 2), *creased])

    def _at_once(self, found: FoldFound, line: Line) -> float:
        """The agreement of a line near the found one as it stands."""
        moving = self.layers.moving_from(line, found.moving.seed)
        return self._looks(moving, found.motion) if moving else 0.0


def _best_first(found: Sequence[FoldFound]) -> list[FoldFound]:
    return sorted(found, key=lambda f: -f.agreement)


def _near(lines: Lines, line: Line, ends: tuple[Point, Point]) -> list[Line]:
    """Those of the lines that pass near both ends and have the same side moving as ``line``, the nearest first."""
    gaps = np.abs(lines[:, :2] @ np.array(ends).T - lines[:, 2:3]).max(axis=1, initial=0.0)
    near = np.nonzero((gaps < NEAR_ENDS) & (lines[:, :2] @ np.array([line.nx, line.ny]) > 0))[0]
    return _distinct([as_line(lines[i]) for i in near[np.argsort(gaps[near], kind="stable")]])


def _distinct(lines: Sequence[Line]) -> list[Line]:
    """Lines without those that are the same to a ten-thousandth."""
    kept: dict[tuple[float, ...], Line] = {}
    for line in lines:
        kept.setdefault(tuple(round(x, 4) for x in line), line)
    return list(kept.values())


def _different(found: Sequence[FoldFound]) -> list[FoldFound]:
    """Folds without those that turn the same layers along nearly the same line as a better one."""
    kept: list[FoldFound] = []
    for f in found:
        if not any(_alike(f.moving, k.moving) for k in kept):
            kept.append(f)
    return kept


def _alike(a: MovingSet, b: MovingSet) -> bool:
    return (
        a.faces == b.faces
        and a.line.nx * b.line.nx + a.line.ny * b.line.ny > 0
        and angle_between(a.line, b.line) < 5
        and abs(a.line.offset - b.line.offset) < 0.03
    )
