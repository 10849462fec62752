"""What the geometric search has seen so far: proposals and trials by frame and by the steps they
grew from.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import takewhile

from folding_schemas.actions import Action
from folding_schemas.results import Proposal, RunInfo

Actions = tuple[Action, ...]
Lineage = tuple[Actions, ...]
"""The steps that lead from the flat sheet to the checkpoint something grew from."""

NEAR = 0.02
"""An explanation is a rival of another if its agreement with the photo is at most so much lower."""
LOOK_BACK = 3
"""How many frames back a mistake is looked for."""
RETREATS = 2
"""How often one frame may send the search back."""


@dataclass(frozen=True)
class Trial:
    """An explanation that was carried out and compared; agreement -1 if it could not be carried out."""

    frame: int
    lineage: Lineage
    actions: Actions
    agreement: float
    matches: bool


@dataclass(frozen=True)
class Retreat:
    """Go back to ``lineage`` and explain ``frame`` by ``actions`` instead."""

    frame: int
    lineage: Lineage
    actions: Actions


@dataclass
class Memory:
    """Proposals and trials, what is planned for coming frames, and how often each frame sent the
    search back.
    """

    proposals: dict[tuple[int, Lineage], tuple[Proposal, ...]] = field(default_factory=dict)
    trials: list[Trial] = field(default_factory=list)
    plan: dict[int, tuple[Lineage, Actions]] = field(default_factory=dict)
    retreats: dict[int, int] = field(default_factory=dict)

    def planned(self, frame: int, lineage: Lineage) -> Actions | None:
        """What is planned for a frame, which is then no longer planned; None if the plan was for other steps
        before.
        """
        before, actions = self.plan.pop(frame, (None, None))
        return actions if before == lineage else None

    def untried(self, frame: int, lineage: Lineage) -> list[Proposal]:
        """The proposals for a frame that were not carried out from there yet, best first."""
        tried = {trial.actions for trial in self.trials if (trial.frame, trial.lineage) == (frame, lineage)}
        return [
            proposal
            for proposal in self.proposals.get((frame, lineage), ())
            if tuple(proposal.actions) not in tried
        ]

    def visited(self, frame: int) -> bool:
        """Whether anything was tried at the frame."""
        return any(trial.frame == frame for trial in self.trials)

    def best(self, info: RunInfo) -> Trial | None:
        """The trial at the next frame that agreed best, the earliest of equals; None if none could be carried out.

        A trial that grew from other steps than those committed for good cannot be gone back to.
        """
        frame = info.next_frame or 0
        kept = lineage_of(info, max(info.locked_to, 1) + 1)
        done = [
            trial
            for trial in self.trials
            if trial.frame == frame and trial.agreement >= 0 and trial.lineage[: len(kept)] == kept
        ]
        return max(done, key=lambda trial: trial.agreement, default=None)

    def retreat(self, info: RunInfo) -> Retreat | None:
        """The rival explanation of an earlier, open frame that is nearest to the one chosen; None if there is
        none left, or the frame at hand has sent the search back often enough.
        """
        frame = info.next_frame or 0
        if self.retreats.get(frame, 0) >= RETREATS:
            return None
        first = max(info.locked_to + 1, frame - LOOK_BACK, 2)
        rivals = [
            rival for earlier in range(frame - 1, first - 1, -1) for rival in self._rivals(earlier, info)
        ]
        if not rivals:
            return None
        self.retreats[frame] = self.retreats.get(frame, 0) + 1
        return min(rivals, key=lambda rival: rival[0])[1]

    def _rivals(self, frame: int, info: RunInfo) -> list[tuple[float, Retreat]]:
        """Untried explanations of a saved frame, each with how much worse it is than the one chosen."""
        steps = lineage_of(info, frame + 1)
        lineage, chosen = steps[:-1], steps[-1]
        if info.attempts.get(frame, 0) >= info.budget:
            return []
        known = {tuple(p.actions): p.agreement for p in self.proposals.get((frame, lineage), ())}
        reached = known.get(chosen, max(known.values(), default=0.0))
        return [
            (reached - rival.agreement, Retreat(frame, lineage, tuple(rival.actions)))
            for rival in self.untried(frame, lineage)
            if reached - rival.agreement <= NEAR
        ]


def lineage_of(info: RunInfo, frame: int) -> Lineage:
    """The steps of the run's program up to checkpoint ``frame - 1``."""
    return tuple(tuple(step) for step in info.program.steps[: frame - 2])


def common_length(one: Sequence[Actions], other: Sequence[Actions]) -> int:
    """How many steps two lineages share from the start."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(one, other, strict=False)))
