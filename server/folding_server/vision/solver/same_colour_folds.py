"""Folds within one colour: the label images of two photos are alike, and only light tells where paper moved."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from math import pi

import cv2
import numpy as np
from folding_schemas.actions import Actions

from folding_server.geometry.convex import clip
from folding_server.geometry.isometry import mirror
from folding_server.geometry.line import Line, line_through
from folding_server.geometry.point_batch import transformed
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.raster import draw_touched
from folding_server.vision.registration.alignment import Vector, climb
from folding_server.vision.registration.scene import Scene, Views, face_stack
from folding_server.vision.solver.creases import handles_of, shifted
from folding_server.vision.solver.differences import ACROSS, BORDER_REACH, Differences, near, square
from folding_server.vision.solver.lines import (
    Lines,
    as_line,
    axes_of,
    both_ways,
    edge_directions,
    landmark_lines,
    lines_across,
)
from folding_server.vision.solver.movable_layers import MovableLayers, MovingSet, is_thin
from folding_server.vision.solver.plan import Plan, best_first
from folding_server.vision.solver.realise import realise

LEAST_TRACE, LEAST_EXPLAINED = 0.012, 0.008
"""If less than the first looks different, in all (sheet units of line), nothing was folded; a plan that explains less than
the second explains nothing.
"""
CALM = 0.006
"""Folds that make the label image agree worse by more are not of this kind."""
SPACING = 0.01
"""Lines along an edge or square to it are tried so far apart, and looked at in such steps (sheet units)."""
MIDDLE, FARTHEST_LINE = np.array([0.5, 0.5]), 1.0
"""Lines are looked at so far from the point nearest to the middle of the sheet (sheet units)."""
MOST_TRACE_LINES, LEAST_CREASE = 1000, 0.02
"""Of more lines only those are tried along which so much (sheet units) looks different."""
TRACE_CLEARNESS, TRACE_LENGTH, MOST_TRACED = 0.4, 0.04, 40
"""Lines at least so long (sheet units) along which the trace is at least so clear (0 to 1) are tried, so many of them."""
LOOKED_AT, TRIED, KEPT = 600, 24, 4
"""Folds of which the label image is drawn, the best along the trace; those realised and measured in full; those refined."""
JUDGED = 16
"""Plans found otherwise that are judged by what looks different, the best."""
CONSTRUCTED, ALIGNED, FREE = 0.0, 0.005, 0.015
"""The share of what looks different that a line must explain beyond one that was constructed: one that is square to an axis
of symmetry, and any other.
"""
PERPENDICULAR = 1e-3
"""Cosine within which two lines are square to each other."""
STEP = 0.01
"""Sheet units by which the ends of a crease are first moved."""
TRACELESS_COST = 0.2
"""What a stretch of border that leaves no trace counts against a fold, before it is measured in full."""


def same_colour_folds(
    paper: Paper, motion: Similarity, views: Views, last: Similarity
) -> "SameColourFolds | None":
    """The search for folds within one colour. What has not moved lies under ``motion`` and lay under ``last``. None if the
    photos cannot be looked at closely.
    """
    if views.closely is None:
        return None
    before, after = views.closely()
    seen = Differences(paper, before, last, replace(after, sight=views.fine.sight), motion)
    return SameColourFolds(seen, views.fine)


@dataclass(frozen=True)
class SameColourFold:
    """A fold as actions, and the length of lines (sheet units) that changed against it; ``looseness`` is how little its line
    is bound: CONSTRUCTED, ALIGNED or FREE.
    """

    moving: MovingSet
    actions: Actions
    paper: Paper
    unexplained: float
    looseness: float


class SameColourFolds:
    """The search for folds within one colour by what looks different between two photos; ``classes`` is the later one as
    finely as its classes are known.
    """

    def __init__(self, seen: Differences, classes: Scene) -> None:
        self.seen, self.paper, self.scene, self.motion = seen, seen.paper, seen.after, seen.now
        self.classes = classes
        self.layers = MovableLayers(seen.paper)
        self.still = seen.unexplained(seen.paper)

    @property
    def nothing_traced(self) -> bool:
        """Whether so little looks different that nothing was folded, or what was is told by lines alone."""
        return self.still < LEAST_TRACE

    def weighed(self, plans: Sequence[Plan]) -> list[Plan]:
        """Plans by falling score, the best with what they explain of what looks different."""
        ranked = best_first(plans)
        if self.nothing_traced:
            return ranked
        return [*map(self.judged, ranked[:JUDGED]), *ranked[JUDGED:]]

    def plans(self) -> list[Plan]:
        """The folds found as plans, not measured yet."""
        return [
            Plan(
                fold.actions,
                "fold",
                fold.paper,
                self.motion,
                0.0,
                "a fold within one colour explains what looks different",
            ).noting(
                narrow_strip=float(is_thin(self.paper, fold.moving)), free_line=float(fold.looseness == FREE)
            )
            for fold in ([] if self.nothing_traced else self.run()[:KEPT])
        ]

    def judged(self, plan: Plan) -> Plan:
        """A plan that moves a part of the paper, with what it explains of what looks different: half of it counts a quarter."""
        if not plan.creases or plan.moves_all:
            return plan
        explained = self.still - self.seen.unexplained(plan.paper)
        share = explained / self.still if explained > LEAST_EXPLAINED else 0.0
        return plan.noting(explained_change=share**2)

    def run(self) -> list[SameColourFold]:
        """Folds that explain what looks different better than no fold does, best first; lines that were constructed
        before others that explain hardly more.
        """
        made = [fold for moving, looseness in self._promising() for fold in self._made(moving, looseness)]
        best = sorted(made, key=self._rank)
        refined = [better for fold in best[:KEPT] if fold.looseness for better in self._refined(fold)]
        return sorted((f for f in (*best, *refined) if f.unexplained < self.still), key=self._rank)

    def _rank(self, fold: SameColourFold) -> float:
        return fold.unexplained + fold.looseness * self.still

    def _promising(self) -> list[tuple[MovingSet, float]]:
        """Lines and layers whose borders run along the trace, and how loose the line is."""
        calm = self.classes.agreement(face_stack(self.paper), self.motion) - CALM
        rated = sorted(
            (
                (self._rating(moving), moving, self._looseness(moving.line, otherwise))
                for lines, otherwise in (
                    (landmark_lines(self.paper), CONSTRUCTED),
                    (np.concatenate([self._aligned(), self._traced()]), FREE),
                )
                for row in both_ways(self._showing(lines))
                for moving in self.layers.moving_sets(as_line(row))
            ),
            key=lambda entry: -entry[0],
        )
        alike = (
            (moving, looseness)
            for _, moving, looseness in rated[:LOOKED_AT]
            if self.classes.agreement(self.layers.folded(moving), self.motion) >= calm
        )
        return list(islice(alike, TRIED))

    def _showing(self, lines: Lines) -> Lines:
        """Those of too many lines (n, 3) along which a bit looks different, as it mostly does along the crease of a fold."""
        if len(lines) <= MOST_TRACE_LINES:
            return lines
        across = lines[:, :2]
        along = np.stack([across[:, 1], -across[:, 0]], axis=1)
        steps = np.arange(-FARTHEST_LINE, FARTHEST_LINE, SPACING)
        feet = across * (lines[:, 2] - across @ MIDDLE)[:, None] + MIDDLE
        points = feet[:, None] + along[:, None] * steps[:, None]
        shown = self.scene.grid.under(transformed(points, self.motion), self.seen.shown)
        return np.asarray(lines[shown.sum(axis=1) * SPACING >= LEAST_CREASE])

    @cached_property
    def _axes(self) -> Lines:
        return axes_of(self.paper)

    def _looseness(self, line: Line, otherwise: float) -> float:
        """At most ALIGNED for a line square to an axis of symmetry."""
        aligned = (np.abs(self._axes[:, :2] @ (line.nx, line.ny)) < PERPENDICULAR).any()
        return min(otherwise, ALIGNED) if aligned else otherwise

    def _aligned(self) -> Lines:
        """Lines parallel or square to an edge, (n, 3)."""
        return lines_across(self.paper, edge_directions(self.paper), SPACING)

    def _traced(self) -> Lines:
        """Lines along which something looks different, the longest, (n, 3)."""
        marked = (self.seen.trace > TRACE_CLEARNESS).astype(np.uint8)
        least = TRACE_LENGTH * self.scene.grid.pixels_per_unit
        found = cv2.HoughLinesP(
            marked, 1, pi / 180, int(least / 2), minLineLength=least, maxLineGap=least / 3
        )
        if found is None:
            return np.empty((0, 3))
        ends = transformed(self.scene.grid.to_plane(found.reshape(-1, 2, 2)), self.motion.inverse())
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        longest = ends[np.argsort(-lengths, kind="stable")[:MOST_TRACED]]
        return np.array([line_through(tuple(p), tuple(q)) for p, q in longest.tolist()])

    def _rating(self, moving: MovingSet) -> float:
        """Pixels of the trace on and around what a fold turns, less those of its border that leave none."""
        turned = [clip(self.layers.outlines[face], moving.line) for face in moving.faces]
        now = draw_touched(turned, self.scene.grid, self.motion.after(mirror(moving.line)))
        then = draw_touched(turned, self.scene.grid, self.motion)
        rim = (now > 0) & (cv2.erode(now, square(1)) == 0) & self.seen.judged
        explained = self.seen.trace[near((now | then) > 0, BORDER_REACH)].sum()
        return float(explained) / ACROSS - TRACELESS_COST * float((1 - self.seen.shown[rim]).sum())

    def _made(self, moving: MovingSet, looseness: float) -> Iterator[SameColourFold]:
        """A fold as real actions, measured."""
        for actions, folded in realise(self.paper, moving, exact=looseness < FREE):
            yield SameColourFold(moving, actions, folded, self.seen.unexplained(folded), looseness)

    def _refined(self, fold: SameColourFold) -> Iterator[SameColourFold]:
        """The fold with its crease moved to where least is left unexplained: by both ends, and as a whole if it is aligned."""
        yield self._climbed(fold, (STEP, STEP), FREE)
        if fold.looseness == ALIGNED:
            yield self._climbed(fold, (STEP,), ALIGNED)

    def _climbed(self, fold: SameColourFold, steps: Vector, looseness: float) -> SameColourFold:
        """The fold with its crease moved by its two ends, or as a whole if there is one step."""
        handles = handles_of(self.layers, fold.moving)
        tried: dict[Vector, SameColourFold] = {}

        def value(x: Vector) -> float:
            moving = self.layers.moving_from(
                shifted(handles, fold.moving.line, x[0], x[-1]), fold.moving.seed
            )
            made = list(self._made(moving, looseness)) if moving else []
            if not made:
                return -self.still
            tried[x] = min(made, key=lambda f: f.unexplained)
            return -tried[x].unexplained

        best, _ = climb(value, (0.0,) * len(steps), steps, 2)
        return tried.get(best, fold)
