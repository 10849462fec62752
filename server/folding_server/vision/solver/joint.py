"""Two folds of one keyframe refined together.

The first is found by the part of the change that it explains, while the sheet's drift is not yet known for sure; with
the second in place, both creases and the drift are moved at once until all of the photo is explained best.
"""

from dataclasses import dataclass, replace

from folding_schemas.actions import Actions

from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.labels import LabelImage
from folding_server.vision.registration.alignment import Vector, nudged, polished
from folding_server.vision.registration.scene import Views
from folding_server.vision.solver.creases import handles_of, shifted
from folding_server.vision.solver.fold_search import FoldFound
from folding_server.vision.solver.movable_layers import MovableLayers
from folding_server.vision.solver.plan import scale_change_cost
from folding_server.vision.solver.realise import realise


@dataclass(frozen=True)
class FoldMade:
    """A fold that was found, the actions that make it, and the paper they lead to."""

    found: FoldFound
    actions: Actions
    paper: Paper


class TwoFolds:
    """Two folds, one after the other, that can be moved a little: the photo decides where they belong."""

    def __init__(self, paper: Paper, views: Views, first: FoldMade, second: FoldFound) -> None:
        self.paper, self.views, self.first, self.second = paper, views, first, second
        self._layers = MovableLayers(paper)
        self._first_handles = handles_of(self._layers, first.found.moving)
        self._second_handles = handles_of(MovableLayers(first.paper), second.moving)
        self._center = self._first_handles[0]

    def refined(self) -> tuple[FoldMade, FoldFound] | None:
        """The two folds where they explain the photo best; None if that is where they are."""
        start: Vector = (0.0,) * 8
        scene, pixel = self.views.fine, 1.0 / self.views.fine.grid.pixels_per_unit
        steps = (2 * pixel, 2 * pixel, pixel, pixel, pixel, pixel, 100 * pixel, 2 * pixel)
        before = self._value(start)
        best, after = polished(self._drawn, self._value, scene, start, before, steps)
        moved = self._moved(best, exact=False) if after > before else None
        if moved is None:
            return None
        first, second = moved
        return first, replace(second, agreement=after)

    def _value(self, x: Vector) -> float:
        scale = self._motion(x).scale / self.first.found.motion.scale
        return self.views.fine.agreement_of(self._drawn(x)) - scale_change_cost(scale, self.views.handheld)

    def _drawn(self, x: Vector) -> LabelImage:
        """What both folds look like, moved; without the second if it cannot be made."""
        moved = self._moved(x, exact=True)
        if moved is None:
            return self.views.fine.draw(self._layers.folded(self.first.found.moving), self._motion(x))
        first, second = moved
        return self.views.fine.draw(MovableLayers(first.paper).folded(second.moving), self._motion(x))

    def _moved(self, x: Vector, *, exact: bool) -> tuple[FoldMade, FoldFound] | None:
        """Both folds with the ends of their creases moved; None if they cannot be made there."""
        old, later = self.first.found, self.second
        moving = self._layers.moving_from(
            shifted(self._first_handles, old.moving.line, x[0], x[1]), old.moving.seed
        )
        made = realise(self.paper, moving, exact=exact) if moving else []
        if not made or later.moving.seed not in made[0][1].faces:
            return None
        line = shifted(self._second_handles, later.moving.line, x[2], x[3])
        turned = MovableLayers(made[0][1]).moving_from(line, later.moving.seed)
        if moving is None or turned is None:
            return None
        motion = self._motion(x)
        return FoldMade(FoldFound(moving, motion, 0.0), *made[0]), replace(
            later, moving=turned, motion=motion
        )

    def _motion(self, x: Vector) -> Similarity:
        return nudged(self.second.motion, self._center, x[4:])
