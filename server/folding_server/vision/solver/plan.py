"""A plan: the actions that would explain a transition, and how well they do."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import log

from folding_schemas.actions import Action
from folding_schemas.results import ActionClass

from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper

COST = {"fold": 0.003, "unfold": 0.002, "rotate": 0.0035, "flip": 0.0025, "add_vertex": 0.0003}
"""What an action must gain in agreement to be worth taking: the simpler explanation wins a tie."""
SLANTED_COST = 0.0015
"""Paper is flipped over sideways or upwards; over a diagonal only if that shows."""
COMPOUND_COST = 0.008
"""Keyframes are mostly one action apart."""
IDLE_TURN_COST = 0.002
"""A turn by which nothing seems to change is not what a photo is taken of."""
NOTHING_HAPPENED = 0.008
"""Keyframes are chosen because something changed, so doing nothing must clearly be the best."""


ZOOM_COST = {"held": (0.1, 0.01), "still": (0.8, 0.007)}
"""What a change of scale between two photos costs per unit of its logarithm, and what is free, under a camera in the
hand and under one that stands still.
"""
TURN_COST, FREE_TURN = 0.0005, 6.0
"""A turn of the sheet that no action accounts for costs this much a degree, beyond the free part."""
UNSEEN_COST = 0.01
"""Of explanations that look like nothing at all, a fold is the least likely: people show what they fold."""
THIN_COST = 0.012
"""What it costs to fold nothing but a narrow strip."""
FRESH_COST = 0.003
"""What it costs to make a new crease: those that are there were mostly made to be folded along."""
LOOSE_COST = 0.0005
"""What it costs that no construction gives the line of the last fold."""
SLIVER_COST = 0.006
"""What it costs to crease the paper a hair beside an edge or another crease."""
SWING_COST = 0.02
"""What it costs when all of the paper moved otherwise than planned in the images between two photos."""
TRACE_WORTH = 0.008
"""What it is worth to explain all that looks different within one colour; half of it is worth a quarter."""
UNSEEN_LINES_COST = 0.02
"""What it costs when no layer border that a plan predicts is seen, or all lines seen are others."""


@dataclass(frozen=True)
class Plan:
    """Primitives to apply in order, the paper they lead to, and the motion under which it explains the photo.

    ``agreement`` is the share of paper pixels explained, 0 to 1; ``score`` is that less the cost of the actions.
    """

    actions: tuple[Action, ...]
    action_class: ActionClass
    paper: Paper
    motion: Similarity
    agreement: float
    explanation: str
    zoom: float = 0.0
    turned: float = 0.0
    contradiction: float = 0.0
    unseen: float = 0.0
    swing: float = 0.0
    thin: bool = False
    traced: float = 0.0
    idle: float = 0.0
    loose: bool = False
    fresh: bool = False
    sliver: bool = False
    regret: float = 0.0
    framing: float = 0.0

    @property
    def score(self) -> float:
        """Agreement less the cost of the actions, of changes of scale and angle, and of what else speaks against the plan.

        ``zoom`` is what the change of scale costs, ``turned`` the angle in degrees by which the sheet drifted,
        ``contradiction`` that of the inner lines, 0 to 2; ``swing`` is the share of the paper, 0 to 1, that moved
        otherwise in the images in between; ``traced`` the share, 0 to 1, that a fold within one colour explains of what
        looks different there. From 0 to 1, ``unseen`` is how far the photo shows nothing of a fold, and ``idle`` how far it
        shows nothing of a turn. Of the last fold, ``thin`` says that it turns nothing but a narrow strip, ``fresh`` that it makes new creases, ``loose``
        that no construction gives its line, and ``sliver`` that it cuts a long sliver off a face. ``regret`` is how much
        worse than after an equal plan the next photo is explained after this one. ``framing`` is what it costs that the
        camera stands as the plan needs it.
        """
        cost = sum(map(_cost, self.actions)) if self.actions else NOTHING_HAPPENED
        if self.action_class == "compound" and self.creases:
            cost += COMPOUND_COST
        cost += SWING_COST * self.swing
        doubts = UNSEEN_COST * self.unseen + IDLE_TURN_COST * self.idle
        crease = FRESH_COST * self.fresh + LOOSE_COST * self.loose + THIN_COST * self.thin
        crease += SLIVER_COST * (self.sliver and not self.thin)
        return (
            self.looks
            - cost
            - self.drift
            - doubts
            - crease
            - self.regret
            - self.framing
            + TRACE_WORTH * self.traced**2
        )

    @property
    def drift(self) -> float:
        """What it costs that the sheet drifted so far and changed its scale so much."""
        return self.zoom + TURN_COST * max(0.0, self.turned - FREE_TURN)

    @property
    def creases(self) -> bool:
        """Whether an action folds or unfolds something."""
        return any(action.action in ("fold", "unfold") for action in self.actions)

    @property
    def moves_all(self) -> bool:
        """Whether an action turns the whole over or about."""
        return any(action.action in ("rotate", "flip") for action in self.actions)

    @property
    def looks(self) -> float:
        """Agreement less what the lines inside the paper say against the plan."""
        return self.agreement - UNSEEN_LINES_COST * self.contradiction


def _cost(action: Action) -> float:
    """What an action must gain."""
    slanted = action.action == "flip" and action.axis in ("y=x", "y=-x")
    return COST[action.action] + SLANTED_COST * slanted


def zoom_cost(ratio: float, handheld: bool) -> float:
    """What it costs that the sheet looks ``ratio`` times as large as in the photo before."""
    rate, free = ZOOM_COST["held" if handheld else "still"]
    return rate * max(0.0, abs(log(ratio)) - free)


def best_first(plans: Sequence[Plan]) -> list[Plan]:
    """Plans by falling score; equal ones in the order given."""
    return sorted(plans, key=lambda plan: -plan.score)
