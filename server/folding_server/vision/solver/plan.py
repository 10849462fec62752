"""A plan: the actions that would explain a transition, and how well they do."""

from collections.abc import Sequence
from dataclasses import dataclass

from folding_schemas.actions import Action
from folding_schemas.results import ActionClass

from folding_server.simulator.paper import Paper
from folding_server.simulator.plane_geometry import Isometry

COST = {"fold": 0.003, "unfold": 0.002, "rotate": 0.002, "flip": 0.0025, "add_vertex": 0.0003}
"""What an action must gain in agreement to be worth taking: the simpler explanation wins a tie."""
COMPOUND_COST = 0.008
"""Keyframes are mostly one action apart."""
NOTHING_HAPPENED = 0.006
"""Keyframes are chosen because something changed, so doing nothing must clearly be the best."""


ZOOM_COST, FREE_ZOOM = 0.1, 0.01
"""A change of scale between two photos costs this much per unit of its logarithm, beyond the free part."""


UNSEEN_COST = 0.01
"""Of explanations that look like nothing at all, a fold is the least likely: people show what they fold."""
LINE_COST = 0.02
"""What it costs when no layer border that a plan predicts is seen, or all lines seen are others."""


@dataclass(frozen=True)
class Plan:
    """Primitives to apply in order, the paper they lead to, and the motion under which it explains the photo.

    ``agreement`` is the share of paper pixels explained, 0 to 1; ``score`` is that less the cost of the actions.
    """

    actions: tuple[Action, ...]
    action_class: ActionClass
    paper: Paper
    motion: Isometry
    agreement: float
    explanation: str
    zoom: float = 0.0
    contradiction: float = 0.0
    unseen: bool = False

    @property
    def score(self) -> float:
        """Agreement less the cost of the actions, of the camera's coming nearer and of lines that contradict.

        ``zoom`` is the logarithm of the change of scale, ``contradiction`` that of the inner lines, 0 to 2; ``unseen``
        marks a fold that the photo does not show.
        """
        cost = sum(COST[a.action] for a in self.actions) if self.actions else NOTHING_HAPPENED
        if self.action_class == "compound":
            cost += COMPOUND_COST
        zoom = ZOOM_COST * max(0.0, abs(self.zoom) - FREE_ZOOM)
        return self.looks - cost - zoom - (UNSEEN_COST if self.unseen else 0.0)

    @property
    def looks(self) -> float:
        """Agreement less what the lines inside the paper say against the plan."""
        return self.agreement - LINE_COST * self.contradiction


def best_first(plans: Sequence[Plan]) -> list[Plan]:
    """Plans by falling score; equal ones in the order given."""
    return sorted(plans, key=lambda plan: -plan.score)
