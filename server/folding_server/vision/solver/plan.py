"""A plan: the actions that would explain a transition, and how well they do."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log

from folding_schemas.actions import Action
from folding_schemas.results import ActionClass

from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.evidence import NOTHING_NOTED, Evidence, terms

FREE_TURN = 6.0
"""Degrees by which people turn the sheet without meaning to."""
FREE_SCALE_CHANGE = {"held": 0.01, "standing": 0.007}
"""Logarithm of a change of scale between two photos that says nothing, under a camera in the hand and under one that stands."""


@dataclass(frozen=True)
class Plan:
    """Primitives to apply in order, the paper they lead to, and the motion under which it explains the photo.

    ``agreement`` is the share of paper pixels explained, 0 to 1; ``noted`` is what else was measured. ``beside`` is what a fold
    makes that was aimed at the same and explains more, if there is one.
    """

    actions: tuple[Action, ...]
    action_class: ActionClass
    paper: Paper
    motion: Similarity
    agreement: float
    explanation: str
    noted: Evidence = NOTHING_NOTED
    beside: Paper | None = None

    def noting(self, **values: float) -> "Plan":
        """The plan with other values of some terms of evidence."""
        return replace(self, noted=replace(self.noted, **values))

    @property
    def evidence(self) -> Evidence:
        """All terms: what was ``noted``, the agreement, and what the actions themselves say."""
        counts = Counter(action.action for action in self.actions)
        return replace(
            self.noted,
            agreement=self.agreement,
            nothing_happened=float(not self.actions),
            folds=float(counts["fold"]),
            unfolds=float(counts["unfold"]),
            rotations=float(counts["rotate"]),
            flips=float(counts["flip"]),
            diagonal_flips=float(sum(a.action == "flip" and a.axis in ("y=x", "y=-x") for a in self.actions)),
            added_vertices=float(counts["add_vertex"]),
            several_creasing_actions=float(self.action_class == "compound" and self.creases),
        )

    @property
    def score(self) -> float:
        """Agreement, and what else speaks for the plan, less what speaks against it, in shares of the paper."""
        return self.evidence.score

    @property
    def drift(self) -> float:
        """What it costs that the sheet drifted so far and changed its scale so much."""
        return -self.noted.of("scale_change_held", "scale_change_standing", "drift_turn")

    @property
    def scaled(self) -> bool:
        """Whether the sheet looks larger or smaller than in the photo before."""
        return bool(self.noted.scale_change_held or self.noted.scale_change_standing)

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
        return self.agreement + self.noted.of("inner_lines")


def scale_change(ratio: float, handheld: bool) -> dict[str, float]:
    """The terms that say that the sheet looks ``ratio`` times as large as in the photo before."""
    camera = "held" if handheld else "standing"
    change = max(0.0, abs(log(ratio)) - FREE_SCALE_CHANGE[camera])
    return {"scale_change_held": 0.0, "scale_change_standing": 0.0, f"scale_change_{camera}": change}


def scale_change_cost(ratio: float, handheld: bool) -> float:
    """What it costs, in shares of the paper, that the sheet looks ``ratio`` times as large as in the photo before."""
    camera = "held" if handheld else "standing"
    return -terms()[f"scale_change_{camera}"].weight * scale_change(ratio, handheld)[f"scale_change_{camera}"]


def best_first(plans: Sequence[Plan]) -> list[Plan]:
    """Plans by falling score; equal ones in the order given."""
    return sorted(plans, key=lambda plan: -plan.score)
